#include "capture/compare/block_stats.h"

#include <algorithm>
#include <cmath>

namespace reseau::compare {
namespace {

constexpr std::size_t kSide = kBlockPx;
// Sum of (i - 7.5)^2 over a square.
constexpr double kPlaneNorm = kSide * kSide * (kSide * kSide - 1) / 12.0;

struct Plane {
  double mean = 0, variance = 0;
};

// F(x, y): the sample of one channel.
template <typename F>
Plane fit_plane(const F& at) {
  double sum = 0, sum_x = 0, sum_y = 0, squares = 0;
  const double middle = (kSide - 1) / 2.0;
  const double first = at(0, 0);  // keeps the sum of squares small
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t x = 0; x < kSide; ++x) {
      const double v = at(x, y) - first;
      sum += v;
      sum_x += v * (static_cast<double>(x) - middle);
      sum_y += v * (static_cast<double>(y) - middle);
      squares += v * v;
    }
  }
  constexpr double n = kSide * kSide;
  Plane plane;
  plane.mean = first + sum / n;
  const double gx = sum_x / kPlaneNorm, gy = sum_y / kPlaneNorm;
  const double rest = squares - sum * sum / n - gx * sum_x - gy * sum_y;
  plane.variance = std::max(0.0, rest / (n - 3));
  return plane;
}

// Noise of single pixels hardly counts in the means of 16.
template <typename F>
double coarse_variance(const F& at) {
  constexpr std::size_t kCell = 4, kCells = kSide / kCell;
  const double first = at(0, 0);
  double sum = 0, squares = 0;
  for (std::size_t j = 0; j < kCells; ++j) {
    for (std::size_t i = 0; i < kCells; ++i) {
      double mean = 0;
      for (std::size_t y = 0; y < kCell; ++y) {
        for (std::size_t x = 0; x < kCell; ++x) mean += at(i * kCell + x, j * kCell + y) - first;
      }
      mean /= kCell * kCell;
      sum += mean;
      squares += mean * mean;
    }
  }
  constexpr double n = kCells * kCells;
  return std::max(0.0, (squares - sum * sum / n) / (n - 1));
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Sums {
  double gxx = 0, gxy = 0, gyy = 0, gxd = 0, gyd = 0;
  void add(const Block& b, double weight) {
    gxx += weight * b.gxx;
    gxy += weight * b.gxy;
    gyy += weight * b.gyy;
    gxd += weight * b.gxd;
    gyd += weight * b.gyd;
  }
  // Enough detail both ways; else the shift along an edge would be noise.
  [[nodiscard]] bool regular() const {
    const double trace = gxx + gyy, determinant = gxx * gyy - gxy * gxy;
    return trace > 0 && determinant > 1e-3 * trace * trace;
  }
  [[nodiscard]] std::array<double, 2> shift() const {
    const double determinant = gxx * gyy - gxy * gxy;
    return {(gxy * gyd - gyy * gxd) / determinant, (gxy * gxd - gxx * gyd) / determinant};
  }
};

}  // namespace

Block measure_block(std::span<const float> lab_a, std::span<const float> lab_b,
                    std::size_t stride_px, std::size_t x_px) {
  Block block;
  const auto index = [&](std::size_t x, std::size_t y, std::size_t k) {
    return 3 * (y * stride_px + x_px + x) + k;
  };
  float check = 0;
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t i = index(0, y, 0); i < index(0, y, 0) + 3 * kSide; ++i) {
      check += 0.0F * (lab_a[i] + lab_b[i]);
    }
  }
  if (!std::isfinite(check)) return block;
  block.usable = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = [&](std::size_t x, std::size_t y) { return double{lab_a[index(x, y, k)]}; };
    const auto b = [&](std::size_t x, std::size_t y) { return double{lab_b[index(x, y, k)]}; };
    const Plane plane_a = fit_plane(a), plane_b = fit_plane(b);
    block.mean_a[k] = plane_a.mean;
    block.mean_b[k] = plane_b.mean;
    block.variance_a[k] = plane_a.variance;
    block.variance_b[k] = plane_b.variance;
    block.unevenness_a += coarse_variance(a);
    for (std::size_t y = 1; y + 1 < kSide; ++y) {
      for (std::size_t x = 1; x + 1 < kSide; ++x) {
        const double ax = (a(x + 1, y) - a(x - 1, y)) / 2, ay = (a(x, y + 1) - a(x, y - 1)) / 2;
        block.xx += ax * ax;
        block.xy += ax * ay;
        block.yy += ay * ay;
        if (k != 0) continue;
        const double gx = (ax + (b(x + 1, y) - b(x - 1, y)) / 2) / 2;
        const double gy = (ay + (b(x, y + 1) - b(x, y - 1)) / 2) / 2;
        const double d = b(x, y) - a(x, y);
        block.gxx += gx * gx;
        block.gxy += gx * gy;
        block.gyy += gy * gy;
        block.gxd += gx * d;
        block.gyd += gy * d;
      }
    }
  }
  return block;
}

