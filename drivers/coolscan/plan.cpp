#include "drivers/coolscan/plan.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "drivers/coolscan/window.h"
#include "drivers/negotiating.h"

namespace reseau::coolscan {
namespace {

class Negotiation : private Negotiating {
 public:
  Negotiation(const ScanRequest& request, const UnitDescription& unit)
      : Negotiating(request), unit_(unit), a_(unit.addresses) {
    max_dpi_ = a_.max_dpi;
  }

  Negotiated run() {
    if (a_.max_dpi <= 0 || a_.max_width_px <= 0 || a_.max_height_px <= 0) {
      throw InputError(
          "The scanner does not say what it can scan: no film adapter is in it. Push "
          "the adapter in until it locks.");
    }
    if (request_.overview) return overview();
    resolution();
    settle_depth(depths_of(unit_));
    settle_channels(unit_.infrared);
    readings();
    sensor();
    area();
    focus();
    exposure();
    return std::move(result_);
  }

 private:
  void resolution() {
    const int asked = request_.resolution_dpi.value_or(a_.max_dpi);
    if (asked <= 0) throw InputError("The resolution must be a number above 0 dpi.");
    plan_.pitch = pitch_for(a_, asked);
    plan_.resolution_dpi = a_.max_dpi / plan_.pitch;
    if (plan_.resolution_dpi != asked) {
      adjust("resolution", std::to_string(asked) + " dpi",
             std::to_string(plan_.resolution_dpi) + " dpi",
             asked > a_.max_dpi ? "the sensor has no more pixels"
                                : "the scanner offers whole divisors of " +
                                      std::to_string(a_.max_dpi) + " dpi only; the next finer one");
    }
    plan_.format.x_dpi = plan_.format.y_dpi =
        static_cast<double>(a_.max_dpi) / static_cast<double>(plan_.pitch);
  }

  void readings() {
    const int most = max_readings(unit_);
    if (request_.samples < 1) throw InputError("The number of samples must be at least 1.");
    plan_.samples = std::min(request_.samples, most);
    if (plan_.samples == request_.samples) return;
    adjust("samples", std::to_string(request_.samples), std::to_string(plan_.samples),
           most == 1 ? "this scanner reads each line once" : "the scanner reads a line no oftener");
  }

  void sensor() {
    const int lines = sensor_lines(a_, unit_.windows);
    // The lines lie line_gap optical lines apart; a pass fills the gaps where they are whole lines.
    const bool possible = lines > 1 && a_.line_gap > 0 && a_.line_gap % plan_.pitch == 0;
    // Which of two lines is the earlier one no user has confirmed; three are known to be right, and
    // one of them alone takes three times as long.
    const bool wanted = request_.sensor_lines == SensorLines::kAll ||
                        (request_.sensor_lines == SensorLines::kAuto && lines > 2);
    plan_.sensor_lines = wanted && possible ? lines : 1;
    if (request_.sensor_lines == SensorLines::kAll && !possible) {
      adjust("sensor lines", "all", "one",
             lines == 1 ? "there is no other in this scanner's pass"
                        : "at this resolution the lines of the sensor do not interleave");
    }
  }

  // One after the last address that a window may reach; 0 when the unit does not say yet.
  [[nodiscard]] int y_end_px() const { return a_.y_origin_max_px > 0 ? a_.y_origin_max_px + 1 : 0; }

  FrameRectangle frame() {
    const std::vector<FrameRectangle> frames = frames_of(unit_);
    settle_frame(static_cast<int>(frames.size()), "this adapter holds one frame.");
    const auto index = static_cast<std::size_t>(plan_.frame - 1);
    FrameRectangle place = frames[index];
    move(place, index);
    return place;
  }

