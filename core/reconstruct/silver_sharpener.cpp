#include "core/reconstruct/silver_sharpener.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/check.h"

namespace reseau {
namespace {

// A spot is so many times darker, or brighter, than each of the four places.
constexpr float kSpotRatio = 3;
constexpr float kSpotLight = 0.03F;  // below this noise makes any ratio
// The even ground of Richardson-Lucy, over clear film: noise of a scan depends little on its light.
constexpr float kGround = 4;
constexpr float kLeastSilver = -1;  // what the noise of a scan makes of black
constexpr int kPlaceStep = 16;      // pixels that share a blur

// A translation by whole periods, nearly by whole pixels, towards `side`; of some length, so that a
// spot does not hide the other.
std::array<int, 2> way_to(const std::array<Vec2, 2>& period, Vec2 side) {
  const double longest = std::max(norm(period[0]), norm(period[1]));
  std::array<int, 2> best{};
  double least = 1e30;
  constexpr int kMost = 6;
  for (int b = -kMost; b <= kMost; ++b) {
    for (int a = -kMost; a <= kMost; ++a) {
      const Vec2 way = static_cast<double>(a) * period[0] + static_cast<double>(b) * period[1];
      const double length = norm(way);
      if (length < 1.4 * longest || length > 4.5 * longest || dot(way, side) < 0.7 * length)
        continue;
      const Vec2 whole{std::round(way.x), std::round(way.y)};
      const double cost = norm(way - whole) + 0.01 * length / longest;
      if (cost >= least) continue;
      least = cost;
      best = {static_cast<int>(whole.x), static_cast<int>(whole.y)};
    }
  }
  return best;
}

// Of the square: beyond it no weight counts.
int radius_of(const SharpeningKernel& kernel) {
  constexpr int kSide = SharpeningKernel::kSide, kMiddle = SharpeningKernel::kRadius;
  int radius = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int at = y * kSide + x;
      if (kernel.weights()[static_cast<std::size_t>(at)] == 0) continue;
      radius = std::max({radius, std::abs(x - kMiddle), std::abs(y - kMiddle)});
    }
  }
  return radius;
}

}  // namespace

SilverSharpener::SilverSharpener(const BlurLevels& levels, const BlurSurface& blur,
                                 const std::array<Vec2, 2>& period_px)
    : levels_(levels), blur_(blur) {
  const double turn = std::sqrt(0.5);
  const std::array<Vec2, 4> sides{{{turn, turn}, {turn, -turn}, {-turn, turn}, {-turn, -turn}}};
  int way = 0;
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    ways_[i] = way_to(period_px, sides[i]);
    way = std::max({way, std::abs(ways_[i][0]), std::abs(ways_[i][1])});
  }
  for (const BlurLevel& level : levels.levels()) {
    CHECK(level.sharpening.has_value());
    kernel_radius_ = std::max(kernel_radius_, radius_of(*level.sharpening));
    iterations_ = std::max(iterations_, level.sharpening->iterations());
    grow_ = std::max(grow_, 1 + static_cast<int>(std::ceil(2 * level.sigma_px)));
  }
  reach_px_ = kernel_radius_ * std::max(1, 2 * iterations_) + grow_ + way;
}

std::vector<unsigned char> SilverSharpener::spots(const SilverPlane& plane) const {
  const int width = plane.width, height = plane.height;
  const auto at = [&](int x, int y) { return plane.values[y * plane.stride + x]; };
  std::vector<unsigned char> core(static_cast<std::size_t>(width) *
                                  static_cast<std::size_t>(height)),
      grown(core.size());
  bool any = false;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float here = at(x, y);
      float least = 1e30F, most = -1e30F;
      bool whole = true;
      for (const auto& [dx, dy] : ways_) {
        const int there_x = x + dx, there_y = y + dy;
        whole = whole && there_x >= 0 && there_y >= 0 && there_x < width && there_y < height;
        if (!whole) break;
        const float there = at(there_x, there_y);
        least = std::min(least, there);
        most = std::max(most, there);
      }
      if (!whole) continue;
      if (least > kSpotRatio * std::max(here, kSpotLight) ||
          here > kSpotRatio * std::max(most, kSpotLight)) {
        core[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
             static_cast<std::size_t>(x)] = 1;
        any = true;
      }
    }
  }
  if (!any) return {};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (core[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x)] == 0)
        continue;
      for (int j = std::max(0, y - grow_); j <= std::min(height - 1, y + grow_); ++j) {
        std::fill_n(grown.begin() + static_cast<std::ptrdiff_t>(j) * width + std::max(0, x - grow_),
                    std::min(width - 1, x + grow_) - std::max(0, x - grow_) + 1, std::uint8_t{1});
      }
    }
  }
  return grown;
}

