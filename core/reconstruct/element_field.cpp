#include "core/reconstruct/element_field.h"

#include <algorithm>

#include <Eigen/Dense>

#include "core/base/check.h"

namespace reseau {
namespace {

constexpr int kRoom = 3;  // lattice steps beyond the covered area

// Weights of the four neighbours of Catmull-Rom interpolation at t in [0, 1).
std::array<float, 4> catmull_rom(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5F * (-t + 2 * t2 - t3), 0.5F * (2 - 5 * t2 + 3 * t3), 0.5F * (t + 4 * t2 - 3 * t3),
          0.5F * (t3 - t2)};
}

// Floor of a coordinate, kept so that `before` and `after` neighbours exist.
int cell_of(float position, int n, int before, int after) {
  return std::clamp(static_cast<int>(std::floor(position)), before, n - 1 - after);
}

}  // namespace

ElementField::ElementField(const ScreenPattern& pattern, Vec2 lowest, Vec2 highest) {
  for (std::size_t k = 0; k < 3; ++k) {
    Lattice& lattice = lattice_[k];
    lattice.origin = pattern.lattices()[k].origin;
    lattice.step = pattern.lattices()[k].step;
    lattice.first_i =
        static_cast<int>(std::floor((lowest.x - lattice.origin.x) / lattice.step.x)) - kRoom;
    lattice.first_j =
        static_cast<int>(std::floor((lowest.y - lattice.origin.y) / lattice.step.y)) - kRoom;
    lattice.n_i = static_cast<int>(std::ceil((highest.x - lattice.origin.x) / lattice.step.x)) +
                  kRoom - lattice.first_i + 1;
    lattice.n_j = static_cast<int>(std::ceil((highest.y - lattice.origin.y) / lattice.step.y)) +
                  kRoom - lattice.first_j + 1;
    const std::size_t n =
        static_cast<std::size_t>(lattice.n_i) * static_cast<std::size_t>(lattice.n_j);
    lattice.sums.resize(n);
    lattice.value.resize(n);
    lattice.residual.resize(n);
    lattice.filled.resize(n);
  }
}

void ElementField::add(float u, float v, float silver, const std::array<float, 3>& shares) {
  for (std::size_t k = 0; k < 3; ++k) {
    const float weight = shares[k] * shares[k];
    if (weight < 1e-4F) continue;
    Lattice& lattice = lattice_[k];
    const int i = static_cast<int>(std::floor(lattice.lattice_x(u) + 0.5F));
    const int j = static_cast<int>(std::floor(lattice.lattice_y(v) + 0.5F));
    DCHECK(i >= 0 && j >= 0 && i < lattice.n_i && j < lattice.n_j);
    Sums& sums = lattice.sums[lattice.index(i, j)];
    sums.weight += weight;
    sums.silver += weight * silver;
    for (std::size_t l = 0; l < 3; ++l) sums.shares[l] += weight * shares[l];
  }
}

// Means instead of sums; elements without pixels (dust, clipping, the rim) take the mean of their
// neighbours, from the outside in.
void ElementField::normalise(Lattice& lattice, std::size_t color,
                             const std::array<std::array<double, 3>, 3>& mean) {
  float typical = 0;
  for (const Sums& sums : lattice.sums) typical = std::max(typical, sums.weight);
  const float least = 0.12F * typical;
  for (std::size_t e = 0; e < lattice.sums.size(); ++e) {
    Sums& sums = lattice.sums[e];
    lattice.filled[e] = sums.weight > least && sums.weight > 0 ? 1 : 0;
    if (lattice.filled[e] == 0) {
      for (std::size_t l = 0; l < 3; ++l) sums.shares[l] = static_cast<float>(mean[color][l]);
      continue;
    }
    lattice.value[e] = sums.silver / sums.weight;
    for (float& share : sums.shares) share /= sums.weight;
  }
  for (int round = 0; round < 2 * kRoom + 4; ++round) {
    std::vector<std::size_t> fresh;
    for (int j = 0; j < lattice.n_j; ++j) {
      for (int i = 0; i < lattice.n_i; ++i) {
        const std::size_t e = lattice.index(i, j);
        if (lattice.filled[e] != 0) continue;
        float sum = 0;
        int n = 0;
        for (int b = std::max(0, j - 1); b <= std::min(lattice.n_j - 1, j + 1); ++b) {
          for (int a = std::max(0, i - 1); a <= std::min(lattice.n_i - 1, i + 1); ++a) {
            if (lattice.filled[lattice.index(a, b)] != 1) continue;
            sum += lattice.value[lattice.index(a, b)];
            ++n;
          }
        }
        if (n == 0) continue;
        lattice.value[e] = sum / static_cast<float>(n);
        lattice.filled[e] = 2;  // this round: not yet a source for others
        fresh.push_back(e);
      }
    }
    if (fresh.empty()) break;
    for (const std::size_t e : fresh) lattice.filled[e] = 1;
  }
}

float ElementField::bilinear(const Lattice& lattice, const std::vector<float>& values, float u,
                             float v) {
  const float x = lattice.lattice_x(u), y = lattice.lattice_y(v);
  const int i = cell_of(x, lattice.n_i, 0, 1), j = cell_of(y, lattice.n_j, 0, 1);
  const float fx = std::clamp(x - static_cast<float>(i), 0.0F, 1.0F);
  const float fy = std::clamp(y - static_cast<float>(j), 0.0F, 1.0F);
  const float* row = &values[lattice.index(i, j)];
  const float top = row[0] + fx * (row[1] - row[0]);
  row += lattice.n_i;
  const float bottom = row[0] + fx * (row[1] - row[0]);
  return top + fy * (bottom - top);
}

