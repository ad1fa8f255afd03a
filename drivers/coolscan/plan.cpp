#include "drivers/coolscan/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/base/error.h"
#include "drivers/coolscan/window.h"

namespace reseau::coolscan {
namespace {

constexpr double kMmPerInch = 25.4;

std::string text_of(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

// Any finite length a person may type; the result is far inside int.
int px_from_mm(double mm, int dpi, const char* field) {
  if (!std::isfinite(mm) || std::abs(mm) > 1e5) {
    throw InputError(std::string("The ") + field + " of the area is not a usable length.");
  }
  return static_cast<int>(std::lround(mm * dpi / kMmPerInch));
}

// Where a span [first, first + length) lies after it was fitted into [0, limit).
struct Span {
  int first = 0, length = 0;
};

class Negotiation {
 public:
  Negotiation(const ScanRequest& request, const UnitDescription& unit)
      : request_(request), unit_(unit), a_(unit.addresses) {}

  Negotiated run() {
    if (a_.max_dpi <= 0 || a_.max_width_px <= 0 || a_.max_height_px <= 0) {
      throw InputError(
          "The scanner does not say what it can scan: no film adapter is in it. Push "
          "the adapter in until it locks.");
    }
    if (request_.overview) return overview();
    resolution();
    depth();
    channels();
    readings();
    sensor();
    area();
    focus();
    exposure();
    return std::move(result_);
  }

 private:
  void adjust(const std::string& field, const std::string& asked, const std::string& granted,
              const std::string& why) {
    result_.adjusted.push_back({field, asked, granted, why});
  }

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

  void depth() {
    const std::vector<int> offered = depths_of(unit_);
    if (offered.empty() || offered.back() <= 0)
      throw InputError("The scanner does not offer any depth to scan with.");
    const int asked = request_.depth_bits.value_or(offered.back());
    const auto enough = std::lower_bound(offered.begin(), offered.end(), asked);
    plan_.depth_bits = enough == offered.end() ? offered.back() : *enough;
    if (plan_.depth_bits != asked) {
      adjust("depth", std::to_string(asked) + " bits", std::to_string(plan_.depth_bits) + " bits",
             plan_.depth_bits < asked ? "the scanner converts no deeper; samples are scaled to 16 "
                                        "bits"
                                      : "the scanner has no shallower depth that is enough");
    }
    plan_.format.significant_bits = plan_.depth_bits;
  }

  void channels() {
    if (request_.infrared && !unit_.infrared) {
      throw InputError("This scanner has no infrared channel. Ask for a scan without infrared.");
    }
    plan_.infrared = request_.infrared;
    plan_.format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
    if (plan_.infrared) plan_.format.channels.push_back(Channel::kInfrared);
  }

  // Fits one dimension and tells when less than asked is granted. Lengths are whole delivered
  // pixels, rounded up so that all that was asked is covered where there is room.
  Span fit(const std::optional<double>& first_mm, const std::optional<double>& length_mm, int limit,
           const char* first_name, const char* length_name) {
    const int dpi = a_.max_dpi;
    const int asked_first = px_from_mm(first_mm.value_or(0), dpi, first_name);
    if (asked_first >= limit) {
      throw InputError(std::string("The ") + first_name +
                       " of the area lies beyond the frame, which " + "measures " +
                       text_of(limit * kMmPerInch / dpi, "mm") +
                       " in that direction. Give a smaller value.");
    }
    const int first = std::clamp(asked_first, 0, limit - plan_.pitch);
    if (first != asked_first) note(first_name, *first_mm, first);
    if (!length_mm) return {first, limit - first};
    const int asked_length = px_from_mm(*length_mm, dpi, length_name);
    if (asked_length <= 0) {
      throw InputError(std::string("The ") + length_name + " of the area must be above 0 mm.");
    }
    const int whole = (asked_length + plan_.pitch - 1) / plan_.pitch * plan_.pitch;
    const int length = std::min(whole, limit - first);
    if (length < asked_length) note(length_name, *length_mm, length);
    return {first, length};
  }

  void note(const char* field, double asked_mm, int granted_px) {
    adjust(field, text_of(asked_mm, "mm"), text_of(granted_px * kMmPerInch / a_.max_dpi, "mm"),
           "the frame ends there");
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
    const auto n_frames = static_cast<int>(frames.size());
    if (request_.frame < 1 || request_.frame > n_frames) {
      throw InputError("Frame " + std::to_string(request_.frame) + " was asked for, but " +
                       (n_frames == 1
                            ? std::string("this adapter holds one frame.")
                            : "the frames here are 1 to " + std::to_string(n_frames) + "."));
    }
    plan_.frame = request_.frame;
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
    x_ = fit(asked.left_mm, asked.width_mm, width_px, "left edge", "width");
    y_ = fit(asked.top_mm, asked.height_mm, height_px, "top edge", "height");
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
    if (granted != asked) note(field, mm, granted);
    return granted;
  }

  void exposure() {
    plan_.exposure = request_.exposure;
    if (!(plan_.exposure.factor > 0) || !std::isfinite(plan_.exposure.factor)) {
      throw InputError("The exposure factor must be a number above 0.");
    }
    if (plan_.exposure.mode != ExposureRequest::Mode::kFixed) return;
    static constexpr const char* kNames[] = {"red exposure", "green exposure", "blue exposure",
                                             "infrared exposure"};
    const double low_us = unit_.windows.exposure_min_10ns / k10nsPerUs;
    const double high_us = unit_.windows.exposure_max_10ns / k10nsPerUs;
    for (std::size_t i = 0; i < plan_.exposure.exposure_us.size(); ++i) {
      std::optional<double>& us = plan_.exposure.exposure_us[i];
      if (!us) continue;
      if (!std::isfinite(*us) || *us <= 0) {
        throw InputError(std::string("The ") + kNames[i] + " must be a time above 0 us.");
      }
      const double asked = *us;
      us = std::clamp(asked, low_us, high_us);
      if (*us != asked) {
        adjust(kNames[i], text_of(asked, "us"), text_of(*us, "us"),
               "the scanner's exposure range ends there");
      }
    }
  }

  const ScanRequest& request_;
  const UnitDescription& unit_;
  const AddressPage& a_;
  Negotiated result_;
  ScanPlan& plan_ = result_.plan;
  int frame_left_px_ = 0, frame_top_px_ = 0;
  Span x_, y_;
};

int lower_to_rule(PitchRule rule, int line_gap, int pitch) {
  switch (rule) {
    case PitchRule::kOneOrEven:
      return pitch <= 1 ? 1 : pitch - pitch % 2;
    case PitchRule::kDivisorsOfLineGap:
      while (pitch > 1 && (line_gap <= 0 || line_gap % pitch != 0)) --pitch;
      return std::max(pitch, 1);
    default:
      return std::max(pitch, 1);
  }
}

}  // namespace

int pitch_for(const AddressPage& addresses, int resolution_dpi) {
  const int coarsest = addresses.max_dpi / std::max(addresses.min_dpi, 1);
  const int pitch = std::clamp(addresses.max_dpi / std::max(resolution_dpi, 1), 1, coarsest);
  return lower_to_rule(addresses.pitch_rule, addresses.line_gap, pitch);
}

std::vector<FrameRectangle> frames_of(const UnitDescription& unit) {
  const AddressPage& a = unit.addresses;
  std::vector<FrameRectangle> frames = unit.holder;
  for (FrameRectangle& frame : frames) {
    // A strip holder does not know how long its frames are.
    if (frame.width_px <= 0) frame.width_px = a.max_width_px - frame.left_px;
    if (frame.height_px <= 0) frame.height_px = a.max_height_px;
  }
  if (!frames.empty()) return frames;
  const int n = std::clamp(a.frames_present > 0 ? a.frames_present : a.frame_capacity, 1,
                           static_cast<int>(kMaxFrames));
  for (int i = 0; i < n; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const int top_px = index < unit.strip.size() ? unit.strip[index].address_px
                                                 : a.y_origin_min_px + i * a.max_height_px;
    frames.push_back({0, top_px, a.max_width_px, a.max_height_px});
  }
  return frames;
}

std::vector<int> depths_of(const UnitDescription& unit) {
  const int deepest = unit.errata.deepest_bits;
  if (unit.errata.only_addresses) return {8, deepest > 0 ? deepest : unit.addresses.converter_bits};
  return unit.windows.depths_bits();
}

int max_readings(const UnitDescription& unit) {
  constexpr int kMost = 16;  // four bits of the window
  return unit.windows.multiple_readings() && unit.duties.averages_readings ? kMost : 1;
}

bool has_thumbnails(const UnitDescription& unit) {
  return unit.windows.thumbnails() && unit.addresses.thumbnail_dpi > 0 &&
         unit.addresses.y_origin_max_px > 0;
}

FrameRecord moved_on_film(const UnitDescription& unit, const FrameRecord& frame, int by_px) {
  const AddressPage& a = unit.addresses;
  int top = std::max(frame.address_px + by_px, a.y_origin_min_px);
  if (a.y_origin_max_px > 0) {
    top = std::min(top, std::max(a.y_origin_max_px + 1 - a.max_height_px, a.y_origin_min_px));
  }
  return moved(frame, top - frame.address_px, a.max_dpi);
}

Capabilities capabilities_of(const UnitDescription& unit) {
  const AddressPage& a = unit.addresses;
  Capabilities c;
  c.make = unit.inquiry.vendor;
  c.model = unit.inquiry.product;
  c.firmware = unit.inquiry.revision;
  c.serial = unit.serial;
  c.adapter = unit.adapter;
  c.link = unit.link;
  c.film_present = unit.film_present;
  c.optical_dpi = a.optical_dpi;
  const int coarsest = a.max_dpi / std::max(a.min_dpi, 1);
  for (int pitch = 1; pitch <= coarsest; ++pitch) {
    if (lower_to_rule(a.pitch_rule, a.line_gap, pitch) == pitch) {
      c.resolutions_dpi.push_back(a.max_dpi / pitch);
    }
  }
  c.max_width_px = a.max_width_px;
  c.max_height_px = a.max_height_px;
  c.depths_bits = depths_of(unit);
  c.infrared = unit.infrared;
  c.focus_min = a.focus_min;
  c.focus_max = a.focus_max;
  const std::vector<FrameRectangle> frames = frames_of(unit);
  c.n_frames = static_cast<int>(frames.size());
  for (const FrameRectangle& frame : frames) {
    c.frames.push_back({frame.top_px * kMmPerInch / a.max_dpi,
                        frame.height_px * kMmPerInch / a.max_dpi, unit.frames_found});
  }
  c.max_samples = max_readings(unit);
  c.sensor_lines = sensor_lines(a, unit.windows);
  c.can_overview = true;
  c.can_move_frames = true;
  c.can_eject = unit.duties.offers(static_cast<std::uint8_t>(Operation::kUnload));
  c.can_load = unit.duties.offers(static_cast<std::uint8_t>(Operation::kLoad));
  c.exposure_min_us = unit.windows.exposure_min_10ns / k10nsPerUs;
  c.exposure_max_us = unit.windows.exposure_max_10ns / k10nsPerUs;
  return c;
}

Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit) {
  return Negotiation(request, unit).run();
}

bool still_fits(const ScanPlan& plan, const UnitDescription& unit) {
  const AddressPage& a = unit.addresses;
  const std::vector<int> depths = depths_of(unit);
  const int bottom_px = plan.y_origin_px + plan.window_height_px;
  const bool tall_enough =
      plan.window_height_px <=
      (plan.overview && has_thumbnails(unit) ? a.y_origin_max_px : a.max_height_px);
  return std::find(depths.begin(), depths.end(), plan.depth_bits) != depths.end() &&
         plan.window_width_px <= a.max_width_px && tall_enough &&
         plan.y_origin_px >= a.y_origin_min_px &&
         (a.y_origin_max_px == 0 || bottom_px <= a.y_origin_max_px + 1);
}

}  // namespace reseau::coolscan
