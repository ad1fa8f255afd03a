#include "core/screen/spline_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/screen/level_system.h"

namespace reseau {
namespace {

SplineSurface make_grid(double spacing, int width, int height) {
  SplineSurface grid;
  grid.spacing_px = spacing;
  grid.n_columns = std::max(4, static_cast<int>(std::ceil(width / spacing)) + 3);
  grid.n_rows = std::max(4, static_cast<int>(std::ceil(height / spacing)) + 3);
  grid.coefficients.assign(
      static_cast<std::size_t>(grid.n_columns) * static_cast<std::size_t>(grid.n_rows), 0);
  return grid;
}

// Exact: every cubic spline is one of half the spacing; coefficients spread as 1 4 6 4 1 over 8.
SplineSurface refined(const SplineSurface& coarse, int width, int height) {
  SplineSurface fine = make_grid(coarse.spacing_px / 2, width, height);
  const auto value = [&](int i, int j) {
    return coarse.coefficients[static_cast<std::size_t>(std::clamp(j, 0, coarse.n_rows - 1)) *
                                   static_cast<std::size_t>(coarse.n_columns) +
                               static_cast<std::size_t>(std::clamp(i, 0, coarse.n_columns - 1))];
  };
  struct Mask {
    std::array<double, 3> weight;
    int first;
  };
  // Coefficient i sits at (i - 1) h: fine index f lies on coarse (f + 1) / 2, or between two.
  const auto mask = [](int f) -> Mask {
    if (f % 2 == 1) return {{0.125, 0.75, 0.125}, (f + 1) / 2 - 1};
    return {{0.5, 0.5, 0}, f / 2};
  };
  for (int j = 0; j < fine.n_rows; ++j) {
    const Mask my = mask(j);
    for (int i = 0; i < fine.n_columns; ++i) {
      const Mask mx = mask(i);
      double sum = 0;
      for (int b = 0; b < 3; ++b) {
        for (int a = 0; a < 3; ++a) {
          const double w =
              mx.weight[static_cast<std::size_t>(a)] * my.weight[static_cast<std::size_t>(b)];
          if (w != 0) sum += w * value(mx.first + a, my.first + b);
        }
      }
      fine.coefficients[static_cast<std::size_t>(j) * static_cast<std::size_t>(fine.n_columns) +
                        static_cast<std::size_t>(i)] = sum;
    }
  }
  return fine;
}

// Of the square of what conjugate gradients leave: a trial only has to be judged.
constexpr double kTolerance = 1e-10, kTrialTolerance = 1e-7;
constexpr int kMostIterations = 250, kTrialIterations = 80;

constexpr std::array<int, 2> kFolds{0, 2};
// A level is added where left-out samples gain so much [nats each], and more than the sum of their
// gains scatters.
constexpr double kLeastLevelGain = 0.04, kLevelScatter = 0.7;

double middle_of(std::vector<double> values) {
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

double SplineSurface::at(Vec2 p) const { return value_at(*this, basis_at(*this, p)); }

double left_out_block_px(double finest_px) { return finest_px < 40 ? 1.8 * finest_px : 110; }

bool left_out_of_fold(Vec2 p, int fold, double block_px) {
  const int i = static_cast<int>(std::floor(p.x / block_px)),
            j = static_cast<int>(std::floor(p.y / block_px));
  return (((i + 2 * j) % 5) + 5) % 5 == fold;
}

bool SurfaceLevels::flat() const {
  return std::all_of(stiffness.begin(), stiffness.end(), [](double s) { return s < 0; });
}

SurfaceLevels surface_levels(int width_px, int height_px, double finest_px) {
  SurfaceLevels levels;
  double spacing = finest_px;
  std::vector<double> fine_first;
  while (true) {
    fine_first.push_back(spacing);
    if (spacing >= 0.5 * std::max(width_px, height_px)) break;
    spacing *= 2;
  }
  levels.spacing_px.assign(fine_first.rbegin(), fine_first.rend());
  levels.stiffness.assign(levels.spacing_px.size(), -1.0);
  return levels;
}

void choose_levels(const std::vector<const ScatteredValues*>& coordinates, int width_px,
                   int height_px, SurfaceLevels& levels) {
  // residual[coordinate][fold]: of all samples under the fit without that fold's blocks.
  struct Task {
    const ScatteredValues* samples;
    int fold;
    std::vector<double> residual, weights;
  };
  std::vector<Task> tasks;
  const double block_px = left_out_block_px(levels.spacing_px.back());
  for (const ScatteredValues* samples : coordinates) {
    for (const int fold : kFolds) {
      Task task{samples, fold, samples->values, samples->weights};
      for (std::size_t s = 0; s < task.weights.size(); ++s) {
        if (left_out_of_fold(samples->positions[s], fold, block_px)) task.weights[s] = 0;
      }
      tasks.push_back(std::move(task));
    }
  }
  // Normalised sizes of the residuals that the fit has not seen.
  const auto left_out = [](const Task& task, const std::vector<double>& residual) {
    std::vector<double> sizes;
    for (std::size_t s = 0; s < residual.size(); ++s) {
      const double w = task.samples->weights[s];
      if (w > 0 && task.weights[s] == 0) sizes.push_back(std::abs(residual[s]) * std::sqrt(w));
    }
    return sizes;
  };
  const auto loss_of = [](const std::vector<double>& sizes, double scale) {
    double loss = 0;
    // Outliers must not choose the model.
    for (const double size : sizes) loss += 0.5 * std::log1p((size / scale) * (size / scale));
    return loss;
  };
  constexpr std::array<double, 3> kStiffness{10, 0.1, 0.001};
  for (std::size_t level = 0; level < levels.spacing_px.size(); ++level) {
    const SplineSurface grid = make_grid(levels.spacing_px[level], width_px, height_px);
    // Two coordinates of the same samples lie at the same places.
    const std::vector<SplineBasis> places = bases_at(grid, coordinates.front()->positions);
    std::vector<std::optional<LevelData>> data(tasks.size());
    parallel_for(static_cast<int>(tasks.size()), [&](int t) {
      const Task& task = tasks[static_cast<std::size_t>(t)];
      data[static_cast<std::size_t>(t)].emplace(grid, places, task.residual, task.weights);
    });
    std::vector<std::array<std::vector<double>, kStiffness.size()>> after(tasks.size());
    parallel_for(static_cast<int>(tasks.size() * kStiffness.size()), [&](int trial) {
      const auto k = static_cast<std::size_t>(trial);
      const Task& task = tasks[k / kStiffness.size()];
      SplineSurface surface = grid;
      // Residuals shrink level by level.
      surface.coefficients =
          LevelSystem(*data[k / kStiffness.size()], kStiffness[k % kStiffness.size()])
              .solve(kTrialTolerance, kTrialIterations);
      std::vector<double>& out = after[k / kStiffness.size()][k % kStiffness.size()];
      out = task.residual;
      for (std::size_t s = 0; s < out.size(); ++s) {
        if (task.samples->weights[s] > 0) out[s] -= value_at(surface, places[s]);
      }
    });
    std::array<double, kStiffness.size()> gain{};
    std::size_t n_left_out = 0;
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const std::vector<double> before = left_out(tasks[t], tasks[t].residual);
      std::array<std::vector<double>, kStiffness.size()> sizes;
      double scale = 1e300;
      for (std::size_t k = 0; k < kStiffness.size(); ++k) {
        sizes[k] = left_out(tasks[t], after[t][k]);
        scale = std::min(scale, middle_of(sizes[k]));
      }
      scale = std::max(1.4826 * scale, 1e-9);
      const double none = loss_of(before, scale);
      n_left_out += before.size();
      for (std::size_t k = 0; k < kStiffness.size(); ++k)
        gain[k] += none - loss_of(sizes[k], scale);
    }
    const std::size_t best =
        static_cast<std::size_t>(std::max_element(gain.begin(), gain.end()) - gain.begin());
    // A correction must predict what it has not seen clearly better, or the film counts as stiff:
    // what the picture does to the phases is alike from block to block, too.
    const auto n_gains = static_cast<double>(n_left_out);
    if (!(gain[best] > kLeastLevelGain * n_gains + kLevelScatter * std::sqrt(n_gains))) continue;
    levels.stiffness[level] = kStiffness[best];
    for (std::size_t t = 0; t < tasks.size(); ++t) tasks[t].residual = after[t][best];
  }
}

SplineSurface fit_surface(const ScatteredValues& samples, int width_px, int height_px,
                          const SurfaceLevels& levels) {
  SplineSurface sum;
  std::vector<double> residual = samples.values;
  for (std::size_t level = 0; level < levels.spacing_px.size(); ++level) {
    SplineSurface grid = make_grid(levels.spacing_px[level], width_px, height_px);
    if (level > 0) sum = refined(sum, width_px, height_px);
    if (level == 0) sum = grid;
    if (levels.stiffness[level] < 0) continue;
    const std::vector<SplineBasis> places = bases_at(grid, samples.positions);
    const LevelData data(grid, places, residual, samples.weights);
    grid.coefficients =
        LevelSystem(data, levels.stiffness[level]).solve(kTolerance, kMostIterations);
    for (std::size_t s = 0; s < residual.size(); ++s) {
      if (samples.weights[s] > 0) residual[s] -= value_at(grid, places[s]);
    }
    for (std::size_t i = 0; i < sum.coefficients.size(); ++i)
      sum.coefficients[i] += grid.coefficients[i];
  }
  return sum;
}

}  // namespace reseau
