#include "drivers/coolscan/metering_pass.h"

#include <algorithm>

#include "drivers/coolscan/plan.h"

namespace reseau::coolscan {
namespace {

// Pitch 14 of an LS-5000 (recorded Nikon Scan session).
constexpr int kMeterDpi = 285;
// Share of width and height that is left out at each edge.
constexpr double kInset = 0.05;
// About a second of scanning; many periods of any colour screen.
constexpr int kFineLines = 64;

}  // namespace

namespace {

// One line of the sensor and one reading, which metering always uses.
PassSpec plain_pass_of(const ScanPlan& plan) {
  PassSpec spec;
  spec.window.resolution_dpi = plan.resolution_dpi;
  spec.window.x_px = plan.x_origin_px;
  spec.window.y_px = plan.y_origin_px;
  spec.window.width_px = plan.window_width_px;
  spec.window.height_px = plan.window_height_px;
  spec.window.bits = plan.depth_bits;
  spec.pitch = plan.pitch;
  spec.infrared = plan.infrared;
  spec.crop_left_px = plan.crop_left_px;
  spec.crop_width_px = plan.format.width_px;
  spec.crop_top_lines = plan.crop_top_lines;
  spec.crop_n_lines = plan.format.n_lines;
  return spec;
}

void all_lines(PassSpec& spec) {
  spec.crop_top_lines = 0;
  spec.crop_n_lines = spec.window.height_px / spec.pitch;
}

}  // namespace

PassSpec pass_of(const ScanPlan& plan, const AddressPage& addresses, const Exposures& exposures) {
  constexpr std::uint8_t kHighSpeed = 0x04, kMultipleReading = 0x10;
  PassSpec spec = plain_pass_of(plan);
  spec.exposures = exposures;
  if (plan.overview && addresses.thumbnail_dpi == plan.resolution_dpi) {
    spec.window.kind = ScanKind::kThumbnail;
  }
  spec.sensor_lines = plan.sensor_lines;
  if (plan.sensor_lines > 1) {
    spec.gap = std::max(1, addresses.line_gap / plan.pitch);
    spec.window.interleaving = Interleaving::kMultiLine;
  }
  if (plan.sensor_lines > 2 && plan.pitch > 1) {
    // Otherwise an LS-9000 does not average along the line.
    spec.window.averaging = false;
    spec.window.mode = kHighSpeed;
  }
  spec.window.readings = plan.samples;
  if (plan.samples > 1) {
    // Nikon Scan sends it instead of "normal" to an LS-5000, in addition to an LS-9000.
    spec.window.mode = plan.sensor_lines > 2
                           ? static_cast<std::uint8_t>(spec.window.mode | kMultipleReading)
                           : kMultipleReading;
  }
  return spec;
}

PassSpec coarse_pass_of(const ScanPlan& plan, const AddressPage& addresses) {
  PassSpec spec = plain_pass_of(plan);
  // Never finer than the scan itself.
  spec.pitch = std::max(pitch_for(addresses, kMeterDpi), plan.pitch);
  spec.window.resolution_dpi = addresses.max_dpi / spec.pitch;

  const int inset_y_px = static_cast<int>(plan.window_height_px * kInset);
  spec.window.y_px += inset_y_px;
  spec.window.height_px =
      std::max(plan.window_height_px - 2 * inset_y_px, std::min(spec.pitch, plan.window_height_px));
  if (spec.window.height_px < spec.pitch) {
    // An area flatter than one coarse line: meter with the scan's own resolution.
    spec.pitch = plan.pitch;
    spec.window.resolution_dpi = plan.resolution_dpi;
  }

  const int line_px = spec.window.width_px / spec.pitch;
  const int left_px = plan.crop_left_px * plan.pitch / spec.pitch;
  const int width_px = std::max(1, plan.format.width_px * plan.pitch / spec.pitch);
  const int inset_x_px = static_cast<int>(width_px * kInset);
  spec.crop_left_px = std::min(left_px + inset_x_px, line_px - 1);
  spec.crop_width_px =
      std::min(std::max(1, width_px - 2 * inset_x_px), line_px - spec.crop_left_px);
  all_lines(spec);
  return spec;
}

std::optional<PassSpec> fine_pass_of(const ScanPlan& plan, const PassSpec& coarse,
                                     int coarse_line) {
  if (coarse.pitch <= plan.pitch) return std::nullopt;
  PassSpec spec = plain_pass_of(plan);
  const int height_px = std::min(kFineLines * plan.pitch, plan.window_height_px);
  const int middle_px = coarse.window.y_px + coarse_line * coarse.pitch + coarse.pitch / 2;
  const int last_px = plan.y_origin_px + plan.window_height_px - height_px;
  spec.window.y_px = std::clamp(middle_px - height_px / 2, plan.y_origin_px, last_px);
  spec.window.height_px = height_px;
  const int inset_x_px = static_cast<int>(spec.crop_width_px * kInset);
  spec.crop_left_px += inset_x_px;
  spec.crop_width_px -= 2 * inset_x_px;
  all_lines(spec);
  return spec;
}

}  // namespace reseau::coolscan
