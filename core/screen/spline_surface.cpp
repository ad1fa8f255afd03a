#include "core/screen/spline_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"

namespace reseau {
namespace {

struct Basis {
  std::array<double, 4> x, y;
  int i = 0, j = 0;
};

std::array<double, 4> cubic(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
}

Basis basis_at(const SplineSurface& grid, Vec2 p) {
  Basis b;
  const auto locate = [&](double position, int n, int& first) {
    const double cell = std::clamp(position / grid.spacing_px, 0.0, n - 3.0);
    first = std::min(static_cast<int>(cell), n - 4);
    return cubic(cell - first);
  };
  b.x = locate(p.x, grid.n_columns, b.i);
  b.y = locate(p.y, grid.n_rows, b.j);
  return b;
}

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

// A node counts as unseen where samples weigh so little of one that lies beside it.
constexpr double kUnseen = 0.01;

// Normal equations of a level: a node is coupled with its 7 x 7 neighbourhood.
class LevelSystem {
 public:
  LevelSystem(const SplineSurface& grid, const ScatteredValues& samples,
              const std::vector<double>& residual, const std::vector<double>& weights,
              double stiffness)
      : nx_(grid.n_columns), ny_(grid.n_rows), a_(size() * 49), b_(size()) {
    double total = 0;
    std::size_t n = 0;
    for (std::size_t s = 0; s < residual.size(); ++s) {
      if (!(weights[s] > 0)) continue;
      total += weights[s];
      ++n;
      const Basis basis = basis_at(grid, samples.positions[s]);
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
          const double w = weights[s] * basis.x[static_cast<std::size_t>(i)] *
                           basis.y[static_cast<std::size_t>(j)];
          const std::size_t row = index(basis.i + i, basis.j + j);
          b_[row] += w * residual[s];
          for (int q = 0; q < 4; ++q) {
            for (int p = 0; p < 4; ++p) {
              entry(row, p - i, q - j) +=
                  w * basis.x[static_cast<std::size_t>(p)] * basis.y[static_cast<std::size_t>(q)];
            }
          }
        }
      }
    }
    // One sample per node spreads a sixteenth or so of its weight on the diagonal.
    const double unit = n > 0 ? total / static_cast<double>(n) * 0.05 : 1;
    std::vector<double> seen(size());
    for (std::size_t row = 0; row < size(); ++row) seen[row] = entry(row, 0, 0);
    add_bending(unit * stiffness);
    for (std::size_t row = 0; row < size(); ++row) {
      // Slopes are not to run on into where nothing was seen.
      const double ridge =
          far_from_seen(seen, row, kUnseen * unit) ? 0.02 : std::min(0.02, 0.2 * stiffness);
      entry(row, 0, 0) += unit * (ridge + 0.001 * stiffness);
    }
  }

