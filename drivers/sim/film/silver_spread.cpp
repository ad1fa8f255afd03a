// The spread of light in the emulsion and of the silver.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/film/silver_layer.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

// Weights of the cells from -reach to reach, of this variance [cells^2].
std::vector<float> gauss_weights(double variance, double reach_sigmas) {
  // Samples of a narrow Gaussian have another variance, three weights have this one; what is less
  // than nothing sharpens.
  constexpr double kNarrow = 0.5;
  if (variance < kNarrow) {
    const auto side = static_cast<float>(variance / 2);
    return {side, 1 - 2 * side, side};
  }
  const auto reach = std::llround(std::ceil(reach_sigmas * std::sqrt(variance)));
  std::vector<double> weights(2 * static_cast<std::size_t>(reach) + 1);
  double sum = 0, of_gauss = variance;
  // What the ends cut off is made up for.
  for (int turn = 0; turn < 3; ++turn) {
    double squares = 0;
    sum = 0;
    for (auto j = -reach; j <= reach; ++j) {
      const auto square = static_cast<double>(j * j);
      const double w = std::exp(-0.5 * square / of_gauss);
      weights[static_cast<std::size_t>(j + reach)] = w;
      sum += w;
      squares += w * square;
    }
    of_gauss *= variance * sum / squares;
  }
  std::vector<float> result;
  result.reserve(weights.size());
  for (const double w : weights) result.push_back(static_cast<float>(w / sum));
  return result;
}

using Eight = float __attribute__((vector_size(32)));

// Rows times weights; sums stay in registers over all rows.
void weighted_sum(const std::vector<const float*>& rows, const std::vector<float>& weights,
                  std::vector<float>& out) {
  constexpr std::size_t kRun = 32;
  const std::size_t n = out.size(), n_rows = rows.size();
  float* const to = out.data();
  for (std::size_t i = 0; i < n && n < kRun; ++i) {
    float sum = 0;
    for (std::size_t k = 0; k < n_rows; ++k) sum += weights[k] * rows[k][i];
    to[i] = sum;
  }
  if (n < kRun) return;
  widest([&]() RESEAU_SIM_INLINE {
    for (std::size_t begin = 0; begin < n; begin += kRun) {
      const std::size_t at = std::min(begin, n - kRun);
      Eight sum[kRun / 8] = {};
      for (std::size_t k = 0; k < n_rows; ++k) {
        const float w = weights[k];
        const Eight same{w, w, w, w, w, w, w, w};
        const float* const from = rows[k] + at;
        for (std::size_t i = 0; i < kRun / 8; ++i) {
          Eight v;
          std::memcpy(&v, from + 8 * i, sizeof v);
          sum[i] += same * v;
        }
      }
      std::memcpy(to + at, sum, sizeof sum);
    }
  });
}

// Mean over a cell of what is above 0 of a plane, from its mean and its steps from cell to cell.
float mean_above(float mean, float step_x, float step_y, bool tents) {
  const double x = std::abs(step_x), y = std::abs(step_y);
  // The weight across the plane's direction: two boxes as EdgeRamp has them, convolved.
  const double wide = tents ? std::hypot(x, y) : std::max(x, y);
  const double narrow = tents ? wide : std::max(std::min(x, y), 0.01 * wide);
  const double outer = (wide + narrow) / 2, inner = (wide - narrow) / 2;
  const auto d = static_cast<double>(mean);
  if (std::abs(d) >= outer) return std::max(mean, 0.0F);
  const auto cube = [](double t) { return t > 0 ? t * t * t : 0.0; };
  return static_cast<float>((cube(d + outer) - cube(d + inner) - cube(d - inner)) /
                            (6 * wide * narrow));
}

}  // namespace

// Rows of a stage, blurred along x, of the cells just behind and ahead.
struct SilverLayer::Ring {
  std::uint64_t id = 0;
  CellRange cells;
  std::vector<std::int64_t> row_in_slot;
  std::vector<std::vector<float>> slots;
  std::vector<float> source, weights;
  std::vector<const float*> inputs;

  void prepare(std::uint64_t layer, const CellRange& of_cells, double variance) {
    if (id == layer && cells == of_cells) return;
    id = layer;
    cells = of_cells;
    weights = gauss_weights(variance, kReach);
    row_in_slot.assign(weights.size() + 1, INT64_MIN);
    slots.assign(weights.size() + 1, {});
  }
};

// The silver at the middles of cells, of rows around the latest.
struct SilverLayer::Points {
  std::uint64_t id = 0;
  CellRange cells;
  std::array<std::int64_t, 4> row_in_slot{};
  std::array<std::vector<float>, 4> slots;
};

