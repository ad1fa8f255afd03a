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
    resolution();
    depth();
    channels();
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
    const std::vector<int> offered = unit_.windows.depths_bits();
    if (offered.empty()) throw InputError("The scanner does not offer any depth to scan with.");
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

  void area() {
    const int n_frames = capabilities_of(unit_).n_frames;
    if (request_.frame < 1 || request_.frame > n_frames) {
      throw InputError("Frame " + std::to_string(request_.frame) + " was asked for, but " +
                       (n_frames == 1
                            ? std::string("this adapter holds one frame.")
                            : "the frames here are 1 to " + std::to_string(n_frames) + "."));
    }
    plan_.frame = request_.frame;
    const auto index = static_cast<std::size_t>(plan_.frame - 1);
    frame_top_px_ = index < unit_.frame_tops_px.size()
                        ? unit_.frame_tops_px[index]
                        : a_.y_origin_min_px + (plan_.frame - 1) * a_.max_height_px;
    // A window past the boundary can drive the stage against its stop.
    int frame_height_px = a_.max_height_px;
    if (a_.y_origin_max_px > 0) {
      frame_height_px = std::min(frame_height_px, a_.y_origin_max_px + 1 - frame_top_px_);
    }
    if (frame_height_px < plan_.pitch) {
      throw InputError("Frame " + std::to_string(plan_.frame) + " lies beyond the film.");
    }
    const AreaRequest& asked = request_.area;
    x_ = fit(asked.left_mm, asked.width_mm, a_.max_width_px, "left edge", "width");
    y_ = fit(asked.top_mm, asked.height_mm, frame_height_px, "top edge", "height");
    plan_.y_origin_px = frame_top_px_ + y_.first;
    plan_.window_height_px = y_.length;
    plan_.format.n_lines = y_.length / plan_.pitch;

    if (a_.x_origin_max_px > a_.x_origin_min_px) {
      plan_.x_origin_px = x_.first;
      plan_.window_width_px = x_.length;
      plan_.format.width_px = x_.length / plan_.pitch;
      return;
    }
    plan_.x_origin_px = a_.x_origin_min_px;
    plan_.window_width_px = a_.max_width_px;
    const int line_px = a_.max_width_px / plan_.pitch;
    plan_.crop_left_px = std::min(x_.first / plan_.pitch, line_px - 1);
    const int right = (x_.first + x_.length + plan_.pitch - 1) / plan_.pitch;
    plan_.format.width_px = std::min(right, line_px) - plan_.crop_left_px;
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
    plan_.focus_x_px = x_.first + x_.length / 2;
    plan_.focus_y_px = plan_.y_origin_px + y_.length / 2;
    if (focus.x_mm) {
      plan_.focus_x_px = focus_point(*focus.x_mm, a_.max_width_px, "focus point, across");
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
  int frame_top_px_ = 0;
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
  c.depths_bits = unit.windows.depths_bits();
  c.infrared = unit.infrared;
  c.focus_min = a.focus_min;
  c.focus_max = a.focus_max;
  c.n_frames = std::max(1, a.frames_present > 0 ? a.frames_present : a.frame_capacity);
  c.exposure_min_us = unit.windows.exposure_min_10ns / k10nsPerUs;
  c.exposure_max_us = unit.windows.exposure_max_10ns / k10nsPerUs;
  return c;
}

Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit) {
  return Negotiation(request, unit).run();
}

bool still_fits(const ScanPlan& plan, const UnitDescription& unit) {
  const AddressPage& a = unit.addresses;
  const std::vector<int> depths = unit.windows.depths_bits();
  const int bottom_px = plan.y_origin_px + plan.window_height_px;
  return std::find(depths.begin(), depths.end(), plan.depth_bits) != depths.end() &&
         plan.window_width_px <= a.max_width_px && plan.window_height_px <= a.max_height_px &&
         plan.y_origin_px >= a.y_origin_min_px &&
         (a.y_origin_max_px == 0 || bottom_px <= a.y_origin_max_px + 1);
}

}  // namespace reseau::coolscan
