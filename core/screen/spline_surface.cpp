#include "core/screen/spline_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/base/parallel.h"

namespace reseau {
namespace {

// Two doubles that the compiler keeps in one register.
using Double2 = double __attribute__((vector_size(16)));
Double2 load2(const double* from) {
  Double2 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
void store2(double* to, Double2 v) { std::memcpy(to, &v, sizeof v); }

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

std::vector<Basis> bases_at(const SplineSurface& grid, const std::vector<Vec2>& positions) {
  std::vector<Basis> bases;
  bases.reserve(positions.size());
  for (const Vec2 p : positions) bases.push_back(basis_at(grid, p));
  return bases;
}

double value_at(const SplineSurface& grid, const Basis& b) {
  double sum = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row = &grid.coefficients[(static_cast<std::size_t>(b.j) + j) *
                                               static_cast<std::size_t>(grid.n_columns) +
                                           static_cast<std::size_t>(b.i)];
    sum += b.y[j] * (b.x[0] * row[0] + b.x[1] * row[1] + b.x[2] * row[2] + b.x[3] * row[3]);
  }
  return sum;
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

// What samples say of the nodes of a level: normal equations in which a node is coupled with its
// 7 x 7 neighbourhood.
struct LevelData {
  static constexpr int kReach = 3, kSide = 2 * kReach + 1;
  static constexpr std::size_t kCoupled = static_cast<std::size_t>(kSide) * kSide, kSelf = 24;

  LevelData(const SplineSurface& grid, const std::vector<Basis>& places,
            const std::vector<double>& residual, const std::vector<double>& weights)
      : nx(grid.n_columns), ny(grid.n_rows), matrix(size() * kCoupled), right(size()) {
    double total = 0;
    std::size_t n = 0;
    for (std::size_t s = 0; s < residual.size(); ++s) {
      if (!(weights[s] > 0)) continue;
      total += weights[s];
      ++n;
      const Basis& basis = places[s];
      add(basis, weights[s], residual[s]);
    }
    mirror();
    // One sample per node spreads a sixteenth or so of its weight on the diagonal.
    unit = n > 0 ? total / static_cast<double>(n) * 0.05 : 1;
  }

  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
  }
  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
  }
  // Of the neighbour (di, dj) among the coupled.
  static std::size_t place(int di, int dj) {
    return static_cast<std::size_t>((dj + kReach) * kSide + di + kReach);
  }

  // Whether neither a node nor one of the eight about it was seen.
  [[nodiscard]] bool far_from_seen(int i, int j) const {
    for (int dj = std::max(-1, -j); dj <= std::min(1, ny - 1 - j); ++dj) {
      for (int di = std::max(-1, -i); di <= std::min(1, nx - 1 - i); ++di) {
        if (matrix[index(i + di, j + dj) * kCoupled + kSelf] > kUnseen * unit) return false;
      }
    }
    return true;
  }

  int nx, ny;
  std::vector<double> matrix;  // [node][neighbour]
  std::vector<double> right;
  double unit = 1;

 private:
  // One sample, in the half of the matrix where neighbours are in the same row of nodes or below.
  void add(const Basis& basis, double weight, double value) {
    std::array<Double2, 8> product;  // of node and node of a sample's 4 x 4
    for (std::size_t j = 0; j < 4; ++j) {
      product[2 * j] = basis.y[j] * load2(&basis.x[0]);
      product[2 * j + 1] = basis.y[j] * load2(&basis.x[2]);
    }
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        const double w =
            weight * basis.x[static_cast<std::size_t>(i)] * basis.y[static_cast<std::size_t>(j)];
        const std::size_t row = index(basis.i + i, basis.j + j);
        right[row] += w * value;
        double* coupled = &matrix[row * kCoupled + place(-i, 0)];
        for (auto q = static_cast<std::size_t>(j); q < 4; ++q, coupled += kSide) {
          store2(coupled, load2(coupled) + w * product[2 * q]);
          store2(coupled + 2, load2(coupled + 2) + w * product[2 * q + 1]);
        }
      }
    }
  }
  // The other half: what couples with a node couples the node with it.
  void mirror() {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        double* row = &matrix[index(i, j) * kCoupled];
        for (int dj = std::max(-kReach, -j); dj < 0; ++dj) {
          for (int di = std::max(-kReach, -i); di <= std::min(kReach, nx - 1 - i); ++di)
            row[place(di, dj)] = matrix[index(i + di, j + dj) * kCoupled + place(-di, -dj)];
        }
      }
    }
  }
};

