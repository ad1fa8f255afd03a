#include "calibration/edge/profile_bins.h"

#include <algorithm>
#include <cmath>

namespace reseau {
namespace {

constexpr double kFinePx = 8;
constexpr double kFinePerPx = 64, kCoarsePerPx = 16;

}  // namespace

ProfileBins::ProfileBins(double reach_px)
    : reach_(reach_px),
      sums_(2 * static_cast<std::size_t>(kFinePx * kFinePerPx +
                                         std::max(0.0, reach_px - kFinePx) * kCoarsePerPx + 2)) {}

void ProfileBins::add(double d, double value, double weight) {
  const double a = std::abs(d);
  if (!(a <= reach_) || !(weight > 0)) return;
  const double at =
      a < kFinePx ? a * kFinePerPx : kFinePx * kFinePerPx + (a - kFinePx) * kCoarsePerPx;
  const std::size_t half = sums_.size() / 2;
  const std::size_t i = std::min(static_cast<std::size_t>(at), half - 1);
  Sums& s = sums_[d < 0 ? half - 1 - i : half + i];
  // Means and sums about them, updated sample by sample.
  s.n += 1;
  s.weight += weight;
  const double by_d = d - s.distance, by_v = value - s.value;
  s.distance += by_d * weight / s.weight;
  s.value += by_v * weight / s.weight;
  s.dd += weight * by_d * (d - s.distance);
  s.dv += weight * by_d * (value - s.value);
  s.vv += weight * by_v * (value - s.value);
  n_ += 1;
}

std::vector<ProfileBins::Bin> ProfileBins::bins() const {
  std::vector<Bin> out;
  for (const Sums& s : sums_) {
    if (s.n > 0) out.push_back({s.weight, s.distance, s.value, s.dd, s.dv, s.vv, s.n - 1});
  }
  return out;
}

}  // namespace reseau
