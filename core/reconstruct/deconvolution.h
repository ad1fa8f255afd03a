// What is taken back of the blur of the silver at the sampling of the scan, before its elements are
// looked at.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/blur_shape.h"

namespace reseau {

// wiener: the linear estimate of least error. richardson-lucy: the iteration for light whose noise
// grows with it over a ground that is the same everywhere (Snyder, Hammoud and White 1993), which
// keeps it nearly linear: the loss of saturation that is undone afterwards depends on that.
enum class Deconvolution { kNone, kWiener, kRichardsonLucy };
// "none", "wiener" or "richardson-lucy"; InputError for anything else.
[[nodiscard]] Deconvolution parse_deconvolution(std::string_view name);
[[nodiscard]] std::string_view deconvolution_name(Deconvolution method);

// The deconvolution of one blur. Immutable, thread-safe.
class SharpeningKernel {
 public:
  static constexpr int kRadius = 8, kSide = 2 * kRadius + 1;
  // Nothing is amplified by more: by Wiener's filter at any frequency, and, as the mean over
  // frequencies, where Richardson-Lucy stops; nor does it run for longer.
  static constexpr double kMostGain = 4, kMostMeanGain = 2;
  static constexpr int kMostIterations = 10;

  // method: not kNone. noise_sd: of a pixel over the light.
  SharpeningKernel(Deconvolution method, const BlurShape& shape, double sigma_px, double noise_sd,
                   int most_iterations = kMostIterations);

  // By how much a variation of f [cycles/px] grows; of Richardson-Lucy, a small one.
  [[nodiscard]] double gain(Vec2 f) const;
  // By how much the noise of a pixel grows.
  [[nodiscard]] double noise_gain() const { return noise_gain_; }
  // Of Richardson-Lucy, the first at which noise has grown by kMostMeanGain, or the most.
  [[nodiscard]] int iterations() const { return iterations_; }
  // kSide x kSide: of Wiener's filter, or of the blur that Richardson-Lucy undoes. Sum 1, even.
  [[nodiscard]] const std::vector<float>& weights() const { return weights_; }

 private:
  [[nodiscard]] double transform(Vec2 f) const;

  Deconvolution method_;
  std::vector<float> weights_;
  double noise_gain_ = 1;
  int iterations_ = 0;
};

}  // namespace reseau
