#include "core/screen/level_system.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>

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

std::array<double, 4> cubic(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
}

// A node counts as unseen where samples weigh so little of one that lies beside it.
constexpr double kUnseen = 0.01;

}  // namespace

SplineBasis basis_at(const SplineSurface& grid, Vec2 p) {
  SplineBasis b;
  const auto locate = [&](double position, int n, int& first) {
    const double cell = std::clamp(position / grid.spacing_px, 0.0, n - 3.0);
    first = std::min(static_cast<int>(cell), n - 4);
    return cubic(cell - first);
  };
  b.x = locate(p.x, grid.n_columns, b.i);
  b.y = locate(p.y, grid.n_rows, b.j);
  return b;
}

std::vector<SplineBasis> bases_at(const SplineSurface& grid, const std::vector<Vec2>& positions) {
  std::vector<SplineBasis> bases;
  bases.reserve(positions.size());
  for (const Vec2 p : positions) bases.push_back(basis_at(grid, p));
  return bases;
}

double value_at(const SplineSurface& grid, const SplineBasis& b) {
  double sum = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    const double* row = &grid.coefficients[(static_cast<std::size_t>(b.j) + j) *
                                               static_cast<std::size_t>(grid.n_columns) +
                                           static_cast<std::size_t>(b.i)];
    sum += b.y[j] * (b.x[0] * row[0] + b.x[1] * row[1] + b.x[2] * row[2] + b.x[3] * row[3]);
  }
  return sum;
}

LevelData::LevelData(const SplineSurface& grid, const std::vector<SplineBasis>& places,
                     const std::vector<double>& values, const std::vector<double>& weights)
    : nx_(grid.n_columns),
      ny_(grid.n_rows),
      matrix_(index(0, ny_) * kCoupled),
      right_(index(0, ny_)) {
  double total = 0;
  std::size_t n = 0;
  for (std::size_t s = 0; s < values.size(); ++s) {
    if (!(weights[s] > 0)) continue;
    total += weights[s];
    ++n;
    add(places[s], weights[s], values[s]);
  }
  mirror();
  // One sample per node spreads a sixteenth or so of its weight on the diagonal.
  unit_ = n > 0 ? total / static_cast<double>(n) * 0.05 : 1;
}

bool LevelData::far_from_seen(int i, int j) const {
  for (int dj = std::max(-1, -j); dj <= std::min(1, ny_ - 1 - j); ++dj) {
    for (int di = std::max(-1, -i); di <= std::min(1, nx_ - 1 - i); ++di) {
      if (matrix_[index(i + di, j + dj) * kCoupled + kSelf] > kUnseen * unit_) return false;
    }
  }
  return true;
}

// One sample, in the half of the matrix where neighbours are in the same row of nodes or below.
void LevelData::add(const SplineBasis& basis, double weight, double value) {
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
      right_[row] += w * value;
      double* coupled = &matrix_[row * kCoupled + place(-i, 0)];
      for (auto q = static_cast<std::size_t>(j); q < 4; ++q, coupled += kSide) {
        store2(coupled, load2(coupled) + w * product[2 * q]);
        store2(coupled + 2, load2(coupled + 2) + w * product[2 * q + 1]);
      }
    }
  }
}

// The other half: what couples with a node couples the node with it.
void LevelData::mirror() {
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      double* row = &matrix_[index(i, j) * kCoupled];
      for (int dj = std::max(-kReach, -j); dj < 0; ++dj) {
        for (int di = std::max(-kReach, -i); di <= std::min(kReach, nx_ - 1 - i); ++di)
          row[place(di, dj)] = matrix_[index(i + di, j + dj) * kCoupled + place(-di, -dj)];
      }
    }
  }
}

LevelSystem::LevelSystem(const LevelData& data, double stiffness)
    : data_(data),
      columns_((data.nx() + kAtOnce - 1) / kAtOnce * kAtOnce),
      stride_(columns_ + 2 * LevelData::kReach),
      a_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(data.ny()) *
         LevelData::kCoupled),
      b_(vector_size()),
      inverse_diagonal_(vector_size()) {
  for (int j = 0; j < data.ny(); ++j) {
    for (int i = 0; i < data.nx(); ++i) {
      const double* from = data.coupled(i, j);
      for (std::size_t k = 0; k < LevelData::kCoupled; ++k) a_[entry(i, j, k)] = from[k];
      b_[in_vector(i, j)] = data.right(i, j);
    }
  }
  add_bending(data.unit() * stiffness);
  for (int j = 0; j < data.ny(); ++j) {
    for (int i = 0; i < data.nx(); ++i) {
      // Slopes are not to run on into where nothing was seen.
      const double ridge = data.far_from_seen(i, j) ? 0.02 : std::min(0.02, 0.2 * stiffness);
      double& self = a_[entry(i, j, LevelData::kSelf)];
      self += data.unit() * (ridge + 0.001 * stiffness);
      inverse_diagonal_[in_vector(i, j)] = 1 / std::max(self, 1e-300);
    }
  }
}

std::vector<double> LevelSystem::solve(double tolerance, int most_iterations) const {
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
  std::vector<double> out(data_.index(0, data_.ny()));
  for (int j = 0; j < data_.ny(); ++j) {
    for (int i = 0; i < data_.nx(); ++i) out[data_.index(i, j)] = x[in_vector(i, j)];
  }
  return out;
}

void LevelSystem::add_bending(double weight) {
  const auto add = [&](int i, int j, std::initializer_list<std::array<int, 3>> stencil, double w) {
    for (const auto& [ai, aj, av] : stencil) {
      for (const auto& [bi, bj, bv] : stencil)
        a_[entry(i + ai, j + aj, LevelData::place(bi - ai, bj - aj))] += w * av * bv;
    }
  };
  for (int j = 0; j < data_.ny(); ++j) {
    for (int i = 0; i < data_.nx(); ++i) {
      if (i + 2 < data_.nx()) add(i, j, {{0, 0, 1}, {1, 0, -2}, {2, 0, 1}}, weight);
      if (j + 2 < data_.ny()) add(i, j, {{0, 0, 1}, {0, 1, -2}, {0, 2, 1}}, weight);
      if (i + 1 < data_.nx() && j + 1 < data_.ny())
        add(i, j, {{0, 0, 1}, {1, 0, -1}, {0, 1, -1}, {1, 1, 1}}, 2 * weight);
    }
  }
}

void LevelSystem::multiply(const std::vector<double>& x, std::vector<double>& y) const {
  for (int j = 0; j < data_.ny(); ++j) {
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

double LevelSystem::product(const std::vector<double>& a, const std::vector<double>& b) {
  std::array<double, kAtOnce> sum{};
  std::size_t i = 0;
  for (; i + kAtOnce <= a.size(); i += kAtOnce) {
    for (std::size_t k = 0; k < kAtOnce; ++k) sum[k] += a[i + k] * b[i + k];
  }
  for (std::size_t k = 0; i < a.size(); ++i, ++k) sum[k] += a[i] * b[i];
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

}  // namespace reseau
