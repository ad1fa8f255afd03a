#include "core/reconstruct/screen_tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace reseau {
namespace {
using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;
// 1, x, y (the picture changes across a tile), then cos and sin of each harmonic.
constexpr int kTerms = 3 + 2 * static_cast<int>(kTileHarmonics.size());
using Normal = Eigen::Matrix<double, kTerms, kTerms>;
using Terms = Eigen::Matrix<double, kTerms, 1>;
}  // namespace

ScreenTile measure_screen_tile(const LinearRows& rows, int x0, int size, const ScreenMap& map) {
  ScreenTile tile;
  const int height = std::min(size, rows.n), width = std::min(size, rows.width_px - x0);
  Normal normal = Normal::Zero();
  std::array<Terms, 4> right;
  for (auto& r : right) r.setZero();
  std::array<double, 4> energy{};
  double weight_sum = 0, square_sum = 0;
  int n_lost = 0;
  for (int y = 0; y < height; ++y) {
    const double wy = std::sin(kPi * (y + 0.5) / height);
    for (int x = 0; x < width; ++x) {
      if (!(rows.row(3, y)[x0 + x] > 0)) {
        ++n_lost;
        continue;
      }
      const double wx = std::sin(kPi * (x + 0.5) / width);
      const double window = wx * wx * wy * wy;
      const Vec2 s =
          map.screen_from_scan({static_cast<double>(x0 + x), static_cast<double>(rows.first + y)});
      const Complex u = std::polar(1.0, 2 * kPi * s.x), v = std::polar(1.0, 2 * kPi * s.y);
      const std::array<Complex, kTileHarmonics.size()> turn{u,     v,    u * v, u * std::conj(v),
                                                            u * u, v * v};
      Terms term;
      term(0) = 1;
      term(1) = (x + 0.5) / width - 0.5;
      term(2) = (y + 0.5) / height - 0.5;
      for (std::size_t h = 0; h < turn.size(); ++h) {
        term(static_cast<int>(3 + 2 * h)) = turn[h].real();
        term(static_cast<int>(4 + 2 * h)) = turn[h].imag();
      }
      normal.selfadjointView<Eigen::Lower>().rankUpdate(term, window);
      for (std::size_t c = 0; c < 4; ++c) {
        const double value = static_cast<double>(rows.row(static_cast<int>(c), y)[x0 + x]);
        right[c] += (window * value) * term;
        energy[c] += window * value * value;
      }
      weight_sum += window;
      square_sum += window * window;
    }
  }
  if (n_lost * 20 > width * height || !(square_sum > 0)) return tile;
  const Normal full = normal.selfadjointView<Eigen::Lower>();
  const Eigen::LDLT<Normal> solver(full);
  if (solver.info() != Eigen::Success) return tile;
  tile.n_effective = weight_sum * weight_sum / square_sum;
  if (tile.n_effective < 3 * kTerms) return tile;
  for (std::size_t c = 0; c < 4; ++c) {
    const Terms a = solver.solve(right[c]);
    if (!a.allFinite()) return ScreenTile{};
    tile.amplitude[c][0] = a(0);
    for (int h = 0; h < kTileAmplitudes - 1; ++h) {
      // a cos + b sin of an even pattern: each exponential carries half of a.
      tile.amplitude[c][static_cast<std::size_t>(h + 1)] = 0.5 * a(3 + 2 * h);
      tile.odd[c][static_cast<std::size_t>(h + 1)] = 0.5 * a(4 + 2 * h);
    }
    for (int h = 0; h < 2; ++h) {
      tile.fundamental[c][static_cast<std::size_t>(h)] = 0.5 * Complex(a(3 + 2 * h), -a(4 + 2 * h));
    }
    tile.variance[c] = std::max(energy[c] - a.dot(right[c]), 0.0) / weight_sum;
  }
  tile.used = tile.amplitude[3][0] > 1e-3;
  return tile;
}

Vec2 infrared_shift(const std::vector<ScreenTile>& tiles, const std::array<double, 3>& weights,
                    const Registration& registration) {
  std::array<double, 2> phase{};
  for (std::size_t h = 0; h < 2; ++h) {
    // silver from RGB = rho * infrared + kappa * mean; kappa takes what imperfect weights leave.
    Eigen::Matrix2cd normal = Eigen::Matrix2cd::Zero();
    Eigen::Vector2cd right = Eigen::Vector2cd::Zero();
    double energy = 0;
    int n = 0;
    for (const ScreenTile& tile : tiles) {
      if (!tile.used) continue;
      Complex from_rgb = 0;
      for (std::size_t c = 0; c < 3; ++c) from_rgb += weights[c] * tile.fundamental[c][h];
      const Eigen::Vector2cd row(tile.fundamental[3][h], Complex(tile.amplitude[3][0]));
      normal += row.conjugate() * row.transpose();
      right += row.conjugate() * from_rgb;
      energy += std::norm(from_rgb);
      ++n;
    }
    if (n < 8) return {};
    const double spread = normal.determinant().real() / std::max(normal(1, 1).real(), 1e-30);
    if (!(spread > 1e-9)) return {};
    const Eigen::Vector2cd fit = normal.fullPivLu().solve(right);
    const double residual = std::max(energy - (right.adjoint() * fit)(0).real(), 1e-6 * energy);
    const double sd_cycles = std::sqrt(residual / (n - 2) / spread) / std::abs(fit(0)) / (2 * kPi);
    if (!(sd_cycles * registration.period_px[h] < 0.1)) return {};
    phase[h] = std::arg(fit(0)) / (2 * kPi);
  }
  // RGB shows at p what infrared shows at p + shift: a phase of +f . shift.
  const Vec2 f_u = registration.lattice_cy_per_px[0], f_v = registration.lattice_cy_per_px[1];
  const Vec2 shift = Mat2{f_u.x, f_u.y, f_v.x, f_v.y}.inverse() * Vec2{phase[0], phase[1]};
  return norm(shift) < 1 ? shift : Vec2{};
}

}  // namespace reseau
