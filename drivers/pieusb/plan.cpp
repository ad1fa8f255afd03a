#include "drivers/pieusb/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace reseau::pieusb {
namespace {

constexpr double kMmInInch = 25.4;
constexpr int kLowestDpi = 100;
// Frames of a strip of 35 mm film.
constexpr int kStripFrames = 6;
constexpr int kLowestExposure = 1;

std::string pie_text(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

int pie_px(double mm, int dpi, const char* field) {
  if (!std::isfinite(mm) || std::abs(mm) > 1e5) {
    throw InputError(std::string("The ") + field + " of the area is not a usable length.");
  }
  return static_cast<int>(std::lround(mm * dpi / kMmInInch));
}

std::vector<int> pitches_of(const Inquiry& inquiry) {
  std::vector<int> pitches;
  for (int pitch = 1; inquiry.max_dpi / pitch >= kLowestDpi; ++pitch) {
    if (inquiry.max_dpi % pitch == 0) pitches.push_back(pitch);
  }
  return pitches;
}

int n_frames_of(const Model& model) {
  return model.transport == Transport::kFilmStrip ? kStripFrames : 1;
}

int lowest_exposure(const Inquiry& i) { return std::max(kLowestExposure, i.min_exposure); }
int highest_exposure(const Inquiry& i) {
  return i.max_exposure > 0 ? std::min(i.max_exposure, kMaxExposure) : kMaxExposure;
}

struct Stretch {
  int first = 0, length = 0;
};

class PieNegotiation {
 public:
  PieNegotiation(const ScanRequest& request, const UnitDescription& unit)
      : request_(request), unit_(unit) {}

  Negotiated run() {
    if (!unit_.inquiry.index_format || !unit_.inquiry.one_pass) {
      throw InputError(
          "This scanner does not offer red, green and blue in one pass, line by line; the program "
          "cannot use it.");
    }
    resolution();
    depth();
    channels();
    area();
    focus();
    exposure();
    habits();
    return std::move(result_);
  }

 private:
  void adjust(const std::string& field, const std::string& asked, const std::string& granted,
              const std::string& why) {
    result_.adjusted.push_back({field, asked, granted, why});
  }

  void resolution() {
    const int max_dpi = unit_.inquiry.max_dpi;
    const int asked = request_.resolution_dpi.value_or(std::min(unit_.model.native_dpi, max_dpi));
    if (asked <= 0) throw InputError("The resolution must be a number above 0 dpi.");
    plan_.pitch = pitch_for(unit_.inquiry, asked);
    plan_.resolution_dpi = max_dpi / plan_.pitch;
    if (plan_.resolution_dpi != asked) {
      adjust("resolution", std::to_string(asked) + " dpi",
             std::to_string(plan_.resolution_dpi) + " dpi",
             asked > max_dpi ? "the scanner has no higher resolution"
                             : "the scanner is asked for whole divisors of " +
                                   std::to_string(max_dpi) + " dpi only; the next finer one");
    }
    plan_.format.x_dpi = plan_.format.y_dpi = plan_.resolution_dpi;
  }

  void depth() {
    const std::vector<int>& offered = unit_.inquiry.depths_bits;
    if (offered.empty()) throw InputError("The scanner offers neither 8 nor 16 bits.");
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
    if (request_.infrared && !unit_.inquiry.infrared) {
      throw InputError("This scanner has no infrared channel. Ask for a scan without infrared.");
    }
    plan_.infrared = request_.infrared;
    plan_.format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
    if (plan_.infrared) plan_.format.channels.push_back(Channel::kInfrared);
  }

  // Fits one dimension; lengths are whole delivered pixels, rounded up where there is room.
  Stretch fit(const std::optional<double>& first_mm, const std::optional<double>& length_mm,
              int side_px, const char* first_name, const char* length_name) {
    const int dpi = unit_.inquiry.max_dpi;
    const int limit = side_px - side_px % plan_.pitch;
    if (limit < plan_.pitch) throw InputError("The scan area is smaller than one pixel.");
    const int asked_first = pie_px(first_mm.value_or(0), dpi, first_name);
    if (asked_first >= limit) {
      throw InputError(
          std::string("The ") + first_name + " of the area lies beyond the frame, which measures " +
          pie_text(limit * kMmInInch / dpi, "mm") + " in that direction. Give a smaller value.");
    }
    const int first = std::clamp(asked_first, 0, limit - plan_.pitch);
    if (first != asked_first) note(first_name, *first_mm, first);
    const int room = (limit - first) / plan_.pitch * plan_.pitch;
    if (!length_mm) return {first, room};
    const int asked_length = pie_px(*length_mm, dpi, length_name);
    if (asked_length <= 0) {
      throw InputError(std::string("The ") + length_name + " of the area must be above 0 mm.");
    }
    const int whole = (asked_length + plan_.pitch - 1) / plan_.pitch * plan_.pitch;
    const int length = std::min(whole, room);
    if (length < asked_length) note(length_name, *length_mm, length);
    return {first, length};
  }

  void note(const char* field, double asked_mm, int granted_px) {
    adjust(field, pie_text(asked_mm, "mm"),
           pie_text(granted_px * kMmInInch / unit_.inquiry.max_dpi, "mm"), "the frame ends there");
  }

  void area() {
    const int n_frames = n_frames_of(unit_.model);
    if (request_.frame < 1 || request_.frame > n_frames) {
      throw InputError("Frame " + std::to_string(request_.frame) + " was asked for, but " +
                       (n_frames == 1
                            ? std::string("the program moves no film in this scanner.")
                            : "the frames here are 1 to " + std::to_string(n_frames) + "."));
    }
    plan_.frame = request_.frame;
    const AreaRequest& asked = request_.area;
    const Stretch x =
        fit(asked.left_mm, asked.width_mm, unit_.inquiry.max_width_px, "left edge", "width");
    const Stretch y =
        fit(asked.top_mm, asked.height_mm, unit_.inquiry.max_height_px, "top edge", "height");
    plan_.x_origin_px = x.first;
    plan_.window_width_px = x.length;
    plan_.format.width_px = x.length / plan_.pitch;
    plan_.y_origin_px = y.first;
    plan_.window_height_px = y.length;
    plan_.format.n_lines = y.length / plan_.pitch;
  }

  void focus() {
    // The lens does not move.
    if (request_.focus.mode == FocusRequest::Mode::kPosition) {
      adjust("focus", std::to_string(request_.focus.position), "fixed",
             "the scanner has a fixed focus");
    }
    plan_.focus = {};
    plan_.focus.mode = FocusRequest::Mode::kKeep;
  }

  // What other families can.
  void habits() {
    if (request_.overview) {
      throw InputError("This scanner has no overview of a film; scan a frame at a low resolution.");
    }
    if (request_.samples != 1) {
      adjust("samples", std::to_string(request_.samples), "1", "the scanner reads a line once");
    }
    if (request_.frame_offset_mm != 0) {
      adjust("frame offset", pie_text(request_.frame_offset_mm, "mm"), "0 mm",
             "the program moves this scanner's film by whole frames only");
    }
  }

  void exposure() {
    plan_.exposure = request_.exposure;
    if (!(plan_.exposure.factor > 0) || !std::isfinite(plan_.exposure.factor)) {
      throw InputError("The exposure factor must be a number above 0.");
    }
    if (plan_.exposure.mode != ExposureRequest::Mode::kFixed) return;
    static constexpr const char* kNames[] = {"red exposure", "green exposure", "blue exposure",
                                             "infrared exposure"};
    const double low_us = lowest_exposure(unit_.inquiry) * kExposureStepUs;
    const double high_us = highest_exposure(unit_.inquiry) * kExposureStepUs;
    for (std::size_t i = 0; i < plan_.exposure.exposure_us.size(); ++i) {
      std::optional<double>& us = plan_.exposure.exposure_us[i];
      if (!us) continue;
      if (!std::isfinite(*us) || *us <= 0) {
        throw InputError(std::string("The ") + kNames[i] + " must be a time above 0 us.");
      }
      const double asked = *us;
      us = std::clamp(asked, low_us, high_us);
      if (*us != asked) {
        adjust(kNames[i], pie_text(asked, "us"), pie_text(*us, "us"),
               "the scanner's exposure range ends there");
      }
    }
  }

  const ScanRequest& request_;
  const UnitDescription& unit_;
  Negotiated result_;
  ScanPlan& plan_ = result_.plan;
};

}  // namespace

int pitch_for(const Inquiry& inquiry, int resolution_dpi) {
  int chosen = 1;
  for (const int pitch : pitches_of(inquiry)) {
    if (inquiry.max_dpi / pitch >= resolution_dpi) chosen = pitch;
  }
  // Coarser than the coarsest is the coarsest.
  return chosen;
}

Capabilities capabilities_of(const UnitDescription& unit) {
  const Inquiry& i = unit.inquiry;
  Capabilities c;
  c.make = i.vendor;
  c.model = std::string(unit.model.trade_name);
  c.firmware = i.firmware.empty() ? i.revision : i.firmware;
  c.serial = unit.serial;
  c.link = unit.link;
  c.film_present = unit.film_present;
  c.optical_dpi = i.max_dpi;
  for (const int pitch : pitches_of(i)) c.resolutions_dpi.push_back(i.max_dpi / pitch);
  c.max_width_px = i.max_width_px;
  c.max_height_px = i.max_height_px;
  c.depths_bits = i.depths_bits;
  c.infrared = i.infrared;
  c.n_frames = n_frames_of(unit.model);
  c.exposure_min_us = lowest_exposure(i) * kExposureStepUs;
  c.exposure_max_us = highest_exposure(i) * kExposureStepUs;
  return c;
}

Negotiated negotiate(const ScanRequest& request, const UnitDescription& unit) {
  return PieNegotiation(request, unit).run();
}

ScanFrame frame_of(const ScanPlan& plan, const UnitDescription& unit) {
  const ScanFrame& area = unit.inquiry.area;
  const int x0 = area.x0 + plan.x_origin_px, y0 = area.y0 + plan.y_origin_px;
  return {x0, y0, x0 + plan.window_width_px - 1, y0 + plan.window_height_px - 1};
}

}  // namespace reseau::pieusb
