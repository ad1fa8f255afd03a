#include "core/screen/light_drift.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/parallel.h"

namespace reseau {
namespace {

// Dyes that hardly differ tell nothing of colours: then all elements have the light of the whole.
constexpr double kGrey = 0.05;
// Least s^2 behind elements of one colour, of the whole: less is within the error of the unmixing.
constexpr double kLeastShare = 0.1;
// Beyond such a step from cell to cell it is an edge, which no slope describes.
constexpr double kMostStep = 8;

}  // namespace

LightDrift::LightDrift(const CellGrid& cells, const LatticeSeed& seed)
    : cells_(cells),
      layout_(seed.layout),
      grey_(seed.grey),
      colors_(site_colors(seed.layout, seed.special_color)),
      lights_(static_cast<std::size_t>(cells.n_columns()) *
              static_cast<std::size_t>(cells.n_rows())) {
  const SiteSeries& sites = site_series(layout_);
  Eigen::Vector3d area;
  for (std::size_t k = 0; k < 3; ++k) area(colors_[k]) = sites[k][0];
  // sum S X_c = sum over elements k of response(k, c) area(k) s(k)^2, where masks are sharp.
  Eigen::Matrix3d mix;
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 3; ++c)
      mix(c, k) = seed.response[static_cast<std::size_t>(k)][static_cast<std::size_t>(c)] * area(k);
  }
  const double ridge = kGrey * mix.squaredNorm() / 3;
  const Eigen::Matrix3d normal = mix.transpose() * mix + ridge * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d unmix = normal.inverse() * mix.transpose();
  // Neutral light where nothing else is known: s^2 = N(0) behind every element.
  const Eigen::Vector3d neutral = normal.inverse() * (ridge * Eigen::Vector3d::Ones());
  parallel_for(cells.n_rows(), [&](int r) {
    for (int c = 0; c < cells.n_columns(); ++c) {
      const CellSize size = cells.size();
      const double filled = cells.filled(c, r) *
                            std::min(1.0, static_cast<double>(cells.width_px()) / size.width - c) *
                            std::min(1.0, static_cast<double>(cells.height_px()) / size.lines - r);
      if (!(cells.light(c, r) > 0 && filled > 0)) continue;
      // As if the cell were whole: one that the border of the frame cuts is not darker for it.
      const double whole = cells.light(c, r) / filled;
      const std::array<double, 3> seen = cells.color_light(c, r);
      const Eigen::Vector3d s2 =
          (1 / filled) * (unmix * Eigen::Vector3d(seen[0], seen[1], seen[2])) + whole * neutral;
      Lights& out =
          lights_[static_cast<std::size_t>(r) * static_cast<std::size_t>(cells.n_columns()) +
                  static_cast<std::size_t>(c)];
      for (std::size_t k = 0; k < 3; ++k) {
        out[k] =
            static_cast<float>(std::max(s2(static_cast<Eigen::Index>(k)), kLeastShare * whole));
      }
    }
  });
}

// Light on the border that a cell has in the direction of a step: between that of the cells on
// either side, which hold whole periods or nearly so, or what the cells on this side tend to.
double LightDrift::beside(int column, int row, int step_x, int step_y, std::size_t color) const {
  const auto light = [&](int c, int r) {
    const bool inside = c >= 0 && r >= 0 && c < cells_.n_columns() && r < cells_.n_rows();
    return inside ? static_cast<double>(at(c, r)[color]) : 0.0;
  };
  const double here = light(column, row);
  const double there = light(column + step_x, row + step_y);
  const double back = light(column - step_x, row - step_y);
  const double ratio = there > 0 ? there / here : back > 0 ? here / back : 1.0;
  return here * std::sqrt(std::clamp(ratio, 1 / kMostStep, kMostStep));
}

LightDrift::Slopes LightDrift::of_block(const CellRange& range) const {
  // A period of lines alone is wider than a cell; there the light of a cell is that of a line.
  // And grey rows do not tell the lights of elements.
  if (layout_ == ScreenLayout::kLines || grey_) return {};
  // Of s^2, colour by colour: the sum over the block, and what it gains from border to border.
  std::array<double, 3> sum{};
  std::array<Vec2, 3> gain{};
  for (int r = range.row0; r < range.row1; ++r) {
    for (int c = range.column0; c < range.column1; ++c) {
      if (!(at(c, r)[0] > 0)) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        sum[k] += static_cast<double>(at(c, r)[k]);
        gain[k] =
            gain[k] + Vec2{(beside(c, r, 1, 0, k) - beside(c, r, -1, 0, k)) / cells_.size().width,
                           (beside(c, r, 0, 1, k) - beside(c, r, 0, -1, k)) / cells_.size().lines};
      }
    }
  }
  std::array<Vec2, 3> site;    // slope of ln s
  std::array<double, 3> size;  // s
  for (std::size_t k = 0; k < 3; ++k) {
    const auto color = static_cast<std::size_t>(colors_[k]);
    if (!(sum[color] > 0)) return {};
    site[k] = (0.5 / sum[color]) * gain[color];
    size[k] = std::sqrt(sum[color]);
  }
  if (layout_ == ScreenLayout::kTwoSites) {
    const Vec2 both = 0.25 * (site[0] + site[1]) + 0.5 * site[2];
    return {both, both};
  }
  // The squares meet one another along u, and both meet the line along v, where the brighter square
  // shows the border better.
  const Vec2 squares = (1 / (size[1] + size[2])) * (size[1] * site[1] + size[2] * site[2]);
  return {0.5 * (site[1] + site[2]), 0.5 * (site[0] + squares)};
}

}  // namespace reseau
