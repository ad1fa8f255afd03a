#include "core/reconstruct/kernel_tables.h"

#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace reseau {

ElementKernels::ElementKernels(const BlurredCell& cell, const EstimatorSettings& settings,
                               const std::vector<ElementSite>& sites)
    : table_(sites.size() * kPhases * kPhases * kSide * kRow, 0.0F) {
  CHECK(settings.radius_px == kRadius);
  const LocalEstimator estimator(cell, settings);
  // A half turn about an element leaves the pattern as it was: half the phases give the others.
  constexpr int kHalf = kPhases * kPhases / 2;
  const int n = static_cast<int>(sites.size()) * kHalf;
  std::vector<double> gain(static_cast<std::size_t>(n));
  parallel_for(n, [&](int task) {
    const auto site = static_cast<std::size_t>(task / kHalf);
    const int phase = task % kHalf, phase_x = phase % kPhases, phase_y = phase / kPhases;
    const Vec2 f{(phase_x + 0.5) / kPhases - 0.5, (phase_y + 0.5) / kPhases - 0.5};
    const EstimatorTarget target{sites[site].color, f};
    const std::vector<double> w = estimator.weights(
        sites[site].middle - settings.screen_from_scan * f, std::span(&target, 1));
    float* here =
        &table_[(site * kPhases * kPhases + static_cast<std::size_t>(phase)) * kSide * kRow];
    float* opposite = &table_[(site * kPhases * kPhases + kPhases * kPhases - 1 -
                               static_cast<std::size_t>(phase)) *
                              kSide * kRow];
    double squares = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const int at = y * kSide + x;
        const double value = w[static_cast<std::size_t>(at)];
        squares += value * value;
        here[y * kRow + x] = static_cast<float>(value);
        opposite[(kSide - 1 - y) * kRow + kSide - 1 - x] = static_cast<float>(value);
      }
    }
    gain[static_cast<std::size_t>(task)] = std::sqrt(squares);
  });
  for (const double g : gain) noise_gain_ = std::max(noise_gain_, g);
}

DetailKernels::DetailKernels(const BlurredCell& cell, const EstimatorSettings& settings,
                             Vec2 offset_px)
    : table_(static_cast<std::size_t>(kPhases) * kPhases * kSide * 3 * kRow, 0.0F) {
  CHECK(settings.radius_px == kRadius);
  const LocalEstimator estimator(cell, settings);
  const bool even = offset_px == Vec2{};
  const int n = even ? kPhases * kPhases / 2 : kPhases * kPhases;
  parallel_for(n, [&](int phase) {
    const int phase_u = phase % kPhases, phase_v = phase / kPhases;
    const std::array<EstimatorTarget, 3> targets{{{0, offset_px}, {1, offset_px}, {2, offset_px}}};
    const std::vector<double> w =
        estimator.weights({(phase_u + 0.5) / kPhases, (phase_v + 0.5) / kPhases}, targets);
    float* here = &table_[static_cast<std::size_t>(phase) * kSide * 3 * kRow];
    float* opposite =
        &table_[static_cast<std::size_t>(kPhases * kPhases - 1 - phase) * kSide * 3 * kRow];
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const int at = (c * kSide + y) * kSide + x;
          const auto value = static_cast<float>(w[static_cast<std::size_t>(at)]);
          here[(y * 3 + c) * kRow + x] = value;
          if (even) opposite[((kSide - 1 - y) * 3 + c) * kRow + kSide - 1 - x] = value;
        }
      }
    }
  });
}

}  // namespace reseau