  // Conjugate gradients with a diagonal preconditioner: sums in a fixed order, so the result is the
  // same on any number of threads.
  [[nodiscard]] std::vector<double> solve() const {
    std::vector<double> x(size()), r = b_, z(size()), p(size()), q(size());
    double rz = 0, rz_start = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      z[i] = r[i] / diagonal(i);
      rz += r[i] * z[i];
    }
    rz_start = rz;
    p = z;
    for (int iteration = 0; iteration < 250 && rz > 1e-10 * rz_start && rz > 0; ++iteration) {
      multiply(p, q);
      double pq = 0;
      for (std::size_t i = 0; i < size(); ++i) pq += p[i] * q[i];
      if (!(pq > 0)) break;
      const double alpha = rz / pq;
      double fresh = 0;
      for (std::size_t i = 0; i < size(); ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
        z[i] = r[i] / diagonal(i);
        fresh += r[i] * z[i];
      }
      const double beta = fresh / rz;
      rz = fresh;
      for (std::size_t i = 0; i < size(); ++i) p[i] = z[i] + beta * p[i];
    }
    return x;
  }

 private:
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_);
  }
  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) +
           static_cast<std::size_t>(i);
  }
  double& entry(std::size_t row, int di, int dj) {
    return a_[row * 49 + static_cast<std::size_t>((dj + 3) * 7 + di + 3)];
  }
  [[nodiscard]] double diagonal(std::size_t row) const {
    return std::max(a_[row * 49 + 24], 1e-300);
  }

  // Whether neither a node nor one of the eight about it was seen.
  [[nodiscard]] bool far_from_seen(const std::vector<double>& seen, std::size_t row,
                                   double least) const {
    const int i = static_cast<int>(row) % nx_, j = static_cast<int>(row) / nx_;
    for (int dj = std::max(-1, -j); dj <= std::min(1, ny_ - 1 - j); ++dj) {
      for (int di = std::max(-1, -i); di <= std::min(1, nx_ - 1 - i); ++di) {
        if (seen[index(i + di, j + dj)] > least) return false;
      }
    }
    return true;
  }

  void add_bending(double weight) {
    const auto add = [&](int i, int j, std::initializer_list<std::array<int, 3>> stencil,
                         double w) {
      for (const auto& [ai, aj, av] : stencil) {
        for (const auto& [bi, bj, bv] : stencil)
          entry(index(i + ai, j + aj), bi - ai, bj - aj) += w * av * bv;
      }
    };
    for (int j = 0; j < ny_; ++j) {
      for (int i = 0; i < nx_; ++i) {
        if (i + 2 < nx_) add(i, j, {{0, 0, 1}, {1, 0, -2}, {2, 0, 1}}, weight);
        if (j + 2 < ny_) add(i, j, {{0, 0, 1}, {0, 1, -2}, {0, 2, 1}}, weight);
        if (i + 1 < nx_ && j + 1 < ny_)
          add(i, j, {{0, 0, 1}, {1, 0, -1}, {0, 1, -1}, {1, 1, 1}}, 2 * weight);
      }
    }
  }

  void multiply(const std::vector<double>& x, std::vector<double>& y) const {
    for (int j = 0; j < ny_; ++j) {
      for (int i = 0; i < nx_; ++i) {
        const std::size_t row = index(i, j);
        double sum = 0;
        for (int dj = std::max(-3, -j); dj <= std::min(3, ny_ - 1 - j); ++dj) {
          const double* a = &a_[row * 49 + static_cast<std::size_t>((dj + 3) * 7 + 3)];
          const double* v = &x[index(i, j + dj)];
          for (int di = std::max(-3, -i); di <= std::min(3, nx_ - 1 - i); ++di)
            sum += a[di] * v[di];
        }
        y[row] = sum;
      }
    }
  }

  int nx_, ny_;
  std::vector<double> a_, b_;
};

// What the levels chosen so far, and one more, make of some samples. Residuals shrink level by
// level.
std::vector<double> correction(const SplineSurface& grid, const ScatteredValues& samples,
                               const std::vector<double>& residual,
                               const std::vector<double>& weights, double stiffness) {
  return LevelSystem(grid, samples, residual, weights, stiffness).solve();
}

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

double SplineSurface::at(Vec2 p) const {
  const Basis b = basis_at(*this, p);
  double sum = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row =
        &coefficients[(static_cast<std::size_t>(b.j) + j) * static_cast<std::size_t>(n_columns) +
                      static_cast<std::size_t>(b.i)];
    sum += b.y[j] * (b.x[0] * row[0] + b.x[1] * row[1] + b.x[2] * row[2] + b.x[3] * row[3]);
  }
  return sum;
}

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
    std::vector<std::array<std::vector<double>, kStiffness.size()>> after(tasks.size());
    parallel_for(static_cast<int>(tasks.size() * kStiffness.size()), [&](int trial) {
      const auto k = static_cast<std::size_t>(trial);
      const Task& task = tasks[k / kStiffness.size()];
      SplineSurface surface = grid;
      surface.coefficients = correction(grid, *task.samples, task.residual, task.weights,
                                        kStiffness[k % kStiffness.size()]);
      std::vector<double>& out = after[k / kStiffness.size()][k % kStiffness.size()];
      out = task.residual;
      for (std::size_t s = 0; s < out.size(); ++s) {
        if (task.samples->weights[s] > 0) out[s] -= surface.at(task.samples->positions[s]);
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
    grid.coefficients =
        correction(grid, samples, residual, samples.weights, levels.stiffness[level]);
    for (std::size_t s = 0; s < residual.size(); ++s) {
      if (samples.weights[s] > 0) residual[s] -= grid.at(samples.positions[s]);
    }
    for (std::size_t i = 0; i < sum.coefficients.size(); ++i)
      sum.coefficients[i] += grid.coefficients[i];
  }
  return sum;
}

}  // namespace reseau
