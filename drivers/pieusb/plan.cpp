#include "drivers/pieusb/plan.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/negotiating.h"

namespace reseau::pieusb {
namespace {

constexpr int kLowestDpi = 100;
// Frames of a strip of 35 mm film.
constexpr int kStripFrames = 6;
constexpr int kLowestExposure = 1;

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

class PieNegotiation : private Negotiating {
 public:
  PieNegotiation(const ScanRequest& request, const UnitDescription& unit)
      : Negotiating(request), unit_(unit) {
    max_dpi_ = unit.inquiry.max_dpi;
  }

  Negotiated run() {
    if (!unit_.inquiry.index_format || !unit_.inquiry.one_pass) {
      throw InputError(
          "This scanner does not offer red, green and blue in one pass, line by line; the program "
          "cannot use it.");
    }
    resolution();
    settle_depth(unit_.inquiry.depths_bits);
    settle_channels(unit_.inquiry.infrared);
    area();
    focus();
    settle_exposure(lowest_exposure(unit_.inquiry) * kExposureStepUs,
                    highest_exposure(unit_.inquiry) * kExposureStepUs);
    habits();
    return std::move(result_);
  }

 private:
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

  Span fit_side(const std::optional<double>& first_mm, const std::optional<double>& length_mm,
                int side_px, const char* first_name, const char* length_name) {
    const int limit = side_px - side_px % plan_.pitch;
    if (limit < plan_.pitch) throw InputError("The scan area is smaller than one pixel.");
    return fit(first_mm, length_mm, limit, Rest::kDropped, first_name, length_name);
  }

  void area() {
    settle_frame(n_frames_of(unit_.model), "the program moves no film in this scanner.");
    const AreaRequest& asked = request_.area;
    const Span x =
        fit_side(asked.left_mm, asked.width_mm, unit_.inquiry.max_width_px, "left edge", "width");
    const Span y =
        fit_side(asked.top_mm, asked.height_mm, unit_.inquiry.max_height_px, "top edge", "height");
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
    if (request_.sensor_lines == SensorLines::kAll) {
      adjust("sensor lines", "all", "one", "there is no other in this scanner's pass");
    }
    if (request_.frame_offset_mm != 0) {
      adjust("frame offset", text_of(request_.frame_offset_mm, "mm"), "0 mm",
             "the program moves this scanner's film by whole frames only");
    }
  }

  const UnitDescription& unit_;
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
