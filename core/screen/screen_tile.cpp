#include "core/screen/screen_tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

namespace reseau {
namespace {
using Complex = std::complex<double>;
// 1, x, y (the picture changes across a tile), then cos and sin of each harmonic.
constexpr int kTerms = 3 + 2 * static_cast<int>(kTileHarmonics.size());
using Normal = Eigen::Matrix<double, kTerms, kTerms>;
using Terms = Eigen::Matrix<double, kTerms, 1>;
using Right = Eigen::Matrix<double, kTerms, 4>;  // a column for each channel

// The phases of u and v along a row, by turning from pixel to pixel: between two places of the map
// a few pixels apart it is straight to far less than is measured here.
class RowPhases {
 public:
  RowPhases(const ScreenMap& map, int width) : run_(map.line_error().none() ? 8 : 2), map_(map) {
    u.resize(static_cast<std::size_t>(width));
    v.resize(u.size());
  }
  void set_row(int x0, int y) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const int width = static_cast<int>(u.size());
    const auto place = [&](int x) {
      return map_.screen_from_scan({static_cast<double>(x0 + x), static_cast<double>(y)});
    };
    Vec2 from = place(0);
    for (int x = 0; x < width; x += run_) {
      const Vec2 to = place(x + run_);
      Complex at_u = std::polar(1.0, kTurn * from.x), at_v = std::polar(1.0, kTurn * from.y);
      const Complex step_u = std::polar(1.0, kTurn * (to.x - from.x) / run_),
                    step_v = std::polar(1.0, kTurn * (to.y - from.y) / run_);
      for (int i = x; i < std::min(x + run_, width); ++i) {
        u[static_cast<std::size_t>(i)] = at_u;
        v[static_cast<std::size_t>(i)] = at_v;
        at_u = product(at_u, step_u);
        at_v = product(at_v, step_v);
      }
      from = to;
    }
  }
  // Without the care for infinities that std::complex takes.
  static Complex product(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  }
  std::vector<Complex> u, v;

 private:
  int run_;
  const ScreenMap& map_;
};

// Roots of a Hann window: sin from border to border.
std::vector<double> root_of_hann(int n) {
  std::vector<double> root(static_cast<std::size_t>(std::max(n, 0)));
  for (std::size_t i = 0; i < root.size(); ++i)
    root[i] = std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / n);
  return root;
}

}  // namespace

