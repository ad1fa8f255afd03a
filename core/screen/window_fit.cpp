#include "core/screen/window_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace reseau {
namespace {

using Complex = std::complex<double>;
constexpr int kTerms = 1 + 2 * kSeries;
using Vector = Eigen::Matrix<Complex, kTerms, 1>;
using Matrix = Eigen::Matrix<Complex, kTerms, kTerms>;

// Term 0 is the mean; terms 2i + 1 and 2i + 2 are harmonic i and its negative.
constexpr HarmonicIndex term_index(int term) {
  if (term == 0) return {0, 0};
  const HarmonicIndex h = kDifferences[static_cast<std::size_t>((term - 1) / 2)];
  return term % 2 == 1 ? h : HarmonicIndex{-h.u, -h.v};
}

Complex moment_at(const Moments& m, int u, int v) {
  if (u == 0 && v == 0) return m.n0;
  for (std::size_t i = 0; i < kDifferences.size(); ++i) {
    if (kDifferences[i].u == u && kDifferences[i].v == v) return m.n[i];
    if (kDifferences[i].u == -u && kDifferences[i].v == -v) return std::conj(m.n[i]);
  }
  return 0;
}

// Gram matrix of the terms: G(h, k) = sum S^2 conj(E(h)) E(k) = N(k - h).
Matrix gram(const Moments& m) {
  Matrix g;
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j < kTerms; ++j) {
      const HarmonicIndex a = term_index(i), b = term_index(j);
      g(i, j) = moment_at(m, b.u - a.u, b.v - a.v);
    }
  }
  return g;
}

// The stored half of a real series, and the conjugates that complete it.
Vector complete(double mean, const std::array<Complex, kSeries>& harmonics) {
  Vector all;
  all(0) = mean;
  for (int i = 0; i < kSeries; ++i) {
    const Complex value = harmonics[static_cast<std::size_t>(i)];
    all(2 * i + 1) = value;
    all(2 * i + 2) = std::conj(value);
  }
  return all;
}

Vector right_side(const Moments& m, std::size_t channel) {
  return complete(m.r0[channel], m.r[channel]);
}

Vector coefficients(const ColorSeries& series, std::size_t channel) {
  return complete(series.mean[channel], series.harmonic[channel]);
}

}  // namespace

void add_rephased(Moments& window, const Moments& cell, Vec2 shift, double weight) {
  const Complex turn_u = std::polar(1.0, 2 * std::numbers::pi * shift.x);
  const Complex turn_v = std::polar(1.0, 2 * std::numbers::pi * shift.y);
  const std::array<Complex, 5> power_u{1.0 / (turn_u * turn_u), 1.0 / turn_u, 1.0, turn_u,
                                       turn_u * turn_u};
  const std::array<Complex, 5> power_v{1.0 / (turn_v * turn_v), 1.0 / turn_v, 1.0, turn_v,
                                       turn_v * turn_v};
  std::array<Complex, kDifferences.size()> turn;
  for (std::size_t i = 0; i < kDifferences.size(); ++i) {
    const int u = kDifferences[i].u + 2;
    const int v = kDifferences[i].v + 2;
    turn[i] = weight * power_u[static_cast<std::size_t>(u)] * power_v[static_cast<std::size_t>(v)];
    window.n[i] += turn[i] * cell.n[i];
  }
  window.n0 += weight * cell.n0;
  for (std::size_t c = 0; c < 3; ++c) {
    window.r0[c] += weight * cell.r0[c];
    for (std::size_t i = 0; i < kSeries; ++i) window.r[c][i] += std::conj(turn[i]) * cell.r[c][i];
    window.q[c] += weight * cell.q[c];
  }
  window.pixels += weight * cell.pixels;
}

bool fit_series(const Moments& window, ColorSeries& series) {
  if (!(window.n0 > 0)) return false;
  Matrix g = gram(window);
  // A ridge far below any noise keeps areas of a single colour, where some terms coincide,
  // solvable.
  g += Matrix::Identity() * (1e-6 * window.n0);
  const Eigen::LDLT<Matrix> solver(g);
  if (solver.info() != Eigen::Success) return false;
  for (std::size_t c = 0; c < 3; ++c) {
    const Vector a = solver.solve(right_side(window, c));
    if (!a.allFinite()) return false;
    series.mean[c] = a(0).real();
    for (int i = 0; i < kSeries; ++i)
      series.harmonic[c][static_cast<std::size_t>(i)] = a(2 * i + 1);
  }
  return true;
}

