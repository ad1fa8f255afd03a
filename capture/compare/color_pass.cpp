#include "capture/compare/color_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/color/delta_e.h"

namespace reseau::compare {
namespace {

constexpr int kBandRows = 64;
static_assert(kBandRows % kBlockPx == 0);

// A band of one side: samples as stored and XYZ of the area.
class Band {
 public:
  explicit Band(const Side& side)
      : side_(side),
        row_(3 * static_cast<std::size_t>(side.picture->header().width_px)),
        inner_(3 * static_cast<std::size_t>(side.area.width_px)),
        whole_(row_ * kBandRows),
        samples_(inner_ * kBandRows),
        values_(inner_ * kBandRows) {}

  // Rows of the area.
  void read(int first, int n) {
    side_.picture->read(side_.area.y_px + first, n,
                        std::span(whole_).first(row_ * static_cast<std::size_t>(n)));
  }
  // After read(), any thread: samples and XYZ of row i of the band.
  void decode(int i) {
    const std::size_t at =
        row_ * static_cast<std::size_t>(i) + 3 * static_cast<std::size_t>(side_.area.x_px);
    const auto from = std::span<const float>(whole_).subspan(at, inner_);
    std::copy(from.begin(), from.end(), samples(i).begin());
    side_.picture->to_xyz(from, values(i));
  }
  // Then: the values become CIELAB.
  void to_lab(int i) {
    const std::span<float> row = values(i);
    for (std::size_t p = 0; p < row.size(); p += 3) {
      Xyz xyz =
          multiply(side_.lab_xyz, Vector3{double{row[p]}, double{row[p + 1]}, double{row[p + 2]}});
      if (!std::isfinite(xyz[0] + xyz[1] + xyz[2])) {
        row[p] = row[p + 1] = row[p + 2] = NAN;
        continue;
      }
      if (side_.clamp) {
        for (double& v : xyz) v = std::clamp(v, 0.0, 1.0);
      }
      const Lab lab = lab_from_xyz(xyz, side_.white);
      for (std::size_t k = 0; k < 3; ++k) row[p + k] = static_cast<float>(lab[k]);
    }
  }
  [[nodiscard]] std::span<float> samples(int i) {
    return std::span(samples_).subspan(inner_ * static_cast<std::size_t>(i), inner_);
  }
  [[nodiscard]] std::span<float> values(int i) {
    return std::span(values_).subspan(inner_ * static_cast<std::size_t>(i), inner_);
  }
  [[nodiscard]] std::span<const float> values_from(int i) const {
    return std::span<const float>(values_).subspan(inner_ * static_cast<std::size_t>(i));
  }

