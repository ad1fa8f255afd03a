#include "core/reconstruct/blur_levels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

// Of the Gaussian that is left of a blur, by what the réseau's own frequencies keep.
double remaining_blur_px(const BlurLevelSettings& settings, double sigma_px,
                         const SharpeningKernel& kernel) {
  constexpr double kPi = std::numbers::pi, kLeast = 0.3;
  const Mat2& m = settings.screen_from_scan;
  double variance = 0;
  for (const Vec2 f : {Vec2{m.a, m.b}, Vec2{m.c, m.d}}) {
    const double kept = settings.shape.transfer(f, sigma_px) * kernel.gain(f);
    variance += -std::log(std::clamp(kept, 1e-6, 1.0)) / (2 * kPi * kPi * dot(f, f)) / 2;
  }
  return std::clamp(std::sqrt(variance), kLeast, std::max(kLeast, sigma_px));
}

}  // namespace

BlurLevels::BlurLevels(const ScreenPattern& pattern, const BlurLevelSettings& settings) {
  for (int color = 0; color < 3; ++color) {
    const ElementLattice& lattice = pattern.lattices()[static_cast<std::size_t>(color)];
    first_site_[static_cast<std::size_t>(color)] = sites_.size();
    const Mat2 from_index = lattice.to_index.inverse();
    for (int i = 0; i < lattice.n_sites; ++i) {
      // Along one of the axes every kind of site is met.
      const int step = lattice.site_step[0] != 0 ? 0 : 1;
      const Vec2 index{step == 0 ? double(i) : 0.0, step == 0 ? 0.0 : double(i)};
      sites_.push_back({color, lattice.origin + from_index * index});
    }
  }
  CHECK(settings.least_sigma_px > 0 && settings.most_sigma_px >= settings.least_sigma_px);
  const double span = std::log(settings.most_sigma_px / settings.least_sigma_px);
  const int n = span > 0 ? 1 + static_cast<int>(std::ceil(span / std::log(settings.ratio))) : 1;
  levels_.reserve(static_cast<std::size_t>(n));
  const auto sigma_of = [&](int i) {
    return settings.least_sigma_px * std::exp(n > 1 ? span * i / (n - 1) : 0.0);
  };
  const bool sharpens = settings.deconvolution != Deconvolution::kNone;
  // All places are iterated alike, so that neighbours fit together.
  int iterations = SharpeningKernel::kMostIterations;
  for (int i = 0; i < n && sharpens; ++i) {
    iterations = std::min(iterations, SharpeningKernel(settings.deconvolution, settings.shape,
                                                       sigma_of(i), settings.noise_sd)
                                          .iterations());
  }
  for (int i = 0; i < n; ++i) {
    const double sigma = sigma_of(i);
    std::optional<SharpeningKernel> sharpening;
    double left_px = sigma, noise_sd = settings.noise_sd;
    if (sharpens) {
      sharpening.emplace(settings.deconvolution, settings.shape, sigma, settings.noise_sd,
                         iterations);
      left_px = remaining_blur_px(settings, sigma, *sharpening);
      noise_sd *= sharpening->noise_gain();
    }
    BlurredCell cell(pattern, settings.screen_from_scan, sigma, settings.shape,
                     sharpening ? &*sharpening : nullptr);
    const EstimatorSettings estimator{settings.screen_from_scan, left_px,
                                      settings.shape.stretch,    noise_sd,
                                      ElementKernels::kRadius,   settings.line_alternation_sd,
                                      settings.line_color};
    ElementKernels elements(cell, estimator, sites_);
    std::optional<DetailKernels> detail;
    if (settings.detail) {
      EstimatorSettings wide = estimator;
      wide.radius_px = DetailKernels::kRadius;
      detail.emplace(cell, wide, settings.detail_offset_px);
    }
    levels_.push_back(
        {sigma, std::move(sharpening), std::move(cell), std::move(elements), std::move(detail)});
  }
}

BlurLevels::Place BlurLevels::place(double sigma_px) const {
  if (levels_.size() < 2) return {};
  const double first = std::log(levels_.front().sigma_px),
               step = std::log(levels_[1].sigma_px) - first;
  const double x = std::clamp((std::log(std::max(sigma_px, 1e-3)) - first) / step, 0.0,
                              static_cast<double>(levels_.size() - 1));
  const auto index = std::min(static_cast<std::size_t>(x), levels_.size() - 2);
  return {index, static_cast<float>(x - static_cast<double>(index))};
}

}  // namespace reseau
