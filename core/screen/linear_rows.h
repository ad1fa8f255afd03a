// Rows of a source in linear light, as planes: what registration and sharpness look at.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

// Planes of rows [first, first + n): linear R, G, B and the silver S (infrared, or a weighted sum
// of R, G, B where there is none). A pixel with a clipped sample has S = 0 and so no weight.
struct LinearRows {
  int first = 0, n = 0, width_px = 0;
  std::array<std::vector<float>, 4> plane;  // [row][pixel]
  [[nodiscard]] const float* row(int channel, int row_in_block) const {
    return plane[static_cast<std::size_t>(channel)].data() +
           static_cast<std::size_t>(row_in_block) * static_cast<std::size_t>(width_px);
  }
};

// Reads and converts. Thread-bound (owns a buffer). The source must have red, green and blue
// planes; it and the curves must outlive the reader.
class LinearReader {
 public:
  LinearReader(const LineSource& source, const ToneCurves& tone);

  [[nodiscard]] bool has_infrared() const { return infrared_plane_ >= 0; }
  // Weights of R, G, B in the silver when there is no infrared. Default: a third each.
  void set_silver_from_rgb(std::array<double, 3> weights) { weights_ = weights; }
  [[nodiscard]] std::array<double, 3> silver_from_rgb() const { return weights_; }

  // Converts only every n-th group of 32 pixels of a line; the others keep what they held. 1 = all.
  void keep_every(int n) { every_ = static_cast<std::size_t>(n); }

  void read(int first, int n, LinearRows& out);

 private:
  static constexpr std::size_t kGroupPx = 32;
  void convert(std::size_t y, std::size_t x0, std::size_t x1, LinearRows& out) const;

  const LineSource& source_;
  const ToneCurves& tone_;
  std::array<int, 3> rgb_plane_{};
  int infrared_plane_ = -1;
  std::size_t every_ = 1;
  std::array<double, 3> weights_{1.0 / 3, 1.0 / 3, 1.0 / 3};
  std::vector<std::uint16_t> buffer_;
};

}  // namespace reseau
