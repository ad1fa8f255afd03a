#include "drivers/pieusb/metering_pass.h"

#include <algorithm>

namespace reseau::pieusb {
namespace {

// What the vendor's program previews with.
constexpr int kCoarseDpi = 300;
// Share of width and height that is left out at each edge.
constexpr double kEdgeShare = 0.05;
constexpr int kFineRows = 64;

// A frame and its size in pixels of `pitch`, with the edges left out where there is room.
void set_inside(PassSpec& spec, const ScanFrame& frame, int pitch) {
  const auto fit = [pitch](int first, int last, int& from, int& to, int& n) {
    const int side = last - first + 1;
    const int inset = static_cast<int>(side * kEdgeShare);
    n = std::max(1, (side - 2 * inset) / pitch);
    from = first + std::min(inset, side - n * pitch);
    to = from + n * pitch - 1;
  };
  fit(frame.x0, frame.x1, spec.frame.x0, spec.frame.x1, spec.width_px);
  fit(frame.y0, frame.y1, spec.frame.y0, spec.frame.y1, spec.n_lines);
}

}  // namespace

PassSpec pass_of(const ScanPlan& plan, const UnitDescription& unit) {
  PassSpec spec;
  spec.frame = frame_of(plan, unit);
  spec.dpi = plan.resolution_dpi;
  spec.width_px = plan.format.width_px;
  spec.n_lines = plan.format.n_lines;
  spec.depth_bits = plan.depth_bits;
  spec.infrared = plan.infrared;
  return spec;
}

PassSpec coarse_pass_of(const ScanPlan& plan, const UnitDescription& unit) {
  PassSpec spec = pass_of(plan, unit);
  const int max_dpi = unit.inquiry.max_dpi;
  int pitch = std::max(pitch_for(unit.inquiry, kCoarseDpi), plan.pitch);
  // An area smaller than one coarse pixel: meter with the scan's own resolution.
  if (plan.window_width_px < 2 * pitch || plan.window_height_px < 2 * pitch) pitch = plan.pitch;
  spec.dpi = max_dpi / pitch;
  spec.depth_bits = unit.inquiry.depths_bits.back();
  set_inside(spec, frame_of(plan, unit), pitch);
  return spec;
}

std::optional<PassSpec> fine_pass_of(const ScanPlan& plan, const UnitDescription& unit,
                                     const PassSpec& coarse, int coarse_row) {
  if (coarse.dpi >= plan.resolution_dpi) return std::nullopt;
  PassSpec spec = pass_of(plan, unit);
  const ScanFrame whole = spec.frame;
  const int coarse_pitch = unit.inquiry.max_dpi / coarse.dpi;
  const int n_rows = std::min(kFineRows, plan.format.n_lines);
  const int height_px = n_rows * plan.pitch;
  const int middle_px = coarse.frame.y0 + coarse_row * coarse_pitch + coarse_pitch / 2;
  spec.frame.y0 = std::clamp(middle_px - height_px / 2, whole.y0, whole.y1 + 1 - height_px);
  spec.frame.y1 = spec.frame.y0 + height_px - 1;
  spec.n_lines = n_rows;
  const int side_px = whole.x1 - whole.x0 + 1;
  const int inset_px = static_cast<int>(side_px * kEdgeShare) / plan.pitch * plan.pitch;
  spec.frame.x0 = whole.x0 + inset_px;
  spec.frame.x1 = whole.x1 - inset_px;
  spec.width_px = (side_px - 2 * inset_px) / plan.pitch;
  spec.depth_bits = unit.inquiry.depths_bits.back();
  return spec;
}

void RowTops::add_row(std::span<const std::uint16_t> row) {
  constexpr std::size_t kOneIn = 20;
  const std::size_t width = row.size() / n_channels_;
  for (std::size_t c = 0; c < n_channels_; ++c) {
    const auto plane = row.subspan(c * width, width);
    sorted_.assign(plane.begin(), plane.end());
    const auto at = sorted_.end() - static_cast<std::ptrdiff_t>(1 + width / kOneIn);
    std::nth_element(sorted_.begin(), at, sorted_.end());
    tops_.push_back(*at);
  }
}

int RowTops::brightest_row() const {
  std::vector<double> most(n_channels_, 1.0);
  for (std::size_t i = 0; i < tops_.size(); ++i) {
    most[i % n_channels_] = std::max<double>(most[i % n_channels_], tops_[i]);
  }
  int brightest = 0;
  double best = -1;
  for (std::size_t row = 0; row < tops_.size() / n_channels_; ++row) {
    double sum = 0;
    for (std::size_t c = 0; c < n_channels_; ++c) sum += tops_[row * n_channels_ + c] / most[c];
    if (sum <= best) continue;
    best = sum;
    brightest = static_cast<int>(row);
  }
  return brightest;
}

}  // namespace reseau::pieusb
