// The silver of some rows of the picture, continued beyond the frame.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/silver_sharpener.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

struct SilverSettings {
  const LineSource* source = nullptr;
  const ToneCurves* tone = nullptr;
  double white_level = 1;
  bool infrared = true;                        // else a weighted sum of R, G, B
  std::array<double, 3> silver_from_rgb{};     // its weights
  double offset = 0;                           // added to the linear samples
  std::array<Vec2, 2> period_px{};             // the two translations of the réseau
  int margin_px = 0;                           // kept around the rows, on all four sides
  const SilverSharpener* sharpener = nullptr;  // deconvolves; null: nothing does
};

// Silver transmittance, 1 = clear film, of rows [first - margin, end + margin) and columns
// [-margin, width + margin). Beyond the frame the réseau must go on in step, so a pixel there is
// that of the picture whole periods further in. Every value is finite. Immutable, thread-safe.
class SilverRows {
 public:
  SilverRows(const SilverSettings& settings, int first, int end);

  [[nodiscard]] const float* at(int x, int y) const {
    return &values_[static_cast<std::size_t>(y - top_) * stride_ +
                    static_cast<std::size_t>(x + margin_)];
  }
  [[nodiscard]] std::ptrdiff_t stride() const { return static_cast<std::ptrdiff_t>(stride_); }
  // Samples at full scale in rows [first, end), R G B IR.
  [[nodiscard]] const std::array<std::size_t, 4>& clipped() const { return clipped_; }

 private:
  void read(const SilverSettings& settings, int first, int end);
  void continue_beyond(const SilverSettings& settings);
  [[nodiscard]] float sample(Vec2 p, int x_end, int y_first, int y_end) const;

  int margin_, top_, rows_;
  std::size_t stride_;
  std::vector<float> values_;
  std::array<std::size_t, 4> clipped_{};
};

}  // namespace reseau