// The same with a stiffness, laid out so that eight nodes side by side are worked on together:
// a[eight nodes][neighbour][node], rows of nodes filled up with zeros. Vectors have zeros all
// around as well.
class LevelSystem {
 public:
  LevelSystem(const LevelData& data, double stiffness)
      : data_(data),
        columns_((data.nx + kAtOnce - 1) / kAtOnce * kAtOnce),
        stride_(columns_ + 2 * LevelData::kReach),
        a_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(data.ny) *
           LevelData::kCoupled),
        b_(vector_size()),
        inverse_diagonal_(vector_size()) {
    for (int j = 0; j < data.ny; ++j) {
      for (int i = 0; i < data.nx; ++i) {
        const double* from = &data.matrix[data.index(i, j) * LevelData::kCoupled];
        for (std::size_t k = 0; k < LevelData::kCoupled; ++k) a_[entry(i, j, k)] = from[k];
        b_[in_vector(i, j)] = data.right[data.index(i, j)];
      }
    }
    add_bending(data.unit * stiffness);
    for (int j = 0; j < data.ny; ++j) {
      for (int i = 0; i < data.nx; ++i) {
        // Slopes are not to run on into where nothing was seen.
        const double ridge = data.far_from_seen(i, j) ? 0.02 : std::min(0.02, 0.2 * stiffness);
        double& self = a_[entry(i, j, LevelData::kSelf)];
        self += data.unit * (ridge + 0.001 * stiffness);
        inverse_diagonal_[in_vector(i, j)] = 1 / std::max(self, 1e-300);
      }
    }
  }

  // Down to a share of the first residual, squared. Conjugate gradients with a diagonal
  // preconditioner: sums in a fixed order, so the result is the same on any number of threads.
  [[nodiscard]] std::vector<double> solve(double tolerance, int most_iterations) const {
    const std::size_t n = vector_size();
    std::vector<double> x(n), r = b_, z(n), p(n), q(n);
    for (std::size_t i = 0; i < n; ++i) z[i] = r[i] * inverse_diagonal_[i];
    double rz = product(r, z);
    const double rz_start = rz;
    p = z;
    for (int iteration = 0; iteration < most_iterations && rz > tolerance * rz_start && rz > 0;
         ++iteration) {
      multiply(p, q);
      const double pq = product(p, q);
      if (!(pq > 0)) break;
      const double alpha = rz / pq;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
        z[i] = r[i] * inverse_diagonal_[i];
      }
      const double fresh = product(r, z);
      const double beta = fresh / rz;
      rz = fresh;
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    }
    std::vector<double> out(data_.size());
    for (int j = 0; j < data_.ny; ++j) {
      for (int i = 0; i < data_.nx; ++i) out[data_.index(i, j)] = x[in_vector(i, j)];
    }
    return out;
  }

 private:
  static constexpr int kAtOnce = 8;

  [[nodiscard]] std::size_t vector_size() const {
    return static_cast<std::size_t>(stride_) *
           static_cast<std::size_t>(data_.ny + 2 * LevelData::kReach);
  }
  [[nodiscard]] std::size_t entry(int i, int j, std::size_t neighbour) const {
    const auto node = static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                      static_cast<std::size_t>(i);
    return (node / kAtOnce * LevelData::kCoupled + neighbour) * kAtOnce + node % kAtOnce;
  }
  [[nodiscard]] std::size_t in_vector(int i, int j) const {
    return static_cast<std::size_t>(j + LevelData::kReach) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(i + LevelData::kReach);
  }

  void add_bending(double weight) {
    const auto add = [&](int i, int j, std::initializer_list<std::array<int, 3>> stencil,
                         double w) {
      for (const auto& [ai, aj, av] : stencil) {
        for (const auto& [bi, bj, bv] : stencil)
          a_[entry(i + ai, j + aj, LevelData::place(bi - ai, bj - aj))] += w * av * bv;
      }
    };
    for (int j = 0; j < data_.ny; ++j) {
      for (int i = 0; i < data_.nx; ++i) {
        if (i + 2 < data_.nx) add(i, j, {{0, 0, 1}, {1, 0, -2}, {2, 0, 1}}, weight);
        if (j + 2 < data_.ny) add(i, j, {{0, 0, 1}, {0, 1, -2}, {0, 2, 1}}, weight);
        if (i + 1 < data_.nx && j + 1 < data_.ny)
          add(i, j, {{0, 0, 1}, {1, 0, -1}, {0, 1, -1}, {1, 1, 1}}, 2 * weight);
      }
    }
  }

  void multiply(const std::vector<double>& x, std::vector<double>& y) const {
    for (int j = 0; j < data_.ny; ++j) {
      for (int i = 0; i < columns_; i += kAtOnce) {
        const double* a = &a_[entry(i, j, 0)];
        std::array<Double2, kAtOnce / 2> sum{};
        for (int dj = -LevelData::kReach; dj <= LevelData::kReach; ++dj) {
          const double* v = &x[in_vector(i - LevelData::kReach, j + dj)];
          for (int di = 0; di < LevelData::kSide; ++di, a += kAtOnce, ++v) {
            for (std::size_t k = 0; k < sum.size(); ++k)
              sum[k] += load2(a + 2 * k) * load2(v + 2 * k);
          }
        }
        std::memcpy(&y[in_vector(i, j)], sum.data(), sizeof sum);
      }
    }
  }

  static double product(const std::vector<double>& a, const std::vector<double>& b) {
    std::array<double, kAtOnce> sum{};
    std::size_t i = 0;
    for (; i + kAtOnce <= a.size(); i += kAtOnce) {
      for (std::size_t k = 0; k < kAtOnce; ++k) sum[k] += a[i + k] * b[i + k];
    }
    for (std::size_t k = 0; i < a.size(); ++i, ++k) sum[k] += a[i] * b[i];
    return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
  }

  const LevelData& data_;
  int columns_, stride_;
  std::vector<double> a_, b_, inverse_diagonal_;
};

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
    const std::vector<Basis> places = bases_at(grid, coordinates.front()->positions);
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
    const std::vector<Basis> places = bases_at(grid, samples.positions);
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
