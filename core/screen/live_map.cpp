#include "core/screen/live_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/parallel.h"
#include "core/screen/follow_screen.h"
#include "core/screen/map_fit.h"
#include "core/screen/spline_surface.h"

namespace reseau {
namespace {

// A plane that leaves no more is good enough for a map that lives for a block of lines [px].
constexpr double kLivePlanePx = 0.03;
// Nodes of the displacement: what a fit takes must not grow with the frame.
constexpr double kFinestLivePx = 96, kMostLiveNodes = 900;
constexpr double kLiveStiffness = 0.1;

}  // namespace

BlockShape block_of_four_periods(const CellGrid& cells, const Carriers& carriers) {
  const double period = std::max(1 / norm(carriers.u), 1 / norm(carriers.v));
  const int side_px =
      cells.size().width < 16 ? 16 : 32 * static_cast<int>(std::ceil(4 * period / 33));
  return {std::max(2, side_px / cells.size().width / 2 * 2),
          std::max(1, side_px / cells.size().lines), 0};
}

LiveMap::LiveMap(int width_px, int height_px, const LatticeSeed& seed)
    : cells_(width_px, height_px, seed.carriers, CellSize{},
             keep_every_for(width_px, height_px, false)),
      shape_(block_of_four_periods(cells_, seed.carriers)),
      grower_(cells_,
              series_from_response(seed.response, seed.layout, seed.special_color, seed.carriers,
                                   seed.sigma_px),
              shape_),
      seed_(seed) {}

void LiveMap::advance(int n_lines) {
  const int block_lines = shape_.rows * cells_.size().lines;
  const int rows = n_lines == cells_.height_px() ? grower_.n_block_rows() : n_lines / block_lines;
  if (rows <= end_row_) return;
  if (end_row_ == 0) grower_.start(seed_);
  end_row_ = rows;
  grower_.grow(rows);
  fit(std::min(n_lines, rows * block_lines));
}

void LiveMap::fit(int n_lines) {
  const std::vector<PhaseSample> samples = grower_.samples();
  n_samples_ = static_cast<int>(samples.size());
  const int width = cells_.width_px(), height = cells_.height_px();
  constexpr double kPlaneOnly = 1e9;
  const MapFit plane = fit_map(samples, width, n_lines, kFinestLivePx, kPlaneOnly);
  if (!plane.usable) return;
  n_lines_ = n_lines;
  map_ = plane.map;
  residual_px_ = plane.residual_px;
  if (residual_px_ <= kLivePlanePx) return;
  std::array<ScatteredValues, 2> off;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Vec2 d = samples[s].s_in_screen - map_.screen_from_scan(samples[s].p_in_scan);
    for (const bool u : {true, false}) {
      ScatteredValues& values = off[u ? 0 : 1];
      values.positions.push_back(samples[s].p_in_scan);
      values.values.push_back(u ? d.x : d.y);
      values.weights.push_back(u ? plane.placed[s].info_u : plane.placed[s].info_v);
    }
  }
  SurfaceLevels levels = surface_levels(
      width, height, std::max(kFinestLivePx, std::sqrt(double(width) * height / kMostLiveNodes)));
  std::ranges::fill(levels.stiffness, kLiveStiffness);
  std::array<SplineSurface, 2> surface;
  parallel_for(2, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    surface[at] = fit_surface(off[at], width, height, levels);
  });
  std::vector<Vec2> coefficients;
  coefficients.reserve(surface[0].coefficients.size());
  for (std::size_t i = 0; i < surface[0].coefficients.size(); ++i)
    coefficients.push_back({surface[0].coefficients[i], surface[1].coefficients[i]});
  map_ = ScreenMap(plane.map.linear(), plane.map.offset(), surface[0].spacing_px,
                   surface[0].n_columns, surface[0].n_rows, std::move(coefficients));
  const Mat2 px_from_screen = plane.map.linear().inverse();
  double sum = 0, total = 0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const Vec2 px =
        px_from_screen * (samples[s].s_in_screen - map_.screen_from_scan(samples[s].p_in_scan));
    const double weight = std::min(plane.placed[s].info_u, plane.placed[s].info_v);
    sum += weight * dot(px, px);
    total += weight;
  }
  residual_px_ = total > 0 ? std::sqrt(sum / total) : 0;
}

}  // namespace reseau
