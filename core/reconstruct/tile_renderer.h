// One tile of the reconstruction: elements from the silver, the picture between them, its detail.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blank_blocks.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/demosaic.h"
#include "core/reconstruct/map_grid.h"
#include "core/reconstruct/sharpness_field.h"
#include "core/reconstruct/silver_rows.h"
#include "core/screen/screen_map.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

struct TileSettings {
  const ScreenMap& map;
  const ScreenPattern& pattern;
  const BlurLevels& levels;
  const BlurSurface& blur;  // of the silver, by place; asked when levels are several
  Vec2 silver_shift_px;     // the silver of what lies at p is at p + shift
  Demosaic demosaic = Demosaic::kBicubic;
  double noise_sd = 0;  // of a pixel's silver over the light there
  std::array<float, 9> output_from_process{};
  double blank_noise_sd = 0;  // as BlankBlocks; 0: nothing is skipped
};

// Immutable, thread-safe.
class TileRenderer {
 public:
  explicit TileRenderer(const TileSettings& settings);

  // How far around a tile the silver must be known.
  [[nodiscard]] int reach_px() const { return element_reach_px_ + ElementKernels::kRadius + 2; }
  // Whether a picture has more in it than what lies between elements.
  [[nodiscard]] bool has_detail() const { return detail_reach_px_ > 0; }
  // Writes the pixels of the rectangle, [row][pixel][3], `row_stride` floats from row to row.
  // Returns how many of them were not made because the place is blank. `step`: of every so many
  // pixels and rows from the rectangle's corner on only the first; 1 where there is detail.
  std::size_t render(const SilverRows& silver, const PixelBounds& rect, float* out,
                     std::ptrdiff_t row_stride, int step = 1) const;

 private:
  static constexpr std::size_t kPixelFloats = 4;  // R G B and one unused, while a tile is at work

  // The elements of one colour about a tile.
  struct Plane {
    int first_i = 0, first_j = 0, n_i = 0, n_j = 0;
    std::vector<float> values;
  };
  using Planes = std::array<Plane, 3>;

  [[nodiscard]] Planes collect(const SilverRows& silver, const BlankBlocks& blank,
                               const PixelBounds& rect, Vec2 origin, Vec2 lowest,
                               Vec2 highest) const;
  [[nodiscard]] float element(const SilverRows& silver, std::size_t site, Vec2 p) const;
  // `at`: the points of row y from column x0 on.
  void interpolate(const Planes& planes, const BlankBlocks& blank, int x0, int y,
                   const std::vector<ScreenPoint>& at, float* out) const;
  // The silver that a picture, [pixel][4] of the rectangle, would have.
  [[nodiscard]] std::vector<float> predict(const MapGrid& silver_at, const PixelBounds& rect,
                                           const std::vector<float>& picture) const;
  // `predicted`: the silver of the picture, in the rectangle and detail_reach_px_ around it.
  void add_detail(const SilverRows& silver, const BlankBlocks& blank, const MapGrid& silver_at,
                  const PixelBounds& rect, const std::vector<float>& predicted,
                  std::vector<float>& picture) const;
  void multiply_by_ratio(const SilverRows& silver, const BlankBlocks& blank,
                         const PixelBounds& rect, const std::vector<float>& predicted,
                         std::vector<float>& picture) const;

  TileSettings settings_;
  int detail_reach_px_;  // around a pixel, of silver that detail is made from
  int element_reach_px_;
};

}  // namespace reseau
