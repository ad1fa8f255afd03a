// Intensities of the elements of a piece of the picture: collected from the silver, cleared of each
// other's light, and interpolated.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blurred_cell.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// Thread-bound; one per piece. Use: add() every pixel, finish(), then at().
class ElementField {
 public:
  // Covers screen coordinates [lowest, highest] with room for interpolation.
  ElementField(const ScreenPattern& pattern, Vec2 lowest, Vec2 highest);

  // A pixel at screen coordinates (u, v) with this silver; `shares` from BlurredCell. Pixels that
  // show nothing (clipped, not a number) are left out by the caller.
  void add(float u, float v, float silver, const std::array<float, 3>& shares);

  // Turns sums into intensities. `mean_crosstalk` serves where an element has too few pixels of its
  // own. `ridge` bounds the amplification of noise: directions of colour whose crosstalk singular
  // value lies below sqrt(ridge) are pulled towards grey.
  void finish(const std::array<std::array<double, 3>, 3>& mean_crosstalk, double ridge,
              int n_refinements);

  // Process RGB at (u, v), bicubic (Catmull-Rom) on each colour's own lattice.
  [[nodiscard]] std::array<float, 3> at(float u, float v) const;

 private:
  struct Sums {
    float weight = 0, silver = 0;
    std::array<float, 3> shares{};
  };
  struct Lattice {
    Vec2 origin, step;
    int first_i = 0, first_j = 0, n_i = 0, n_j = 0;
    std::vector<Sums> sums;
    std::vector<float> value, residual;
    std::vector<unsigned char> filled;
    [[nodiscard]] std::size_t index(int i, int j) const {
      return static_cast<std::size_t>(j) * static_cast<std::size_t>(n_i) +
             static_cast<std::size_t>(i);
    }
    [[nodiscard]] float lattice_x(float u) const {
      return (u - static_cast<float>(origin.x)) / static_cast<float>(step.x) -
             static_cast<float>(first_i);
    }
    [[nodiscard]] float lattice_y(float v) const {
      return (v - static_cast<float>(origin.y)) / static_cast<float>(step.y) -
             static_cast<float>(first_j);
    }
  };
  void normalise(Lattice& lattice, std::size_t color,
                 const std::array<std::array<double, 3>, 3>& mean);
  static float bilinear(const Lattice& lattice, const std::vector<float>& values, float u, float v);
  void unmix(const std::vector<float> Lattice::*from, double ridge, bool add);

  static void smooth_pairs(Lattice& lattice);

  std::array<Lattice, 3> lattice_;
};

}  // namespace reseau
