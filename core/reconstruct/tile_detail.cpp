// What the silver holds beyond the picture between elements.
#include <algorithm>
#include <cmath>

#include "core/base/float4.h"
#include "core/reconstruct/silver_ratio.h"
#include "core/reconstruct/tile_renderer.h"

namespace reseau {
namespace {

constexpr int kSigmaStep = 16;  // pixels that share a blur

}  // namespace

std::vector<float> TileRenderer::predict(const MapGrid& silver_at, const PixelBounds& rect,
                                         const std::vector<float>& picture) const {
  std::vector<float> out(static_cast<std::size_t>(rect.width()) *
                         static_cast<std::size_t>(rect.height()));
  const std::vector<BlurLevel>& levels = settings_.levels.levels();
  std::vector<ScreenPoint> at;
  BlurLevels::Place place{};
  const float* smooth = picture.data();
  float* to = out.data();
  for (int y = rect.y0; y < rect.y1; ++y) {
    silver_at.row(y, at);
    for (int x = 0; x < rect.width(); ++x, smooth += kPixelFloats) {
      const ScreenPoint s = at[static_cast<std::size_t>(x)];
      if (levels.size() > 1 && x % kSigmaStep == 0) {
        place = settings_.levels.place(
            settings_.blur.sigma_px({static_cast<double>(rect.x0 + x), static_cast<double>(y)}));
      }
      std::array<float, 3> share = levels[place.index].cell.shares(s.u, s.v);
      if (place.toward_next > 0) {
        const auto next = levels[place.index + 1].cell.shares(s.u, s.v);
        for (std::size_t c = 0; c < 3; ++c) share[c] += place.toward_next * (next[c] - share[c]);
      }
      *to++ = share[0] * smooth[0] + share[1] * smooth[1] + share[2] * smooth[2];
    }
  }
  return out;
}

void TileRenderer::multiply_by_ratio(const SilverRows& silver, const BlankBlocks& blank,
                                     const PixelBounds& rect, const std::vector<float>& predicted,
                                     std::vector<float>& picture) const {
  const SilverRatio ratio(silver, predicted, rect.grown(detail_reach_px_), settings_.noise_sd);
  const Vec2 shift = settings_.silver_shift_px;
  const Vec2 whole{std::floor(shift.x), std::floor(shift.y)};
  const auto part_x = static_cast<float>(shift.x - whole.x),
             part_y = static_cast<float>(shift.y - whole.y);
  const int dx = static_cast<int>(whole.x), dy = static_cast<int>(whole.y);
  float* out = picture.data();
  for (int y = rect.y0; y < rect.y1; ++y) {
    for_runs(blank, rect.x0, y, rect.width(), detail_reach_px_, [&](int begin, int end, bool skip) {
      if (skip) return;
      for (int x = begin; x < end; ++x) {
        const float factor = ratio.at(rect.x0 + x + dx, y + dy, part_x, part_y);
        float* to =
            out + static_cast<std::ptrdiff_t>(x) * static_cast<std::ptrdiff_t>(kPixelFloats);
        for (std::size_t c = 0; c < 3; ++c) to[c] *= factor;
      }
    });
    out += static_cast<std::ptrdiff_t>(rect.width()) * static_cast<std::ptrdiff_t>(kPixelFloats);
  }
}

// What the smooth picture would give is taken off the silver; the rest is detail.
void TileRenderer::add_detail(const SilverRows& silver, const BlankBlocks& blank,
                              const MapGrid& silver_at, const PixelBounds& rect,
                              const std::vector<float>& predicted,
                              std::vector<float>& picture) const {
  const PixelBounds wide = rect.grown(DetailKernels::kRadius);
  const auto stride = static_cast<std::ptrdiff_t>(wide.width()) + 1;
  std::vector<float> rest(
      static_cast<std::size_t>(stride) * static_cast<std::size_t>(wide.height()) + 4);
  const std::vector<BlurLevel>& levels = settings_.levels.levels();
  std::vector<ScreenPoint> at;
  BlurLevels::Place place{};
  const float* smooth = predicted.data();
  for (int y = wide.y0; y < wide.y1; ++y) {
    const float* from = silver.at(wide.x0, y);
    float* to = &rest[static_cast<std::size_t>((y - wide.y0) * stride)];
    for (int x = 0; x < wide.width(); ++x) to[x] = from[x] - *smooth++;
  }
  float* out = picture.data();
  for (int y = rect.y0; y < rect.y1; ++y) {
    silver_at.row(y, at);
    const float* corner =
        &rest[static_cast<std::size_t>((y - wide.y0 - DetailKernels::kRadius) * stride)];
    const ScreenPoint* const point = at.data() + DetailKernels::kRadius;
    for_runs(blank, rect.x0, y, rect.width(), DetailKernels::kRadius,
             [&](int begin, int end, bool skip) {
               if (skip) return;
               for (int x = begin; x < end; ++x) {
                 const ScreenPoint s = point[x];
                 if (levels.size() > 1 && (x % kSigmaStep == 0 || x == begin)) {
                   const int step_x = rect.x0 + x - x % kSigmaStep;
                   place = settings_.levels.place(settings_.blur.sigma_px(
                       {static_cast<double>(step_x), static_cast<double>(y)}));
                 }
                 const BlurLevel& level = levels[place.index + (place.toward_next > 0.5F ? 1 : 0)];
                 const float* weight = level.detail->of(s.u, s.v);
                 const float* from = corner + x;
                 std::array<Float4, 3> a{}, b{};
                 for (int row = 0; row < DetailKernels::kSide; ++row) {
                   const Float4 p0 = load4(from), p1 = load4(from + 4), p2 = load4(from + 8),
                                p3 = load4(from + 12);
                   for (std::size_t c = 0; c < 3; ++c) {
                     a[c] += load4(weight) * p0;
                     b[c] += load4(weight + 4) * p1;
                     a[c] += load4(weight + 8) * p2;
                     b[c] += load4(weight + 12) * p3;
                     weight += DetailKernels::kRow;
                   }
                   from += stride;
                 }
                 float* to = out + static_cast<std::ptrdiff_t>(x) *
                                       static_cast<std::ptrdiff_t>(kPixelFloats);
                 for (std::size_t c = 0; c < 3; ++c) to[c] += sum4(a[c] + b[c]);
               }
             });
    out += static_cast<std::ptrdiff_t>(rect.width()) * static_cast<std::ptrdiff_t>(kPixelFloats);
  }
}

}  // namespace reseau