 private:
  const Side& side_;
  std::size_t row_, inner_;
  std::vector<float> whole_, samples_, values_;
};

struct RowResult {
  long long n_not_finite = 0;
  bool same = true;
  double max_abs = 0;
};

RowResult compare_row(Band& a, Band& b, int i, std::span<float> delta_e) {
  RowResult result;
  const auto sa = a.samples(i), sb = b.samples(i);
  const auto va = a.values(i), vb = b.values(i);
  for (std::size_t p = 0; p < delta_e.size(); ++p) {
    const float* const la = &va[3 * p];
    const float* const lb = &vb[3 * p];
    if (!std::isfinite(la[0]) || !std::isfinite(lb[0])) {
      delta_e[p] = NAN;
      ++result.n_not_finite;
      result.same = false;
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = std::abs(double{sa[3 * p + k]} - double{sb[3 * p + k]});
      result.max_abs = std::max(result.max_abs, d);
      result.same = result.same && d == 0;
    }
    const bool equal = la[0] == lb[0] && la[1] == lb[1] && la[2] == lb[2];
    delta_e[p] =
        equal ? 0.0F
              : static_cast<float>(delta_e_2000({double{la[0]}, double{la[1]}, double{la[2]}},
                                                {double{lb[0]}, double{lb[1]}, double{lb[2]}}));
  }
  return result;
}

}  // namespace

ColorPass run_color_pass(const Side& a, const Side& b, const std::stop_token& stop) {
  CHECK(a.area.width_px == b.area.width_px && a.area.height_px == b.area.height_px);
  const int width = a.area.width_px, height = a.area.height_px;
  ColorPass pass;
  pass.delta_e.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  pass.blocks_across = width / kBlockPx;
  pass.blocks_down = height / kBlockPx;
  pass.blocks.resize(static_cast<std::size_t>(pass.blocks_across) *
                     static_cast<std::size_t>(pass.blocks_down));
  Band band_a(a), band_b(b);
  std::vector<RowResult> rows(kBandRows);
  for (int first = 0; first < height; first += kBandRows) {
    if (stop.stop_requested()) {
      pass.stopped = true;
      return pass;
    }
    const int n = std::min(kBandRows, height - first);
    band_a.read(first, n);
    band_b.read(first, n);
    parallel_for(n, [&](int i) {
      band_a.decode(i);
      band_b.decode(i);
      band_a.to_lab(i);
      band_b.to_lab(i);
      const auto at = static_cast<std::size_t>(first + i) * static_cast<std::size_t>(width);
      rows[static_cast<std::size_t>(i)] = compare_row(
          band_a, band_b, i, std::span(pass.delta_e).subspan(at, static_cast<std::size_t>(width)));
    });
    for (int i = 0; i < n; ++i) {
      const RowResult& row = rows[static_cast<std::size_t>(i)];
      pass.n_not_finite += row.n_not_finite;
      pass.same_samples = pass.same_samples && row.same;
      pass.max_abs = std::max(pass.max_abs, row.max_abs);
    }
    parallel_for(n / kBlockPx * pass.blocks_across, [&](int j) {
      const int down = j / pass.blocks_across, across = j % pass.blocks_across;
      const auto index = static_cast<std::size_t>(first / kBlockPx + down) *
                             static_cast<std::size_t>(pass.blocks_across) +
                         static_cast<std::size_t>(across);
      pass.blocks[index] = measure_block(
          band_a.values_from(down * kBlockPx), band_b.values_from(down * kBlockPx),
          static_cast<std::size_t>(width), static_cast<std::size_t>(across) * kBlockPx);
    });
  }
  return pass;
}

FitSums run_fit_pass(const Side& a, const Side& b, const std::stop_token& stop) {
  const int height = a.area.height_px;
  Band band_a(a), band_b(b);
  std::vector<FitSums> rows(kBandRows);
  FitSums sums;
  for (int first = 0; first < height && !stop.stop_requested(); first += kBandRows) {
    const int n = std::min(kBandRows, height - first);
    band_a.read(first, n);
    band_b.read(first, n);
    parallel_for(n, [&](int i) {
      band_a.decode(i);
      band_b.decode(i);
      FitSums row;
      const auto va = band_a.values(i), vb = band_b.values(i);
      for (std::size_t p = 0; p < va.size(); p += 3) {
        const Xyz xa =
            multiply(a.lab_xyz, Vector3{double{va[p]}, double{va[p + 1]}, double{va[p + 2]}});
        const Xyz xb =
            multiply(b.lab_xyz, Vector3{double{vb[p]}, double{vb[p + 1]}, double{vb[p + 2]}});
        if (!std::isfinite(xa[0] + xa[1] + xa[2] + xb[0] + xb[1] + xb[2])) continue;
        for (std::size_t k = 0; k < 3; ++k) {
          row.mean_a[k] += xa[k];
          row.mean_b[k] += xb[k];
        }
        row.ab += xa[1] * xb[1];
        row.bb += xb[1] * xb[1];
        ++row.n;
      }
      rows[static_cast<std::size_t>(i)] = row;
    });
    for (int i = 0; i < n; ++i) {
      const FitSums& row = rows[static_cast<std::size_t>(i)];
      for (std::size_t k = 0; k < 3; ++k) {
        sums.mean_a[k] += row.mean_a[k];
        sums.mean_b[k] += row.mean_b[k];
      }
      sums.ab += row.ab;
      sums.bb += row.bb;
      sums.n += row.n;
    }
  }
  if (sums.n == 0) return sums;
  for (std::size_t k = 0; k < 3; ++k) {
    sums.mean_a[k] /= static_cast<double>(sums.n);
    sums.mean_b[k] /= static_cast<double>(sums.n);
  }
  return sums;
}

std::vector<float> read_xyz(Picture& picture, const Rect& area) {
  const auto row = 3 * static_cast<std::size_t>(picture.header().width_px);
  const auto inner = 3 * static_cast<std::size_t>(area.width_px);
  std::vector<float> whole(row), xyz(inner * static_cast<std::size_t>(area.height_px));
  for (int y = 0; y < area.height_px; ++y) {
    picture.read(area.y_px + y, 1, whole);
    picture.to_xyz(
        std::span<const float>(whole).subspan(3 * static_cast<std::size_t>(area.x_px), inner),
        std::span(xyz).subspan(inner * static_cast<std::size_t>(y), inner));
  }
  return xyz;
}

DifferenceFigures figures_of(std::span<float> values, double worst_fraction) {
  CHECK(worst_fraction >= 0 && worst_fraction <= 1);
  const auto dropped =
      static_cast<std::size_t>(std::llround(worst_fraction * static_cast<double>(values.size())));
  const std::size_t n = values.size() - dropped;
  DifferenceFigures figures;
  figures.n = static_cast<long long>(n);
  if (n == 0) return figures;
  // The smallest n first; each further rank is then sought among fewer.
  const auto begin = values.begin();
  const auto nth = [&](std::size_t rank, std::size_t end) {
    std::nth_element(begin, begin + static_cast<std::ptrdiff_t>(rank),
                     begin + static_cast<std::ptrdiff_t>(end));
    return double{values[rank]};
  };
  figures.max = nth(n - 1, values.size());
  const auto rank95 = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(n))) - 1;
  figures.p95 = nth(rank95, n);
  const double upper = nth(n / 2, n);
  figures.median = n % 2 == 1
                       ? upper
                       : 0.5 * (upper + double{*std::max_element(
                                            begin, begin + static_cast<std::ptrdiff_t>(n / 2))});
  double sum = 0;
  for (const float v : values.first(n)) sum += double{v};
  figures.mean = sum / static_cast<double>(n);
  return figures;
}

ErrorRaster raster_of(std::span<const float> delta_e, int width_px, int height_px,
                      int longest_side) {
  ErrorRaster raster;
  raster.cell_px = (std::max(width_px, height_px) + longest_side - 1) / longest_side;
  raster.width = (width_px + raster.cell_px - 1) / raster.cell_px;
  raster.height = (height_px + raster.cell_px - 1) / raster.cell_px;
  const auto across = static_cast<std::size_t>(raster.width);
  std::vector<double> sum(across * static_cast<std::size_t>(raster.height));
  std::vector<int> n(sum.size());
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      const float v = delta_e[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) +
                              static_cast<std::size_t>(x)];
      if (!std::isfinite(v)) continue;
      const auto cell = static_cast<std::size_t>(y / raster.cell_px) * across +
                        static_cast<std::size_t>(x / raster.cell_px);
      sum[cell] += double{v};
      ++n[cell];
    }
  }
  raster.mean_delta_e.resize(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) {
    raster.mean_delta_e[i] = n[i] > 0 ? static_cast<float>(sum[i] / n[i]) : NAN;
  }
  return raster;
}

}  // namespace reseau::compare
