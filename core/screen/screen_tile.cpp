#include "core/screen/screen_tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

namespace reseau {
namespace {
using Complex = std::complex<double>;
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

// Least squares in a tile of 1, x, y (the picture changes across it) and the cosines and sines of
// N harmonics.
template <std::size_t N>
struct TileFit {
  static constexpr int kTerms = 3 + 2 * static_cast<int>(N);
  using Normal = Eigen::Matrix<double, kTerms, kTerms>;
  using Right = Eigen::Matrix<double, kTerms, 4>;  // a column for each channel

  TileFit(const LinearRows& rows, int x0, int width, int height, const ScreenMap& map,
          const std::array<HarmonicIndex, N>& harmonics);
  // False where too much is lost, or the terms cannot be told apart.
  bool solve(const ScreenMap& map, Vec2 middle, const std::array<HarmonicIndex, N>& harmonics);

  Normal normal = Normal::Zero();
  Right right = Right::Zero(), solution = Right::Zero();
  Eigen::Array4d energy = Eigen::Array4d::Zero();
  double weight_sum = 0, square_sum = 0;
  int n_lost = 0, n_pixels = 0;
};

template <std::size_t N>
TileFit<N>::TileFit(const LinearRows& rows, int x0, int width, int height, const ScreenMap& map,
                    const std::array<HarmonicIndex, N>& harmonics)
    : n_pixels(width * height) {
  const std::vector<double> root_x = root_of_hann(width), root_y = root_of_hann(height);
  RowPhases phases(map, std::max(width, 0));
  // Of the pixels of a row that are not lost, by the root of their weight.
  Eigen::Matrix<double, kTerms, Eigen::Dynamic> terms(kTerms, width);
  Eigen::Matrix<double, 4, Eigen::Dynamic> values(4, width);
  constexpr int kMost = 3;
  std::array<Complex, 2 * kMost + 1> power_u, power_v;
  for (int y = 0; y < height; ++y) {
    phases.set_row(x0, rows.first + y);
    int n_kept = 0;
    for (int x = 0; x < width; ++x) {
      if (!(rows.row(3, y)[x0 + x] > 0)) {
        ++n_lost;
        continue;
      }
      const double root = root_x[static_cast<std::size_t>(x)] * root_y[static_cast<std::size_t>(y)];
      power_u[kMost] = power_v[kMost] = 1;
      for (std::size_t k = 1; k <= kMost; ++k) {
        power_u[kMost + k] =
            RowPhases::product(power_u[kMost + k - 1], phases.u[static_cast<std::size_t>(x)]);
        power_v[kMost + k] =
            RowPhases::product(power_v[kMost + k - 1], phases.v[static_cast<std::size_t>(x)]);
        power_v[kMost - k] = std::conj(power_v[kMost + k]);
      }
      double* term = &terms(0, n_kept);
      term[0] = root;
      term[1] = root * ((x + 0.5) / width - 0.5);
      term[2] = root * ((y + 0.5) / height - 0.5);
      for (std::size_t h = 0; h < N; ++h) {
        const int u = kMost + harmonics[h].u, v = kMost + harmonics[h].v;
        const Complex turn = RowPhases::product(power_u[static_cast<std::size_t>(u)],
                                                power_v[static_cast<std::size_t>(v)]);
        term[3 + 2 * h] = root * turn.real();
        term[4 + 2 * h] = root * turn.imag();
      }
      for (int c = 0; c < 4; ++c) values(c, n_kept) = root * double{rows.row(c, y)[x0 + x]};
      const double window = root * root;
      weight_sum += window;
      square_sum += window * window;
      ++n_kept;
    }
    const auto kept = terms.leftCols(n_kept);
    const auto kept_values = values.leftCols(n_kept);
    normal.template selfadjointView<Eigen::Lower>().rankUpdate(kept);
    right.noalias() += kept * kept_values.transpose();
    energy += kept_values.rowwise().squaredNorm().array();
  }
}

template <std::size_t N>
bool TileFit<N>::solve(const ScreenMap& map, Vec2 middle,
                       const std::array<HarmonicIndex, N>& harmonics) {
  if (n_lost * 20 > n_pixels || !(square_sum > 0)) return false;
  Normal full = normal.template selfadjointView<Eigen::Lower>();
  // A harmonic beyond the sampling limit would pose as a lower one; the blur has taken it anyway.
  const Mat2 frequency = map.jacobian(middle).transposed();
  for (std::size_t h = 0; h < N; ++h) {
    if (is_sampled(frequency, harmonics[h])) continue;
    for (const int t : {3 + 2 * static_cast<int>(h), 4 + 2 * static_cast<int>(h)})
      full(t, t) += 1e12 * weight_sum;
  }
  const Eigen::LDLT<Normal> solver(full);
  if (solver.info() != Eigen::Success) return false;
  if (weight_sum * weight_sum / square_sum < 3 * kTerms) return false;
  solution = solver.solve(right);
  return solution.allFinite();
}

}  // namespace

bool is_sampled(const Mat2& frequency, HarmonicIndex i) {
  const Vec2 f = frequency * Vec2{static_cast<double>(i.u), static_cast<double>(i.v)};
  return std::abs(f.x) < 0.5 && std::abs(f.y) < 0.5;
}

ScreenTile measure_screen_tile(const LinearRows& rows, int x0, int size, const ScreenMap& map) {
  ScreenTile tile;
  const int height = std::min(size, rows.n), width = std::min(size, rows.width_px - x0);
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
  TileFit<kTileHarmonics.size()> fit(rows, x0, width, height, map, kTileHarmonics);
  if (!fit.solve(map, {x0 + width / 2.0, rows.first + height / 2.0}, kTileHarmonics)) return tile;
  tile.n_effective = fit.weight_sum * fit.weight_sum / fit.square_sum;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto channel = static_cast<Eigen::Index>(c);
    const auto a = fit.solution.col(channel);
    tile.amplitude[c][0] = a(0);
    for (int h = 0; h < kTileAmplitudes - 1; ++h) {
      // a cos + b sin of an even pattern: each exponential carries half of a.
      tile.amplitude[c][static_cast<std::size_t>(h) + 1] = 0.5 * a(3 + 2 * h);
      tile.odd[c][static_cast<std::size_t>(h) + 1] = 0.5 * a(4 + 2 * h);
    }
    for (int h = 0; h < 2; ++h) {
      tile.fundamental[c][static_cast<std::size_t>(h)] = 0.5 * Complex(a(3 + 2 * h), -a(4 + 2 * h));
    }
    tile.variance[c] =
        std::max(fit.energy(channel) - a.dot(fit.right.col(channel)), 0.0) / fit.weight_sum;
  }
  tile.used = tile.amplitude[3][0] > 1e-3;
  return tile;
}

std::optional<ShapeTile> measure_shape_tile(const LinearRows& rows, int x0, int size,
                                            const ScreenMap& map) {
  const int height = std::min(size, rows.n), width = std::min(size, rows.width_px - x0);
  TileFit<kShapeHarmonics.size()> fit(rows, x0, width, height, map, kShapeHarmonics);
  if (!fit.solve(map, {x0 + width / 2.0, rows.first + height / 2.0}, kShapeHarmonics) ||
      !(fit.solution(0, 3) > 1e-3))
    return std::nullopt;
  ShapeTile tile{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto a = fit.solution.col(static_cast<Eigen::Index>(c));
    tile.amplitude[c][0] = a(0);
    for (std::size_t h = 0; h < kShapeHarmonics.size(); ++h)
      tile.amplitude[c][h + 1] = 0.5 * a(static_cast<Eigen::Index>(3 + 2 * h));
  }
  return tile;
}

}  // namespace reseau
