#include "core/reconstruct/pattern_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

constexpr int kTilesAcross = 4;
constexpr double kLeastSigmaPx = 0.2, kMostSigmaPx = 3, kSigmaStepPx = 0.05;
// No screen was printed nearer to its description than to this share of what alternates, squared.
constexpr double kPrintError2 = 0.01 * 0.01;

std::vector<ShapeTile> tiles_of(const LineSource& source, const ToneCurves& tone,
                                const ScreenMap& map, double period_px) {
  const LineFormat& format = source.format();
  const int height = source.committed();
  const int size =
      std::min({std::max(64, static_cast<int>(std::ceil(6 * period_px))), format.width_px, height});
  const int nx = std::clamp(format.width_px / size, 1, kTilesAcross),
            ny = std::clamp(height / size, 1, kTilesAcross);
  const auto start = [size](int i, int n, int extent) {
    return n > 1 ? static_cast<int>(static_cast<long long>(i) * (extent - size) / (n - 1)) : 0;
  };
  std::vector<std::optional<ShapeTile>> tiles(static_cast<std::size_t>(nx) *
                                              static_cast<std::size_t>(ny));
  parallel_for(ny, [&](int j) {
    LinearReader reader(source, tone);
    LinearRows rows;
    reader.read(start(j, ny, height), size, rows);
    for (int i = 0; i < nx; ++i)
      tiles[static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) +
            static_cast<std::size_t>(i)] =
          measure_shape_tile(rows, start(i, nx, format.width_px), size, map);
  });
  std::vector<ShapeTile> seen;
  for (const std::optional<ShapeTile>& tile : tiles) {
    if (tile) seen.push_back(*tile);
  }
  return seen;
}

// Share of what alternates in red, green and blue that no lights behind these elements explain,
// under the blur that leaves least in each.
double unexplained(const std::vector<ShapeTile>& tiles, const Mat2& linear,
                   const ScreenPattern& pattern) {
  constexpr int kAmplitudes = 1 + static_cast<int>(kShapeHarmonics.size());
  using Columns = Eigen::Matrix<double, kAmplitudes, 3>;  // of the three lights
  const Mat2 frequency = linear.transposed();
  // Both members of a pair of conjugates count.
  Eigen::Matrix<double, kAmplitudes, 1> weight, f2;
  Columns sharp;
  for (int i = 0; i < kAmplitudes; ++i) {
    const HarmonicIndex h =
        i > 0 ? kShapeHarmonics[static_cast<std::size_t>(i - 1)] : HarmonicIndex{};
    const Vec2 f = frequency * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
    f2(i) = dot(f, f);
    weight(i) = i == 0 ? 1 : is_sampled(frequency, h) ? std::numbers::sqrt2 : 0;
    for (int k = 0; k < 3; ++k) sharp(i, k) = weight(i) * pattern.fourier(k, h.u, h.v).real();
  }
  double left = 0, all = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    Eigen::Matrix<double, kAmplitudes, Eigen::Dynamic> seen(kAmplitudes, tiles.size());
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      for (int i = 0; i < kAmplitudes; ++i)
        seen(i, static_cast<Eigen::Index>(t)) =
            weight(i) * tiles[t].amplitude[c][static_cast<std::size_t>(i)];
    }
    double least = 1e300;
    for (double sigma = kLeastSigmaPx; sigma < kMostSigmaPx; sigma += kSigmaStepPx) {
      const double k = -2 * std::numbers::pi * std::numbers::pi * sigma * sigma;
      const Columns columns = (k * f2).array().exp().matrix().asDiagonal() * sharp;
      least = std::min(least, (seen - columns * columns.householderQr().solve(seen)).squaredNorm());
    }
    left += least;
    all += seen.bottomRows(kAmplitudes - 1).squaredNorm();
  }
  return all > 0 ? left / all : 0;
}

}  // namespace

std::vector<PatternEvidence> pattern_evidence(const LineSource& source, const ToneCurves& tone,
                                              const ScreenMap& map, double period_px,
                                              const std::vector<ScreenKind>& kinds) {
  if (kinds.size() < 2) return {};
  const std::vector<ShapeTile> tiles = tiles_of(source, tone, map, period_px);
  if (tiles.empty()) return {};
  std::vector<double> left;
  left.reserve(kinds.size());
  for (const ScreenKind kind : kinds) {
    const PrintedScreen printed =
        printed_screen(screen_names()[static_cast<std::size_t>(kind)].name);
    left.push_back(unexplained(tiles, map.linear(), printed.pattern(printed.usual)));
  }
  const double least = *std::ranges::min_element(left);
  std::vector<PatternEvidence> evidence;
  evidence.reserve(kinds.size());
  for (std::size_t k = 0; k < kinds.size(); ++k)
    evidence.push_back({kinds[k], -0.5 * (left[k] - least) / kPrintError2});
  return evidence;
}

}  // namespace reseau