ScreenTile measure_screen_tile(const LinearRows& rows, int x0, int size, const ScreenMap& map) {
  ScreenTile tile;
  const int height = std::min(size, rows.n), width = std::min(size, rows.width_px - x0);
  Normal normal = Normal::Zero();
  Right right = Right::Zero();
  Eigen::Array4d energy = Eigen::Array4d::Zero();
  double weight_sum = 0, square_sum = 0;
  int n_lost = 0;
  const std::vector<double> root_x = root_of_hann(width), root_y = root_of_hann(height);
  RowPhases phases(map, std::max(width, 0));
  double plain_sum = 0, difference_squares = 0;
  for (int y = 0; y < height; ++y) {
    const float* silver = rows.row(3, y) + x0;
    for (int x = 0; x < width; ++x) {
      plain_sum += double{silver[x]};
      const double step = x > 0 ? double{silver[x]} - double{silver[x - 1]} : 0;
      difference_squares += step * step;
    }
  }
  const double n_all = static_cast<double>(std::max(width, 1)) * std::max(height, 1);
  tile.plain_mean = plain_sum / n_all;
  tile.plain_noise = std::sqrt(0.5 * difference_squares / n_all);
  // Of the pixels of a row that are not lost, by the root of their weight.
  Eigen::Matrix<double, kTerms, Eigen::Dynamic> terms(kTerms, width);
  Eigen::Matrix<double, 4, Eigen::Dynamic> values(4, width);
  for (int y = 0; y < height; ++y) {
    phases.set_row(x0, rows.first + y);
    int n_kept = 0;
    for (int x = 0; x < width; ++x) {
      if (!(rows.row(3, y)[x0 + x] > 0)) {
        ++n_lost;
        continue;
      }
      const double root = root_x[static_cast<std::size_t>(x)] * root_y[static_cast<std::size_t>(y)];
      const Complex u = phases.u[static_cast<std::size_t>(x)],
                    v = phases.v[static_cast<std::size_t>(x)];
      const std::array<Complex, kTileHarmonics.size()> turn{u,
                                                            v,
                                                            RowPhases::product(u, v),
                                                            RowPhases::product(u, std::conj(v)),
                                                            RowPhases::product(u, u),
                                                            RowPhases::product(v, v)};
      double* term = &terms(0, n_kept);
      term[0] = root;
      term[1] = root * ((x + 0.5) / width - 0.5);
      term[2] = root * ((y + 0.5) / height - 0.5);
      for (std::size_t h = 0; h < turn.size(); ++h) {
        term[3 + 2 * h] = root * turn[h].real();
        term[4 + 2 * h] = root * turn[h].imag();
      }
      for (int c = 0; c < 4; ++c) values(c, n_kept) = root * double{rows.row(c, y)[x0 + x]};
      const double window = root * root;
      weight_sum += window;
      square_sum += window * window;
      ++n_kept;
    }
    const auto kept = terms.leftCols(n_kept);
    const auto kept_values = values.leftCols(n_kept);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(kept);
    right.noalias() += kept * kept_values.transpose();
    energy += kept_values.rowwise().squaredNorm().array();
  }
  if (n_lost * 20 > width * height || !(square_sum > 0)) return tile;
  Normal full = normal.selfadjointView<Eigen::Lower>();
  // A harmonic beyond the sampling limit would pose as a lower one; the blur has taken it anyway.
  const Mat2 frequency = map.jacobian({x0 + width / 2.0, rows.first + height / 2.0}).transposed();
  for (int h = 0; h < kTileAmplitudes - 1; ++h) {
    const HarmonicIndex i = kTileHarmonics[static_cast<std::size_t>(h)];
    const Vec2 f = frequency * Vec2{static_cast<double>(i.u), static_cast<double>(i.v)};
    if (std::abs(f.x) < 0.5 && std::abs(f.y) < 0.5) continue;
    for (const int t : {3 + 2 * h, 4 + 2 * h}) full(t, t) += 1e12 * weight_sum;
  }
  const Eigen::LDLT<Normal> solver(full);
  if (solver.info() != Eigen::Success) return tile;
  tile.n_effective = weight_sum * weight_sum / square_sum;
  if (tile.n_effective < 3 * kTerms) return tile;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto channel = static_cast<Eigen::Index>(c);
    const Terms a = solver.solve(right.col(channel));
    if (!a.allFinite()) {
      ScreenTile nothing;
      nothing.plain_mean = tile.plain_mean;
      nothing.plain_noise = tile.plain_noise;
      return nothing;
    }
    tile.amplitude[c][0] = a(0);
    for (int h = 0; h < kTileAmplitudes - 1; ++h) {
      // a cos + b sin of an even pattern: each exponential carries half of a.
      tile.amplitude[c][static_cast<std::size_t>(h) + 1] = 0.5 * a(3 + 2 * h);
      tile.odd[c][static_cast<std::size_t>(h) + 1] = 0.5 * a(4 + 2 * h);
    }
    for (int h = 0; h < 2; ++h) {
      tile.fundamental[c][static_cast<std::size_t>(h)] = 0.5 * Complex(a(3 + 2 * h), -a(4 + 2 * h));
    }
    tile.variance[c] = std::max(energy(channel) - a.dot(right.col(channel)), 0.0) / weight_sum;
  }
  tile.used = tile.amplitude[3][0] > 1e-3;
  return tile;
}

}  // namespace reseau