void SilverLayer::silver_row(double y, const CellRange& cells, std::vector<float>& out) const {
  if (light_px_ == 0) {
    exposure_row(y, cells, out);
    return;
  }
  const bool identity = strip_.hd_curve().is_identity();
  if (cells.per_px == 1) {
    blurred(Stage::kExposure, light_px_, y, cells, out);
    strip_.hd_curve().apply(out);
    for (float& t : out) t = std::min(t, 1.0F);
    return;
  }
  thread_local Points points;
  if (points.id != id_ || points.cells != cells) {
    points.id = id_;
    points.cells = cells;
    points.row_in_slot.fill(INT64_MIN);
  }
  const std::int64_t middle = std::llround((y + 0.5) * cells.per_px - 0.5);
  std::array<const float*, 3> rows{};
  for (std::int64_t k = -1; k <= 1; ++k) {
    const std::int64_t row = middle + k;
    const auto slot = static_cast<std::size_t>(row & 3);
    if (points.row_in_slot[slot] != row) {
      points.row_in_slot[slot] = row;
      const double at = (static_cast<double>(row) + 0.5) / cells.per_px - 0.5;
      blurred(Stage::kExposure, light_px_, at, cells, points.slots[slot]);
      strip_.hd_curve().apply(points.slots[slot]);
    }
    rows[static_cast<std::size_t>(k + 1)] = points.slots[slot].data();
  }
  const auto [above, here, below] = rows;
  const std::size_t n = cells.size();
  const float bend = variance_of(cells) / 2;
  out.assign(here, here + n);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    out[i] += bend * ((above[i] + below[i]) + (here[i - 1] + here[i + 1]) - 4 * here[i]);
  }
  // More light than white needs cannot make the film clearer than clear.
  for (std::size_t i = 1; identity && i + 1 < n; ++i) {
    const float step_x = (here[i + 1] - here[i - 1]) / 2, step_y = (below[i] - above[i]) / 2;
    if (out[i] + std::abs(step_x) + std::abs(step_y) < 1) continue;
    out[i] -= mean_above(out[i] - 1, step_x, step_y, cells.tents);
  }
}

void SilverLayer::blurred(Stage stage, double sigma_px, double y, const CellRange& cells,
                          std::vector<float>& out) const {
  // From the means of exposures to points.
  const bool to_points = cells.per_px > 1 && stage == Stage::kExposure;
  const double sigma = sigma_px * cells.per_px;
  const double variance =
      sigma * sigma - (to_points ? static_cast<double>(variance_of(cells)) : 0.0);
  thread_local std::array<Ring, 2> rings;
  Ring& ring = rings[stage == Stage::kExposure ? 0 : 1];
  ring.prepare(id_, cells, variance);
  const auto reach = static_cast<std::int64_t>(ring.weights.size() / 2);
  const auto n_slots = static_cast<std::int64_t>(ring.slots.size());
  const int margin_px = static_cast<int>(reach) / cells.per_px + 1;
  const auto margin = static_cast<std::ptrdiff_t>(margin_px) * cells.per_px;
  const CellRange wider{cells.first_px - margin_px, cells.n_px + 2 * margin_px, cells.per_px,
                        cells.tents};
  const std::size_t n = cells.size();
  // Row j of the grid is centred at y = (j + 0.5) / per_px - 0.5.
  const std::int64_t middle = std::llround((y + 0.5) * cells.per_px - 0.5);
  out.assign(n, 0.0F);
  for (std::int64_t k = -reach; k <= reach; ++k) {
    const std::int64_t j = middle + k;
    const auto slot = static_cast<std::size_t>((j % n_slots + n_slots) % n_slots);
    if (ring.row_in_slot[slot] != j) {
      const double row_y = (static_cast<double>(j) + 0.5) / cells.per_px - 0.5;
      if (stage == Stage::kExposure) {
        exposure_row(row_y, wider, ring.source);
      } else {
        silver_row(row_y, wider, ring.source);
      }
      std::vector<float>& row = ring.slots[slot];
      row.assign(n, 0.0F);
      ring.inputs.clear();
      for (std::ptrdiff_t t = -reach; t <= reach; ++t) {
        ring.inputs.push_back(ring.source.data() + margin + t);
      }
      weighted_sum(ring.inputs, ring.weights, row);
      ring.row_in_slot[slot] = j;
    }
  }
  ring.inputs.clear();
  for (std::int64_t k = -reach; k <= reach; ++k) {
    const std::int64_t j = middle + k;
    ring.inputs.push_back(
        ring.slots[static_cast<std::size_t>((j % n_slots + n_slots) % n_slots)].data());
  }
  weighted_sum(ring.inputs, ring.weights, out);
}

void SilverLayer::field(double y, const CellRange& cells, PlaneRow& out) const {
  thread_local std::vector<float> row;
  if (silver_px_ > 0) {
    blurred(Stage::kSilver, silver_px_, y, cells, row);
  } else {
    silver_row(y, cells, row);
  }
  out.resize(cells.first_px, cells.n_px, cells.per_px, 1);
  for (int s = 0; s < cells.per_px; ++s) {
    float* to = out.phase(0, s);
    const float* from = row.data() + s;
    for (int i = 0; i < cells.n_px; ++i) to[i] = from[i * cells.per_px];
  }
}

}  // namespace reseau::sim
