#include "calibration/random/place_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

namespace reseau::random_target {
namespace {

constexpr int kSearchSkip = 2;  // of the patch's pixels
constexpr double kTurnStepDeg = 2;
constexpr int kTurns = 3;  // to either side

// The target under the first Gaussian, on a grid of a whole number of steps per cell.
struct BlurredMap {
  int n = 0;
  double step_px = 0, corner_px = 0;
  std::vector<float> light;  // mean 0

  BlurredMap(const RandomCells& cells, double sigma_px) {
    const int per_cell = static_cast<int>(std::ceil(cells.cell_px() / 0.5 - 1e-9));
    n = cells.n_cells() * per_cell;
    step_px = cells.cell_px() / per_cell;
    corner_px = cells.border_px(0);
    const auto side = static_cast<std::size_t>(n);
    std::vector<float> sharp(side * side);
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        sharp[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)] =
            cells.clear(x / per_cell, y / per_cell) ? 0.5F : -0.5F;
      }
    }
    const int reach = static_cast<int>(std::ceil(3.5 * sigma_px / step_px));
    std::vector<float> weight;
    float sum = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double z = k * step_px / sigma_px;
      weight.push_back(static_cast<float>(std::exp(-z * z / 2)));
      sum += weight.back();
    }
    for (float& w : weight) w /= sum;
    light.assign(side * side, 0.0F);
    std::vector<float> row(side);
    for (int y = 0; y < n; ++y) {
      std::ranges::fill(row, 0.0F);
      for (std::size_t k = 0; k < weight.size(); ++k) {
        const int from = std::clamp(y + static_cast<int>(k) - reach, 0, n - 1);
        const float* const p = sharp.data() + static_cast<std::size_t>(from) * side;
        const float w = weight[k];
        for (std::size_t x = 0; x < side; ++x) row[x] += w * p[x];
      }
      float* const to = light.data() + static_cast<std::size_t>(y) * side;
      for (int x = 0; x < n; ++x) {
        float s = 0;
        for (std::size_t k = 0; k < weight.size(); ++k) {
          const int from = std::clamp(x + static_cast<int>(k) - reach, 0, n - 1);
          s += weight[k] * row[static_cast<std::size_t>(from)];
        }
        to[x] = s;
      }
    }
  }
};

// The patch in the middle, laid in one way: its values, mean 0, and where they lie in the map. A
// quarter of them, spread over the patch, come first.
struct Patch {
  std::vector<float> value;
  std::vector<std::int64_t> offset;
  std::size_t first = 0;
  float squares = 0;
};

Patch patch_of(const UsedPart& part, const BlurredMap& map, const Mat2& turn) {
  const Vec2 middle = part.middle();
  const int cx = static_cast<int>(middle.x), cy = static_cast<int>(middle.y);
  Patch out;
  double sum = 0;
  for (const bool in_first : {true, false}) {
    for (int y = -kSearchSide_px / 2; y < kSearchSide_px / 2; y += kSearchSkip) {
      for (int x = -kSearchSide_px / 2; x < kSearchSide_px / 2; x += kSearchSkip) {
        const bool even = (x / kSearchSkip) % 2 == 0 && (y / kSearchSkip) % 2 == 0;
        const float v = part.samples(cx + x, cy + y);
        if (even != in_first || !std::isfinite(v)) continue;
        const Vec2 at = turn * Vec2{cx + x - middle.x, cy + y - middle.y};
        out.value.push_back(v);
        out.offset.push_back(std::llround(at.y / map.step_px) * map.n +
                             std::llround(at.x / map.step_px));
        sum += static_cast<double>(v);
      }
    }
    if (in_first) out.first = out.value.size();
  }
  const auto mean = static_cast<float>(sum / std::max(1.0, static_cast<double>(out.value.size())));
  for (float& v : out.value) {
    v -= mean;
    out.squares += v * v;
  }
  return out;
}

// How much the map at `p` looks like the first n values of the patch.
double likeness_of(const Patch& patch, const float* p, std::size_t n) {
  float both = 0, light = 0, light2 = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const float l = p[patch.offset[k]];
    both += patch.value[k] * l;
    light += l;
    light2 += l * l;
  }
  const auto count = static_cast<float>(n);
  const float share = patch.squares * count / static_cast<float>(patch.value.size());
  const float spread = light2 - light * light / count;
  return static_cast<double>(both / std::sqrt(std::max(spread * share, 1e-20F)));
}

// The best place of the patch in the middle, laid in this way, over the whole target.
void search_map(const UsedPart& part, const BlurredMap& map, const Mat2& turn, LikelyPlace& best) {
  constexpr double kWorthAll = 0.25;  // of the first quarter
  const Patch patch = patch_of(part, map, turn);
  if (patch.first < 32 || !(patch.squares > 0)) return;
  const int margin = static_cast<int>(std::ceil(0.75 * kSearchSide_px / map.step_px));
  const int skip = std::max(1, static_cast<int>(std::lround(1 / map.step_px)));
  for (int y = margin; y < map.n - margin; y += skip) {
    for (int x = margin; x < map.n - margin; x += skip) {
      const float* const p = map.light.data() + static_cast<std::int64_t>(y) * map.n + x;
      if (likeness_of(patch, p, patch.first) < kWorthAll) continue;
      const double likeness = likeness_of(patch, p, patch.value.size());
      if (likeness <= best.likeness) continue;
      best = {likeness,
              {map.corner_px + (x + 0.5) * map.step_px, map.corner_px + (y + 0.5) * map.step_px},
              turn};
    }
  }
}

std::vector<Mat2> turns_of(const Mat2& way) {
  std::vector<Mat2> out;
  for (int k = -kTurns; k <= kTurns; ++k) {
    const double a = k * kTurnStepDeg * std::numbers::pi / 180;
    out.push_back(Mat2{std::cos(a), -std::sin(a), std::sin(a), std::cos(a)} * way);
  }
  return out;
}

}  // namespace

LikelyPlace search_target(const UsedPart& part, const RandomCells& cells, double sigma_px) {
  const BlurredMap map(cells, sigma_px);
  // As it should lie first; then turned by quarters and from behind.
  LikelyPlace best;
  constexpr double kSure = 0.7;
  const Mat2 quarter{0, -1, 1, 0}, behind{-1, 0, 0, 1};
  for (const Mat2& side : {Mat2{}, behind}) {
    Mat2 way = side;
    for (int k = 0; k < 4 && best.likeness < kSure; ++k, way = quarter * way) {
      for (const Mat2& turn : turns_of(way)) search_map(part, map, turn, best);
    }
  }
  return best;
}

}  // namespace reseau::random_target
