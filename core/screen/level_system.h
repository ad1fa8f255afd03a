// The equations of one level of a smooth surface. Include from .cpp files of this folder only.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/screen/spline_surface.h"

namespace reseau {

// Weights of the 4 x 4 nodes about a place; (i, j) is the first.
struct SplineBasis {
  std::array<double, 4> x, y;
  int i = 0, j = 0;
};
[[nodiscard]] SplineBasis basis_at(const SplineSurface& grid, Vec2 p);
[[nodiscard]] std::vector<SplineBasis> bases_at(const SplineSurface& grid,
                                                const std::vector<Vec2>& positions);
[[nodiscard]] double value_at(const SplineSurface& grid, const SplineBasis& basis);

// What samples say of the nodes of a level: normal equations in which a node is coupled with its
// 7 x 7 neighbourhood. Immutable.
class LevelData {
 public:
  static constexpr int kReach = 3, kSide = 2 * kReach + 1;
  static constexpr std::size_t kCoupled = static_cast<std::size_t>(kSide) * kSide, kSelf = 24;

  // Samples of weight 0 are left out.
  LevelData(const SplineSurface& grid, const std::vector<SplineBasis>& places,
            const std::vector<double>& values, const std::vector<double>& weights);

  [[nodiscard]] int nx() const { return nx_; }
  [[nodiscard]] int ny() const { return ny_; }
  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) +
           static_cast<std::size_t>(i);
  }
  // Of the neighbour (di, dj) among the coupled.
  static std::size_t place(int di, int dj) {
    const int at = (dj + kReach) * kSide + di + kReach;
    return static_cast<std::size_t>(at);
  }
  [[nodiscard]] const double* coupled(int i, int j) const {
    return &matrix_[index(i, j) * kCoupled];
  }
  [[nodiscard]] double right(int i, int j) const { return right_[index(i, j)]; }
  // About what one sample puts on the diagonal.
  [[nodiscard]] double unit() const { return unit_; }
  // Whether neither a node nor one of the eight about it was seen.
  [[nodiscard]] bool far_from_seen(int i, int j) const;

 private:
  void add(const SplineBasis& basis, double weight, double value);
  void mirror();

  int nx_, ny_;
  std::vector<double> matrix_;  // [node][neighbour]
  std::vector<double> right_;
  double unit_ = 1;
};

// The same with a stiffness, laid out so that eight nodes side by side are worked on together:
// a[eight nodes][neighbour][node], rows of nodes filled up with zeros. Vectors have zeros all
// around as well. Borrows the data. Immutable.
class LevelSystem {
 public:
  LevelSystem(const LevelData& data, double stiffness);

  // Coefficients of all nodes, down to a share of the first residual, squared. Conjugate gradients
  // with a diagonal preconditioner: sums in a fixed order, so the result is the same on any number
  // of threads.
  [[nodiscard]] std::vector<double> solve(double tolerance, int most_iterations) const;

 private:
  static constexpr int kAtOnce = 8;

  [[nodiscard]] std::size_t vector_size() const {
    return static_cast<std::size_t>(stride_) *
           static_cast<std::size_t>(data_.ny() + 2 * LevelData::kReach);
  }
  [[nodiscard]] std::size_t entry(int i, int j, std::size_t neighbour) const {
    const auto node = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(i);
    return (node / kAtOnce * LevelData::kCoupled + neighbour) * kAtOnce + node % kAtOnce;
  }
  [[nodiscard]] std::size_t in_vector(int i, int j) const {
    return static_cast<std::size_t>(j + LevelData::kReach) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(i + LevelData::kReach);
  }
  void add_bending(double weight);
  void multiply(const std::vector<double>& x, std::vector<double>& y) const;
  static double product(const std::vector<double>& a, const std::vector<double>& b);

  const LevelData& data_;
  int columns_, stride_;
  std::vector<double> a_, b_, inverse_diagonal_;
};

}  // namespace reseau
