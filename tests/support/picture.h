// A picture in memory and how far it is from the truth.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "core/color/colorimetry.h"
#include "core/color/delta_e.h"
#include "core/reconstruct/row_sink.h"
#include "core/screen/screen_map.h"

namespace reseau::test {

class MemorySink final : public RgbRowSink {
 public:
  int width = 0, height = 0;
  bool ended = false;
  std::vector<float> rgb;

  void begin(int width_px, int height_px) override {
    width = width_px;
    height = height_px;
    rgb.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, -1.0F);
  }
  void rows(int first_row, int /*n_rows*/, std::span<const float> samples) override {
    std::copy(samples.begin(), samples.end(),
              rgb.begin() + static_cast<std::ptrdiff_t>(first_row) * width * 3);
  }
  void end() override { ended = true; }

  // Mean of a rectangle, borders included.
  [[nodiscard]] std::array<double, 3> mean(int x0, int y0, int x1, int y1) const {
    std::array<double, 3> sum{};
    int n = 0;
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x, ++n) {
        const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(x)) *
                               3;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(rgb[at + c]);
      }
    }
    for (double& value : sum) value /= std::max(n, 1);
    return sum;
  }
};

// CIEDE2000 of two process RGB values taken as linear sRGB.
inline double process_delta_e(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  constexpr std::array<double, 9> kXyzFromSrgb{0.4123908, 0.3575843, 0.1804808,
                                               0.2126390, 0.7151687, 0.0721923,
                                               0.0193308, 0.1191948, 0.9505322};
  const auto lab = [&](const std::array<double, 3>& p) {
    Xyz xyz{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) xyz[i] += kXyzFromSrgb[3 * i + j] * p[j];
    }
    return lab_from_xyz(xyz, {0.9505, 1.0, 1.0890});
  };
  return delta_e_2000(lab(a), lab(b));
}

struct PatchErrors {
  double mean = 0, max = 0;
  int n = 0;
};

// CIEDE2000 of the mean over squares whose true scene is flat, as is `margin` around them,
// everywhere in the picture.
inline PatchErrors flat_patches(
    const MemorySink& sink, const std::function<std::array<double, 3>(double, double)>& process_rgb,
    int side, int margin = 0) {
  constexpr int kStep = 40, kBorder = 20;
  PatchErrors result;
  double sum = 0;
  for (int y = kBorder; y + side < sink.height - kBorder; y += kStep) {
    for (int x = kBorder; x + side < sink.width - kBorder; x += kStep) {
      const auto middle = process_rgb(x + side / 2.0, y + side / 2.0);
      std::array<double, 3> mean{};
      bool flat = true;
      int n = 0;
      for (int b = -margin; b <= side + margin; b += 5) {
        for (int a = -margin; a <= side + margin; a += 5) {
          const auto value = process_rgb(x + a, y + b);
          const bool inside = a >= 0 && b >= 0 && a <= side && b <= side;
          if (inside) ++n;
          for (std::size_t c = 0; c < 3; ++c) {
            if (inside) mean[c] += value[c];
            flat = flat && std::abs(value[c] - middle[c]) < 0.1;
          }
        }
      }
      if (!flat) continue;
      for (double& value : mean) value /= n;
      const double e = process_delta_e(sink.mean(x, y, x + side, y + side), mean);
      sum += e;
      result.max = std::max(result.max, e);
      ++result.n;
    }
  }
  result.mean = sum / std::max(result.n, 1);
  return result;
}

using TrueScreen = std::function<std::array<double, 2>(double, double)>;

// Rms distance [px] of a map from the truth over the frame, after the symmetries that the pattern
// cannot tell: whole periods and half turns.
inline double map_error_px(const ScreenMap& map, const TrueScreen& truth, int width, int height) {
  double best = 1e30;
  const Vec2 middle{width / 2.0, height / 2.0};
  for (const double sign_u : {1.0, -1.0}) {
    for (const double sign_v : {1.0, -1.0}) {
      const auto t0 = truth(middle.x, middle.y);
      const Vec2 m0 = map.screen_from_scan(middle);
      const Vec2 offset{std::round(sign_u * t0[0] - m0.x), std::round(sign_v * t0[1] - m0.y)};
      double sum = 0;
      int n = 0;
      for (int y = 0; y < height; y += 7) {
        for (int x = 0; x < width; x += 7, ++n) {
          const Vec2 p{static_cast<double>(x), static_cast<double>(y)};
          const auto t = truth(p.x, p.y);
          const Vec2 off = Vec2{sign_u * t[0], sign_v * t[1]} - offset - map.screen_from_scan(p);
          const Vec2 off_px = map.jacobian(p).inverse() * off;
          sum += dot(off_px, off_px);
        }
      }
      best = std::min(best, std::sqrt(sum / n));
    }
  }
  return best;
}

}  // namespace reseau::test