NoiseFigures noise_of(std::span<const Block> blocks) {
  struct Ranked {
    double unevenness;
    std::size_t index;
  };
  std::vector<Ranked> ranked;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& b = blocks[i];
    // Black and white are flat because they are clipped.
    if (!b.usable || b.mean_a[0] < 2 || b.mean_a[0] > 99) continue;
    ranked.push_back({b.unevenness_a, i});
  }
  NoiseFigures figures;
  if (ranked.empty()) return figures;
  std::sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) {
    return a.unevenness != b.unevenness ? a.unevenness < b.unevenness : a.index < b.index;
  });
  ranked.resize(std::min(ranked.size(), std::max<std::size_t>(4, ranked.size() / 10)));
  figures.n_blocks = static_cast<int>(ranked.size());
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> a, b;
    for (const Ranked& r : ranked) {
      a.push_back(blocks[r.index].variance_a[k]);
      b.push_back(blocks[r.index].variance_b[k]);
    }
    figures.a[k] = std::sqrt(median(a));
    figures.b[k] = std::sqrt(median(b));
    // Below this a float file of a flat area has rounding, not noise.
    constexpr double kRounding = 1e-4;
    if (figures.a[k] > kRounding) figures.ratio[k] = figures.b[k] / figures.a[k];
  }
  return figures;
}

ShiftFigures shift_of(std::span<const Block> blocks) {
  constexpr std::size_t kGroups = 16;
  Sums all;
  std::array<Sums, kGroups> groups;
  std::vector<double> strengths;
  for (const Block& block : blocks) {
    if (block.usable && block.gxx + block.gyy > 0) strengths.push_back(block.gxx + block.gyy);
  }
  ShiftFigures figures;
  if (strengths.size() < kGroups) return figures;
  // A few strong edges, the border of the picture foremost, must not speak for all of it.
  const double typical = median(strengths);
  std::size_t n = 0;
  for (const Block& block : blocks) {
    if (!block.usable || !(block.gxx + block.gyy > 0)) continue;
    const double weight = 1 / (typical + block.gxx + block.gyy);
    all.add(block, weight);
    groups[n++ % kGroups].add(block, weight);
  }
  if (!all.regular()) return figures;
  const auto whole = all.shift();
  std::array<double, 2> scatter{};
  for (const Sums& group : groups) {
    Sums rest = all;
    rest.gxx -= group.gxx;
    rest.gxy -= group.gxy;
    rest.gyy -= group.gyy;
    rest.gxd -= group.gxd;
    rest.gyd -= group.gyd;
    if (!rest.regular()) return figures;
    const auto without = rest.shift();
    for (std::size_t k = 0; k < 2; ++k) scatter[k] += std::pow(without[k] - whole[k], 2);
  }
  figures.measured = true;
  figures.x_px = whole[0];
  figures.y_px = whole[1];
  figures.sd_x_px = std::sqrt(scatter[0] * (kGroups - 1) / kGroups);
  figures.sd_y_px = std::sqrt(scatter[1] * (kGroups - 1) / kGroups);
  return figures;
}

BiasFigures bias_of(std::span<const Block> blocks) {
  BiasFigures figures;
  std::array<double, 3> sum{}, squares{};
  for (const Block& block : blocks) {
    if (!block.usable) continue;
    ++figures.n_blocks;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = block.mean_b[k] - block.mean_a[k];
      sum[k] += d;
      squares[k] += d * d;
    }
  }
  if (figures.n_blocks == 0) return figures;
  const double n = figures.n_blocks;
  for (std::size_t k = 0; k < 3; ++k) {
    figures.lab[k] = sum[k] / n;
    const double variance = std::max(0.0, squares[k] / n - figures.lab[k] * figures.lab[k]);
    figures.sd[k] = n > 1 ? std::sqrt(variance / (n - 1)) : 0;
  }
  return figures;
}

}  // namespace reseau::compare