Shift fit_shift(const Moments& window, const ColorSeries& series) {
  Shift result;
  if (!(window.n0 > 0) || window.pixels < 64) return result;
  const Matrix g = gram(window);
  Vec2 delta;
  Eigen::Matrix2d info = Eigen::Matrix2d::Zero();
  double modulation = 0, modulation_weight = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    info.setZero();
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    modulation = modulation_weight = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      Vector a = coefficients(series, c);
      // Columns: d/d delta_u, d/d delta_v, the mean, the pattern.
      Eigen::Matrix<Complex, kTerms, 4> columns = Eigen::Matrix<Complex, kTerms, 4>::Zero();
      for (int i = 0; i < kTerms; ++i) {
        const HarmonicIndex h = term_index(i);
        a(i) *= std::polar(1.0, 2 * std::numbers::pi * (h.u * delta.x + h.v * delta.y));
        columns(i, 0) = Complex(0, 2 * std::numbers::pi * h.u) * a(i);
        columns(i, 1) = Complex(0, 2 * std::numbers::pi * h.v) * a(i);
        columns(i, i == 0 ? 2 : 3) = a(i);
      }
      const Vector r = right_side(window, c);
      const Eigen::Matrix<Complex, kTerms, 4> ga = g * columns;
      const Eigen::Matrix4d normal = (columns.adjoint() * ga).real();
      const Eigen::Vector4d right = (columns.adjoint() * r).real();
      // Best mean and contrast at this delta, then what is left for delta.
      Eigen::Matrix2d inner = normal.bottomRightCorner<2, 2>();
      inner += Eigen::Matrix2d::Identity() * (1e-9 * inner.trace());
      const Eigen::Vector2d gains = inner.ldlt().solve(right.tail<2>());
      const double contrast = std::clamp(gains(1), 0.05, 5.0);
      // A colour of the scene alone can imitate no pattern: demand a positive contrast.
      if (!(gains(1) > 0)) continue;
      const double residual = window.q[c] - 2 * gains.dot(right.tail<2>()) +
                              gains.dot(normal.bottomRightCorner<2, 2>() * gains);
      const double variance = std::max(residual, 1e-8 * window.q[c]) / std::max(window.pixels, 1.0);
      if (!(variance > 0)) continue;
      const Eigen::Matrix2d cross = normal.topRightCorner<2, 2>();
      const Eigen::Matrix2d schur =
          normal.topLeftCorner<2, 2>() - cross * inner.ldlt().solve(cross.transpose());
      // Jacobian columns scale with the contrast; the gradient is that of the residual.
      const Eigen::Vector2d g_delta = contrast * (right.head<2>() - cross * gains);
      info += contrast * contrast * schur / variance;
      gradient += g_delta / variance;
      const double weight = normal(3, 3) / variance;
      modulation += weight * gains(1);
      modulation_weight += weight;
    }
    const double trace = info.trace();
    if (!(trace > 0) || !(info.determinant() > 1e-9 * trace * trace)) {
      // One direction is unknown: move along the known one only.
      if (!(trace > 0)) return result;
      info += Eigen::Matrix2d::Identity() * (1e-5 * trace);
    }
    Eigen::Vector2d step = info.ldlt().solve(gradient);
    const double length = step.norm();
    if (!std::isfinite(length)) return Shift{};
    if (length > 0.15) step *= 0.15 / length;
    delta = delta + Vec2{step(0), step(1)};
    if (length < 1e-5) break;
  }
  result.delta = delta;
  result.info_uu = info(0, 0);
  result.info_uv = info(0, 1);
  result.info_vv = info(1, 1);
  result.modulation = modulation_weight > 0 ? modulation / modulation_weight : 0;
  return result;
}

}  // namespace reseau
