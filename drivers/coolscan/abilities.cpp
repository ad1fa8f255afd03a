// What a unit can do, by its pages.
#include <algorithm>

#include "drivers/coolscan/plan.h"
#include "drivers/coolscan/window.h"

namespace reseau::coolscan {
namespace {

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
