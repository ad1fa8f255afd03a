// The harmonic amplitudes that a tile of one channel should show: three unknown lights, one behind
// each element, through a Gaussian blur. Linear in the lights, so hypotheses are compared by what
// the best lights leave. Include from .cpp files only (Eigen).
#pragma once

#include <array>

#include <Eigen/Dense>

#include "core/geometry/vec2.h"
#include "core/screen/blur_shape.h"
#include "core/screen/screen_layout.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {

class ElementModel {
 public:
  // Mean, then kTileHarmonics times sqrt(2), so that the squared length is energy in the picture.
  using Amplitudes = Eigen::Matrix<double, kTileAmplitudes, 1>;
  using Columns = Eigen::Matrix<double, kTileAmplitudes, 3>;

  // linear: screen from scan [periods/px].
  ElementModel(const Mat2& linear, const ScreenPattern& pattern);
  // Of a family of screens: column k is site k of the layout.
  ElementModel(const Mat2& linear, ScreenLayout layout);
  // Column k: the amplitudes of element k under a blur of sigma_px.
  [[nodiscard]] Columns columns(double sigma_px, const BlurShape& shape = {}) const;

 private:
  Columns sharp_;
  std::array<Vec2, kTileAmplitudes> frequency_{};  // [cycles/px]
};

[[nodiscard]] ElementModel::Amplitudes weighted_amplitudes(
    const std::array<double, kTileAmplitudes>& amplitude);

}  // namespace reseau