// Solves the local 3 x 3 of every element: its own mean, and those of the other colours between
// their neighbours, against what each holds of whose light.
void ElementField::unmix(const std::vector<float> Lattice::*from, double ridge, bool add) {
  std::array<std::vector<float>, 3> solved;
  // Crosstalk of the other colours, interpolated like their values.
  std::array<std::array<std::vector<float>, 3>, 3> rows;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t l = 0; l < 3; ++l) {
      rows[k][l].resize(lattice_[k].sums.size());
      for (std::size_t e = 0; e < rows[k][l].size(); ++e)
        rows[k][l][e] = lattice_[k].sums[e].shares[l];
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const Lattice& own = lattice_[k];
    solved[k].resize(own.sums.size());
    for (int j = 0; j < own.n_j; ++j) {
      for (int i = 0; i < own.n_i; ++i) {
        const std::size_t e = own.index(i, j);
        const auto u = static_cast<float>(own.origin.x + (own.first_i + i) * own.step.x);
        const auto v = static_cast<float>(own.origin.y + (own.first_j + j) * own.step.y);
        Eigen::Matrix3f c;
        Eigen::Vector3f y;
        for (std::size_t l = 0; l < 3; ++l) {
          const auto row = static_cast<Eigen::Index>(l);
          if (l == k) {
            y(row) = (own.*from)[e];
            for (std::size_t m = 0; m < 3; ++m)
              c(row, static_cast<Eigen::Index>(m)) = rows[k][m][e];
          } else {
            y(row) = bilinear(lattice_[l], lattice_[l].*from, u, v);
            for (std::size_t m = 0; m < 3; ++m) {
              c(row, static_cast<Eigen::Index>(m)) = bilinear(lattice_[l], rows[l][m], u, v);
            }
          }
        }
        // Deviations from grey are solved for, so that the ridge never changes the brightness:
        // every row of c sums to one, hence c * grey = grey.
        const float grey = y.mean();
        const Eigen::Vector3f d = y - Eigen::Vector3f::Constant(grey);
        Eigen::Matrix3f normal = c.transpose() * c;
        normal.diagonal().array() += static_cast<float>(ridge);
        const Eigen::Vector3f x = normal.inverse() * (c.transpose() * d);
        solved[k][e] = x(static_cast<Eigen::Index>(k)) + grey;
      }
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t e = 0; e < solved[k].size(); ++e) {
      lattice_[k].value[e] = add ? lattice_[k].value[e] + solved[k][e] : solved[k][e];
    }
  }
}

void ElementField::finish(const std::array<std::array<double, 3>, 3>& mean_crosstalk, double ridge,
                          int n_refinements) {
  std::array<std::vector<float>, 3> measured;
  for (std::size_t k = 0; k < 3; ++k) {
    normalise(lattice_[k], k, mean_crosstalk);
    measured[k] = lattice_[k].value;
  }
  unmix(&Lattice::value, ridge, false);
  // Where colour changes from element to element the local 3 x 3 is not the whole truth: compare
  // what the intensities would give with what was measured, and unmix the difference.
  for (int round = 0; round < n_refinements; ++round) {
    for (std::size_t k = 0; k < 3; ++k) {
      Lattice& own = lattice_[k];
      for (int j = 0; j < own.n_j; ++j) {
        for (int i = 0; i < own.n_i; ++i) {
          const std::size_t e = own.index(i, j);
          const auto u = static_cast<float>(own.origin.x + (own.first_i + i) * own.step.x);
          const auto v = static_cast<float>(own.origin.y + (own.first_j + j) * own.step.y);
          float expected = own.sums[e].shares[k] * own.value[e];
          for (std::size_t l = 0; l < 3; ++l) {
            if (l != k)
              expected += own.sums[e].shares[l] * bilinear(lattice_[l], lattice_[l].value, u, v);
          }
          own.residual[e] = measured[k][e] - expected;
        }
      }
    }
    unmix(&Lattice::residual, ridge, true);
  }
  for (Lattice& lattice : lattice_) {
    if (lattice.step.x < 0.75) smooth_pairs(lattice);
  }
}

// Two samples of a line per period lie one beside green, one beside blue; whatever the model of the
// blur leaves of its neighbours would alternate between them and stripe the picture.
void ElementField::smooth_pairs(Lattice& lattice) {
  std::vector<float> row(static_cast<std::size_t>(lattice.n_i));
  for (int j = 0; j < lattice.n_j; ++j) {
    float* values = &lattice.value[lattice.index(0, j)];
    std::copy_n(values, lattice.n_i, row.begin());
    for (std::size_t i = 1; i + 1 < row.size(); ++i) {
      values[i] = 0.25F * (row[i - 1] + 2 * row[i] + row[i + 1]);
    }
  }
}

std::array<float, 3> ElementField::at(float u, float v) const {
  std::array<float, 3> result;
  for (std::size_t k = 0; k < 3; ++k) {
    const Lattice& lattice = lattice_[k];
    const float x = lattice.lattice_x(u), y = lattice.lattice_y(v);
    const int i = cell_of(x, lattice.n_i, 1, 2), j = cell_of(y, lattice.n_j, 1, 2);
    const auto wx = catmull_rom(x - static_cast<float>(i));
    const auto wy = catmull_rom(y - static_cast<float>(j));
    const float* row = &lattice.value[lattice.index(i - 1, j - 1)];
    float sum = 0;
    for (std::size_t b = 0; b < 4; ++b) {
      sum += wy[b] * (wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3]);
      row += lattice.n_i;
    }
    result[k] = sum;
  }
  return result;
}

}  // namespace reseau