void SilverSharpener::convolve(const SilverPlane& plane, const std::vector<float>& in,
                               std::vector<float>& out) const {
  constexpr int kSide = SharpeningKernel::kSide, kMiddle = SharpeningKernel::kRadius;
  const int radius = kernel_radius_, width = plane.width;
  const std::vector<BlurLevel>& levels = levels_.levels();
  std::vector<float> weights = levels[0].sharpening->weights();
  for (int y = radius; y < plane.height - radius; ++y) {
    for (int begin = 0; begin < width - radius;) {
      // Steps are fixed to the scan, as its tiles are.
      const int at_x = plane.x0 + begin;
      const int next = at_x - ((at_x % kPlaceStep) + kPlaceStep) % kPlaceStep + kPlaceStep;
      const int first = std::max(begin, radius), end = std::min(width - radius, next - plane.x0);
      begin = next - plane.x0;
      if (end <= first) continue;
      if (levels.size() > 1) {
        const BlurLevels::Place place = levels_.place(blur_.sigma_px(
            {static_cast<double>(next - kPlaceStep), static_cast<double>(plane.y0 + y)}));
        const std::vector<float>& a = levels[place.index].sharpening->weights();
        const std::vector<float>& b = levels[place.index + 1].sharpening->weights();
        for (std::size_t k = 0; k < weights.size(); ++k)
          weights[k] = a[k] + place.toward_next * (b[k] - a[k]);
      }
      const auto n = static_cast<std::size_t>(end - first);
      std::array<float, kPlaceStep> sum{};
      for (int dy = -radius; dy <= radius; ++dy) {
        const float* from = &in[static_cast<std::size_t>(y + dy) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(first - radius)];
        const float* w =
            &weights[static_cast<std::size_t>((dy + kMiddle) * kSide + kMiddle - radius)];
        for (int dx = 0; dx <= 2 * radius; ++dx, ++from, ++w) {
          for (std::size_t k = 0; k < n; ++k) sum[k] += *w * from[k];
        }
      }
      std::copy_n(sum.begin(), n, out.begin() + static_cast<std::ptrdiff_t>(y) * width + first);
    }
  }
}

void SilverSharpener::sharpen(const SilverPlane& plane) const {
  const auto width = static_cast<std::size_t>(plane.width);
  const std::vector<unsigned char> spot = spots(plane);
  std::vector<float> filled(width * static_cast<std::size_t>(plane.height));
  for (int y = 0; y < plane.height; ++y)
    std::copy_n(plane.values + y * plane.stride, width,
                filled.begin() + static_cast<std::ptrdiff_t>(y) * plane.width);
  if (!spot.empty()) {
    const std::vector<float> seen = filled;
    for (int y = 0; y < plane.height; ++y) {
      for (int x = 0; x < plane.width; ++x) {
        const std::size_t here = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
        if (spot[here] == 0) continue;
        float sum = 0;
        int n = 0;
        for (const auto& [dx, dy] : ways_) {
          const int there_x = x + dx, there_y = y + dy;
          if (there_x < 0 || there_y < 0 || there_x >= plane.width || there_y >= plane.height)
            continue;
          const std::size_t there =
              static_cast<std::size_t>(there_y) * width + static_cast<std::size_t>(there_x);
          if (spot[there] != 0) continue;
          sum += seen[there];
          ++n;
        }
        if (n > 0) filled[here] = sum / static_cast<float>(n);
      }
    }
  }
  std::vector<float> sharp = filled;
  if (iterations_ == 0) {
    convolve(plane, filled, sharp);
  } else {
    for (float& value : filled) value = kGround + std::max(value, kLeastSilver);
    sharp = filled;
    std::vector<float> ratio(sharp.size(), 1.0F), correction(sharp.size(), 1.0F);
    for (int i = 0; i < iterations_; ++i) {
      ratio = filled;
      convolve(plane, sharp, ratio);
      for (std::size_t k = 0; k < ratio.size(); ++k) ratio[k] = filled[k] / ratio[k];
      convolve(plane, ratio, correction);
      for (std::size_t k = 0; k < sharp.size(); ++k) sharp[k] *= correction[k];
    }
    for (float& value : sharp) value -= kGround;
  }
  for (int y = 0; y < plane.height; ++y) {
    float* to = plane.values + y * plane.stride;
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t here = static_cast<std::size_t>(y) * width + x;
      if (spot.empty() || spot[here] == 0) to[x] = sharp[here];
    }
  }
}

}  // namespace reseau