  void move(FrameRectangle& place, std::size_t index) {
    const double asked_mm = request_.frame_offset_mm;
    if (asked_mm == 0) return;
    constexpr double kMost = 40;
    if (!std::isfinite(asked_mm) || std::abs(asked_mm) > kMost) {
      throw InputError("A frame can be moved by 40 mm at most.");
    }
    const int asked = px_from_mm(asked_mm, a_.max_dpi, "frame offset");
    const int before = place.top_px;
    if (index < unit_.strip.size() && unit_.duties.set_frame_table) {
      place.top_px = moved_on_film(unit_, unit_.strip[index], asked).address_px;
    } else {
      const int most = y_end_px() > 0 ? y_end_px() - place.height_px : before + asked;
      place.top_px =
          std::clamp(before + asked, a_.y_origin_min_px, std::max(most, a_.y_origin_min_px));
    }
    plan_.frame_offset_px = place.top_px - before;
    if (std::abs(plan_.frame_offset_px - asked) <= units_per_pulse(a_.max_dpi)) return;
    adjust("frame offset", text_of(asked_mm, "mm"),
           text_of(plan_.frame_offset_px * kMmPerInch / a_.max_dpi, "mm"), "the film ends there");
  }

  void area() {
    const FrameRectangle place = frame();
    frame_left_px_ = place.left_px;
    frame_top_px_ = place.top_px;
    // A window past the boundary can drive the stage against its stop.
    int height_px = place.height_px;
    if (y_end_px() > 0) height_px = std::min(height_px, y_end_px() - frame_top_px_);
    const int width_px =
        std::min({place.width_px, a_.max_width_px, a_.x_end_px() - frame_left_px_});
    if (height_px < plan_.pitch || width_px < plan_.pitch) {
      throw InputError("Frame " + std::to_string(plan_.frame) + " lies beyond the film.");
    }
    const AreaRequest& asked = request_.area;
    x_ = fit(asked.left_mm, asked.width_mm, width_px, Rest::kKept, "left edge", "width");
    y_ = fit(asked.top_mm, asked.height_mm, height_px, Rest::kKept, "top edge", "height");
    along();
    across();
  }

  void along() {
    const int first = frame_top_px_ + y_.first, end = first + y_.length;
    plan_.y_origin_px = first;
    plan_.window_height_px = y_.length;
    plan_.format.n_lines = y_.length / plan_.pitch;
    if (plan_.sensor_lines < 3) return;
    // Whole blocks of interleaved lines, inside the boundary.
    const int block = plan_.sensor_lines * a_.line_gap;
    const int limit = (y_end_px() > 0 ? y_end_px() : a_.max_height_px) / block * block;
    int begin = first / block * block;
    int stop = std::min((end + block - 1) / block * block, limit);
    stop = std::min(stop, begin + a_.max_height_px / block * block);
    begin = std::min(begin, std::max(stop - block, 0));
    plan_.y_origin_px = begin;
    plan_.window_height_px = stop - begin;
    plan_.crop_top_lines =
        std::clamp((first - begin) / plan_.pitch, 0, (stop - begin) / plan_.pitch - 1);
    const int rest = (stop - begin) / plan_.pitch - plan_.crop_top_lines;
    plan_.format.n_lines = std::min(plan_.format.n_lines, rest);
  }

  void across() {
    const int first = frame_left_px_ + x_.first, end = first + x_.length;
    const bool unit_crops = a_.x_origin_max_px > a_.x_origin_min_px;
    if (unit_crops && plan_.sensor_lines < 3) {
      plan_.x_origin_px = first;
      plan_.window_width_px = x_.length;
      plan_.format.width_px = x_.length / plan_.pitch;
      return;
    }
    plan_.x_origin_px = a_.x_origin_min_px;
    plan_.window_width_px = a_.max_width_px;
    if (unit_crops) {
      const int step = a_.line_gap;
      plan_.x_origin_px = first / step * step;
      const int whole = (end - plan_.x_origin_px + step - 1) / step * step;
      plan_.window_width_px = std::min({whole, a_.max_width_px, a_.x_end_px() - plan_.x_origin_px});
    }
    const int line_px = plan_.window_width_px / plan_.pitch;
    const int left = first - plan_.x_origin_px;
    plan_.crop_left_px = std::min(left / plan_.pitch, line_px - 1);
    const int right = (left + x_.length + plan_.pitch - 1) / plan_.pitch;
    plan_.format.width_px = std::min(right, line_px) - plan_.crop_left_px;
  }

