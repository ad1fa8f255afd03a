#include "capture/compare/edge_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace reseau::compare {
namespace {

// Sides of the regions that are tried [blocks], and how many of each.
constexpr std::array<int, 3> kSides{8, 4, 3};
constexpr std::size_t kPlacesPerSide = 10;
// The direction of the gradients must be as one, and slanted.
constexpr double kLeastCoherence = 0.85;
constexpr double kLeastSlantDeg = 2.0;

struct Place {
  int x = 0, y = 0;  // blocks
  double score = 0;
};

struct Tensor {
  double xx = 0, xy = 0, yy = 0;
  bool usable = true;
};

Tensor tensor_at(std::span<const Block> blocks, int across, int x, int y, int side) {
  Tensor t;
  for (int j = y; j < y + side; ++j) {
    for (int i = x; i < x + side; ++i) {
      const Block& b = blocks[static_cast<std::size_t>(j) * static_cast<std::size_t>(across) +
                              static_cast<std::size_t>(i)];
      t.usable = t.usable && b.usable;
      t.xx += b.xx;
      t.xy += b.xy;
      t.yy += b.yy;
    }
  }
  return t;
}

double score_of(const Tensor& t) {
  const double trace = t.xx + t.yy;
  const double spread = std::hypot(t.xx - t.yy, 2 * t.xy);
  if (!t.usable || !(trace > 0) || spread < kLeastCoherence * trace) return 0;
  const double normal_deg = 0.5 * std::atan2(2 * t.xy, t.xx - t.yy) * 180 / std::numbers::pi;
  const double slant = std::abs(std::remainder(normal_deg, 90.0));
  if (slant < kLeastSlantDeg || slant > 45 - kLeastSlantDeg) return 0;
  return spread;
}

std::vector<Place> places(std::span<const Block> blocks, int across, int side) {
  const int down = across > 0 ? static_cast<int>(blocks.size()) / across : 0;
  std::vector<Place> result;
  const int step = std::max(1, side / 2);
  for (int y = 0; y + side <= down; y += step) {
    for (int x = 0; x + side <= across; x += step) {
      const double score = score_of(tensor_at(blocks, across, x, y, side));
      if (score > 0) result.push_back({x, y, score});
    }
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Place& a, const Place& b) { return a.score > b.score; });
  result.resize(std::min(result.size(), kPlacesPerSide));
  return result;
}

}  // namespace

std::optional<EdgeSignal> EdgeSignal::of(std::span<const float> xyz) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double n = 0;
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    const Eigen::Vector3d v(double{xyz[i]}, double{xyz[i + 1]}, double{xyz[i + 2]});
    if (!v.allFinite()) continue;
    sum += v;
    products += v * v.transpose();
    n += 1;
  }
  if (n < 2) return std::nullopt;
  const Eigen::Vector3d mean = sum / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(products / n - mean * mean.transpose());
  if (axes.info() != Eigen::Success || !(axes.eigenvalues()[2] > 1e-12)) return std::nullopt;
  Eigen::Vector3d direction = axes.eigenvectors().col(2);
  if (direction.sum() < 0) direction = -direction;
  EdgeSignal signal;
  signal.mean_ = {mean[0], mean[1], mean[2]};
  signal.direction_ = {direction[0], direction[1], direction[2]};
  return signal;
}

std::vector<double> EdgeSignal::apply(std::span<const float> xyz) const {
  std::vector<double> signal(xyz.size() / 3);
  for (std::size_t i = 0; i < signal.size(); ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      sum += direction_[k] * (double{xyz[3 * i + k]} - mean_[k]);
    }
    signal[i] = sum;
  }
  return signal;
}

std::optional<FoundEdge> find_edge(std::span<const Block> blocks, int across,
                                   const std::function<std::vector<float>(const Rect&)>& read) {
  std::optional<FoundEdge> best;
  double best_score = 0;
  for (const int side : kSides) {
    for (const Place& place : places(blocks, across, side)) {
      const Rect area{place.x * kBlockPx, place.y * kBlockPx, side * kBlockPx, side * kBlockPx};
      const std::vector<float> xyz = read(area);
      const auto signal = EdgeSignal::of(xyz);
      if (!signal) continue;
      const EdgeMtf mtf = measure_edge(signal->apply(xyz), area.width_px, area.height_px);
      if (!mtf.ok()) continue;
      // A perfect edge must not win over a longer one by its last digits.
      const double score =
          mtf.contrast * std::sqrt(mtf.length_px * mtf.support_px) / (0.01 + mtf.residual);
      if (score > best_score) {
        best_score = score;
        best = FoundEdge{area, mtf};
      }
    }
  }
  return best;
}

}  // namespace reseau::compare
