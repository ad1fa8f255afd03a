// Rows of a source in linear light, as planes: what registration and sharpness look at.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

// Planes of rows [first, first + n): linear R, G, B and the silver S (infrared, or a weighted sum
// of R, G, B where there is none). A pixel with a clipped sample has S = 0 and so no weight.
// Of one channel alone ("grey"): plane 0 is the logarithm of its light, in which a pattern is as
// strong where the picture is dark, and the other planes are 1.
struct LinearRows {
  int first = 0, n = 0, width_px = 0;
  bool grey = false;
  std::array<std::vector<float>, 4> plane;  // [row][pixel]
  [[nodiscard]] const float* row(int channel, int row_in_block) const {
    return plane[static_cast<std::size_t>(channel)].data() +
           static_cast<std::size_t>(row_in_block) * static_cast<std::size_t>(width_px);
  }
};

// Reads and converts. Thread-bound (owns a buffer). A source without red, green and blue planes is
// read as grey. It and the curves must outlive the reader.
class LinearReader {
 public:
  LinearReader(const LineSource& source, const ToneCurves& tone);

  [[nodiscard]] bool has_infrared() const { return infrared_plane_ >= 0; }
  // Weights of R, G, B in the silver when there is no infrared. Default: a third each.
  void set_silver_from_rgb(std::array<double, 3> weights) { weights_ = weights; }
  [[nodiscard]] std::array<double, 3> silver_from_rgb() const { return weights_; }

  // Looks at green alone, where all three colours are the same.
  void set_grey() { grey_plane_ = grey_plane_ >= 0 ? grey_plane_ : rgb_plane_[1]; }
  [[nodiscard]] bool grey() const { return grey_plane_ >= 0; }

  void read(int first, int n, LinearRows& out);

 private:
  void take_grey(LinearRows& out) const;

  const LineSource& source_;
  const ToneCurves& tone_;
  std::array<int, 3> rgb_plane_{};
  int infrared_plane_ = -1, grey_plane_ = -1;
  std::array<double, 3> weights_{1.0 / 3, 1.0 / 3, 1.0 / 3};
  std::vector<std::uint16_t> buffer_;
};

}  // namespace reseau
