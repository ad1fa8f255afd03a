#include "capture/cli/difference.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "capture/image/exr_file.h"
#include "core/base/error.h"
#include "core/color/delta_e.h"
#include "core/color/rgb_space.h"

namespace reseau::cli {

namespace {

DifferenceFigures figures(std::span<double> samples, double worst_fraction) {
  const DeltaESummary summary = summarize_delta_e(samples, worst_fraction);
  DifferenceFigures result{summary.mean, 0, summary.p95, summary.max};
  if (summary.n > 0) {
    // summarize_delta_e() left the samples sorted.
    const std::size_t middle = summary.n / 2;
    result.median =
        summary.n % 2 == 1 ? samples[middle] : 0.5 * (samples[middle - 1] + samples[middle]);
  }
  return result;
}

Matrix3 xyz_from_file(const ExrReader& reader) {
  return xyz_from_rgb(reader.chromaticities().value_or(srgb_chromaticities()));
}

bool finite(const float* rgb) {
  return std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]);
}

}  // namespace

Difference compare_pictures(const std::filesystem::path& a, const std::filesystem::path& b,
                            const std::stop_token& stop) {
  ExrReader first(a);
  ExrReader second(b);
  if (first.width_px() != second.width_px() || first.height_px() != second.height_px()) {
    throw InputError(fmt::format(
        "{} has {} × {} pixels and {} has {} × {}. Only pictures of the same size can be compared.",
        a.string(), first.width_px(), first.height_px(), b.string(), second.width_px(),
        second.height_px()));
  }
  Difference result;
  result.width_px = first.width_px();
  result.height_px = first.height_px();
  const Matrix3 xyz_from_first = xyz_from_file(first);
  const Matrix3 xyz_from_second = xyz_from_file(second);
  const Xyz white = white_of(Illuminant::kD65);
  const auto n_samples = static_cast<std::size_t>(result.width_px) * 3;
  std::vector<float> row_a(n_samples);
  std::vector<float> row_b(n_samples);
  std::vector<double> delta_e;
  result.identical = true;
  for (int y = 0; y < result.height_px && !stop.stop_requested(); ++y) {
    first.read(y, 1, row_a);
    second.read(y, 1, row_b);
    for (std::size_t i = 0; i < n_samples; i += 3) {
      const float* const p = &row_a[i];
      const float* const q = &row_b[i];
      if (!finite(p) || !finite(q)) {
        ++result.n_not_finite;
        result.identical = false;
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        const double difference = std::abs(double{p[c]} - double{q[c]});
        result.max_abs = std::max(result.max_abs, difference);
        result.identical = result.identical && difference == 0;
      }
      const Lab lab_a = lab_from_xyz(multiply(xyz_from_first, Vector3{p[0], p[1], p[2]}), white);
      const Lab lab_b = lab_from_xyz(multiply(xyz_from_second, Vector3{q[0], q[1], q[2]}), white);
      delta_e.push_back(delta_e_2000(lab_a, lab_b));
    }
  }
  result.n_pixels = static_cast<long long>(delta_e.size());
  result.all = figures(delta_e, 0.0);
  result.without_worst_percent = figures(delta_e, 0.01);
  return result;
}

}  // namespace reseau::cli
