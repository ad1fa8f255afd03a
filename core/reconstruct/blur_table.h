// What no light behind the three elements explains of a tile's amplitudes, for a row of blurs.
// Include from .cpp files only (Eigen).
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "core/screen/blur_shape.h"
#include "core/screen/element_model.h"

namespace reseau {

// No blur beyond these is looked for [px].
inline constexpr double kLeastSigmaPx = 0.2, kMostSigmaPx = 4.0;

// Immutable, thread-safe.
class BlurTable {
 public:
  static constexpr int kLeft = kTileAmplitudes - 3;
  // Orthonormal columns of all that the elements cannot make under a blur.
  using Left = Eigen::Matrix<double, kTileAmplitudes, kLeft>;

  BlurTable(const ElementModel& model, const BlurShape& shape);

  // Blurs grow by 3 % from index to index.
  static constexpr double kRatio = 1.03;
  [[nodiscard]] static double sigma_px(double index) {
    return kLeastSigmaPx * std::pow(kRatio, index);
  }
  [[nodiscard]] static double index_of(double sigma_px) {
    return std::log(sigma_px / kLeastSigmaPx) / std::log(kRatio);
  }
  [[nodiscard]] int size() const { return static_cast<int>(left_.size()); }
  [[nodiscard]] const Left& left(int index) const { return left_[static_cast<std::size_t>(index)]; }

 private:
  std::vector<Left> left_;
};

// The same for one blur.
[[nodiscard]] BlurTable::Left left_of(const ElementModel::Columns& columns);

}  // namespace reseau