  // The whole strip as the unit's own thumbnail, or everything at a low resolution.
  Negotiated overview() {
    plan_.overview = true;
    plan_.infrared = false;
    plan_.depth_bits = depths_of(unit_).back();
    plan_.focus.mode = FocusRequest::Mode::kKeep;
    plan_.format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
    plan_.format.significant_bits = plan_.depth_bits;
    plan_.window_width_px = a_.max_width_px;
    if (has_thumbnails(unit_)) {
      plan_.pitch = std::max(1, a_.max_dpi / a_.thumbnail_dpi);
      plan_.resolution_dpi = a_.thumbnail_dpi;
      plan_.y_origin_px = a_.y_origin_min_px;
      plan_.window_height_px = a_.y_origin_max_px;
      // Of strip film a line is six pulses, whatever the resolution is called.
      constexpr int kPulsesPerLine = 6;
      plan_.format.y_dpi =
          static_cast<double>(a_.max_dpi) /
          (a_.film_addresses ? kPulsesPerLine * units_per_pulse(a_.max_dpi) : plan_.pitch);
    } else {
      constexpr int kOverviewDpi = 285;
      plan_.pitch = pitch_for(a_, kOverviewDpi);
      plan_.resolution_dpi = a_.max_dpi / plan_.pitch;
      plan_.x_origin_px = a_.x_origin_min_px;
      plan_.y_origin_px = a_.y_origin_min_px;
      plan_.window_height_px = a_.max_height_px;
      if (y_end_px() > 0) {
        plan_.window_height_px = std::min(a_.max_height_px, y_end_px() - a_.y_origin_min_px);
      }
      plan_.format.y_dpi = static_cast<double>(a_.max_dpi) / plan_.pitch;
    }
    plan_.format.x_dpi = static_cast<double>(a_.max_dpi) / plan_.pitch;
    plan_.format.width_px = plan_.window_width_px / plan_.pitch;
    plan_.format.n_lines = plan_.window_height_px / plan_.pitch;
    exposure();
    return std::move(result_);
  }

  void focus() {
    plan_.focus = request_.focus;
    FocusRequest& focus = plan_.focus;
    if (focus.mode == FocusRequest::Mode::kPosition) {
      const int asked = focus.position;
      focus.position = std::clamp(asked, a_.focus_min, a_.focus_max);
      if (focus.position != asked) {
        adjust("focus", std::to_string(asked), std::to_string(focus.position),
               "the focus range of the scanner ends there");
      }
    }
    if (focus.mode != FocusRequest::Mode::kAuto) return;
    // The middle of the area, truncating, as Nikon Scan does.
    plan_.focus_x_px = frame_left_px_ + x_.first + x_.length / 2;
    plan_.focus_y_px = frame_top_px_ + y_.first + y_.length / 2;
    if (focus.x_mm) {
      plan_.focus_x_px = frame_left_px_ + focus_point(*focus.x_mm, a_.x_end_px() - frame_left_px_,
                                                      "focus point, across");
    }
    if (focus.y_mm) {
      plan_.focus_y_px =
          frame_top_px_ + focus_point(*focus.y_mm, a_.max_height_px, "focus point, along");
    }
  }

  int focus_point(double mm, int limit, const char* field) {
    const int asked = px_from_mm(mm, a_.max_dpi, field);
    const int granted = std::clamp(asked, 0, limit - 1);
    if (granted != asked) note_end(field, mm, granted);
    return granted;
  }

  void exposure() {
    settle_exposure(unit_.windows.exposure_min_10ns / k10nsPerUs,
                    unit_.windows.exposure_max_10ns / k10nsPerUs);
  }

  const UnitDescription& unit_;
  const AddressPage& a_;
  int frame_left_px_ = 0, frame_top_px_ = 0;
  Span x_, y_;
};

}  // namespace

Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit) {
  return Negotiation(request, unit).run();
}

}  // namespace reseau::coolscan
