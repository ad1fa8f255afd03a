#include "core/screen/window_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace reseau {
namespace {

using Complex = std::complex<double>;
constexpr int kTerms = 1 + 2 * kSeries;
// Holds even terms that a window does not determine [of its light].
constexpr double kEvenRidge = 1e-3;
using Vector = Eigen::Matrix<Complex, kTerms, 1>;
using Matrix = Eigen::Matrix<Complex, kTerms, kTerms>;

// Term 0 is the mean; terms 2i + 1 and 2i + 2 are harmonic i and its negative.
constexpr HarmonicIndex term_index(int term) {
  if (term == 0) return {0, 0};
  const HarmonicIndex h = kDifferences[static_cast<std::size_t>((term - 1) / 2)];
  return term % 2 == 1 ? h : HarmonicIndex{-h.u, -h.v};
}

// Where the moment of a difference of two terms stands: 0 is N(0), +-(i + 1) N(kDifferences[i]) or
// its conjugate.
constexpr int moment_place(int u, int v) {
  if (u == 0 && v == 0) return 0;
  for (int i = 0; i < static_cast<int>(kDifferences.size()); ++i) {
    const HarmonicIndex d = kDifferences[static_cast<std::size_t>(i)];
    if (d.u == u && d.v == v) return i + 1;
    if (d.u == -u && d.v == -v) return -(i + 1);
  }
  return 0;
}

using PlaceTable = std::array<std::array<int, kTerms>, kTerms>;
constexpr PlaceTable make_places() {
  PlaceTable table{};
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j < kTerms; ++j) {
      const HarmonicIndex a = term_index(i), b = term_index(j);
      table[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
          moment_place(b.u - a.u, b.v - a.v);
    }
  }
  return table;
}
constexpr PlaceTable kPlaces = make_places();

Complex moment_at(const Moments& m, int place) {
  if (place == 0) return m.n0;
  const Complex value = m.n[static_cast<std::size_t>(std::abs(place) - 1)];
  return place > 0 ? value : std::conj(value);
}

// Gram matrix of the terms: G(h, k) = sum S^2 conj(E(h)) E(k) = N(k - h).
Matrix gram(const Moments& m) {
  Matrix g;
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j < kTerms; ++j) {
      g(i, j) = moment_at(m, kPlaces[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
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

namespace {

// Of lines alone: the mean and two harmonics, the first five terms.
constexpr int kLineTerms = 5;
using LineVector = Eigen::Matrix<Complex, kLineTerms, 1>;
using LineMatrix = Eigen::Matrix<Complex, kLineTerms, kLineTerms>;

constexpr std::array<int, kLineTerms> kLineOrder{0, 2, -2, 1, -1};

bool fit_lines_series(const Moments& window, const Matrix& g, ColorSeries& series) {
  const Eigen::LDLT<LineMatrix> solver(g.topLeftCorner<kLineTerms, kLineTerms>());
  if (solver.info() != Eigen::Success) return false;
  for (std::size_t c = 0; c < 3; ++c) {
    const LineVector a = solver.solve(LineVector(right_side(window, c).head<kLineTerms>()));
    if (!a.allFinite()) return false;
    series.mean[c] = a(0).real();
    series.harmonic[c] = {a(1), a(3), 0, 0};
  }
  return true;
}

// Gauss-Newton on the shift of lines across themselves, the mean and the contrast of each channel
// free.
Shift fit_lines_shift(const Moments& window, const ColorSeries& series) {
  const LineMatrix g = gram(window).topLeftCorner<kLineTerms, kLineTerms>();
  const auto product = [&](const LineVector& a, const LineVector& b) {
    return a.dot(g * b).real();
  };
  Shift result;
  double delta = 0, info = 0, modulation = 0, modulation_weight = 0;
  for (int iteration = 0; iteration < 10; ++iteration) {
    double gradient = 0;
    info = modulation = modulation_weight = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      LineVector level = LineVector::Zero(), pattern = LineVector::Zero(),
                 along = LineVector::Zero();
      level(0) = series.mean[c];
      for (int i = 1; i < kLineTerms; ++i) {
        const int h = kLineOrder[static_cast<std::size_t>(i)];
        const Complex a = series.harmonic[c][std::abs(h) == 1 ? 1 : 0];
        const Complex turn = 2 * std::numbers::pi * h * Complex(0, 1);
        pattern(i) = (h > 0 ? a : std::conj(a)) * std::exp(turn * delta);
        along(i) = turn * pattern(i);
      }
      const LineVector right = right_side(window, c).head<kLineTerms>();
      const double ll = product(level, level), lp = product(level, pattern),
                   pp = product(pattern, pattern);
      const double rl = level.dot(right).real(), rp = pattern.dot(right).real();
      const double ridge = 1e-9 * (ll + pp);
      const double determinant = (ll + ridge) * (pp + ridge) - lp * lp;
      if (!(determinant > 0)) continue;
      const double mean = ((pp + ridge) * rl - lp * rp) / determinant;
      const double gain = ((ll + ridge) * rp - lp * rl) / determinant;
      if (!(gain > 0)) continue;
      const double contrast = std::clamp(gain, 0.05, 5.0);
      const double left = window.q[c] - mean * rl - gain * rp;
      const double variance = std::max(left, 1e-9 * window.q[c]) / std::max(window.pixels - 5, 8.0);
      if (!(variance > 0)) continue;
      const double la = product(level, along), pa = product(pattern, along);
      const double level_part = ((pp + ridge) * la - lp * pa) / determinant,
                   pattern_part = ((ll + ridge) * pa - lp * la) / determinant;
      const double free = product(along, along) - level_part * la - pattern_part * pa;
      const LineVector rest = right - g * (mean * level + gain * pattern);
      info += contrast * contrast / variance * std::max(free, 0.0);
      gradient += contrast / variance * along.dot(rest).real();
      modulation += pp / variance * gain;
      modulation_weight += pp / variance;
    }
    if (!(info > 0) || !std::isfinite(info)) return Shift{};
    const double step = std::clamp(gradient / info, -0.1, 0.1);
    if (!std::isfinite(step)) return Shift{};
    delta += step;
    if (std::abs(step) < 1e-5) break;
  }
  result.delta = {0, delta};
  result.info_vv = info;
  result.modulation = modulation_weight > 0 ? modulation / modulation_weight : 0;
  return result;
}

}  // namespace

bool fit_series(const Moments& window, ColorSeries& series) {
  if (!(window.n0 > 0)) return false;
  Matrix g = gram(window);
  // A ridge far below any noise keeps areas of a single colour, where some terms coincide,
  // solvable.
  g += Matrix::Identity() * (1e-6 * window.n0);
  if (series.lines) return fit_lines_series(window, g, series);
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

namespace {

constexpr int kEven = 1 + kSeries, kOdd = kSeries;
using Even = Eigen::Matrix<double, kEven, 1>;
using Odd = Eigen::Matrix<double, kOdd, 1>;

// Normal equations of the real terms of a window once the map has moved by delta: even ones (the
// mean and a cosine per harmonic) and odd ones (a sine per harmonic).
struct RealTerms {
  Eigen::Matrix<double, kEven, kEven> even;
  Eigen::Matrix<double, kEven, kOdd> cross;
  Eigen::Matrix<double, kOdd, kOdd> odd;
  std::array<Even, 3> right_even;
  std::array<Odd, 3> right_odd;

  RealTerms(const Moments& m, Vec2 delta) {
    // A term h stands for 2 Re(z E(h)): z = turn for the cosine, i turn for the sine.
    std::array<Complex, kSeries> turn;
    for (std::size_t i = 0; i < kSeries; ++i) {
      turn[i] = std::polar(
          1.0, 2 * std::numbers::pi * (kDifferences[i].u * delta.x + kDifferences[i].v * delta.y));
    }
    const auto place = [&](std::size_t i, std::size_t j) { return moment_at(m, kPlaces[i][j]); };
    even(0, 0) = m.n0;
    for (std::size_t i = 0; i < kSeries; ++i) {
      const auto row = static_cast<int>(i);
      const Complex to_mean = 2.0 * turn[i] * place(0, 2 * i + 1);
      even(0, row + 1) = even(row + 1, 0) = to_mean.real();
      cross(0, row) = -to_mean.imag();
      for (std::size_t j = 0; j < kSeries; ++j) {
        const auto column = static_cast<int>(j);
        // sum S^2 of 2 Re(a E(h)) 2 Re(b E(k)) = 2 Re(conj(a) b N(k - h) + conj(a) conj(b)
        // N(-k-h)).
        const Complex minus = 2.0 * std::conj(turn[i]) * turn[j] * place(2 * i + 1, 2 * j + 1);
        const Complex plus =
            2.0 * std::conj(turn[i]) * std::conj(turn[j]) * place(2 * i + 1, 2 * j + 2);
        even(row + 1, column + 1) = minus.real() + plus.real();
        cross(row + 1, column) = -minus.imag() + plus.imag();
        odd(row, column) = minus.real() - plus.real();
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      right_even[c](0) = m.r0[c];
      for (std::size_t i = 0; i < kSeries; ++i) {
        const Complex r = 2.0 * std::conj(turn[i]) * m.r[c][i];
        right_even[c](static_cast<int>(i) + 1) = r.real();
        right_odd[c](static_cast<int>(i)) = r.imag();
      }
    }
  }
};

}  // namespace

Shift fit_shift(const Moments& window, const ColorSeries& series) {
  Shift result;
  if (!(window.n0 > 0) || window.pixels < 24) return result;
  if (series.lines) return fit_lines_shift(window, series);
  Vec2 delta;
  double uu = 0, uv = 0, vv = 0;
  double modulation = 0, modulation_weight = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    uu = uv = vv = 0;
    double gradient_u = 0, gradient_v = 0;
    modulation = modulation_weight = 0;
    const RealTerms terms(window, delta);
    // What the even terms can take is not for delta: where colours are saturated the silver under
    // the pattern repeats with it, and blur then makes of the pattern more than its contrast says.
    Eigen::Matrix<double, kEven, kEven> even = terms.even;
    even.diagonal().array() += kEvenRidge * window.n0;
    const Eigen::LDLT<Eigen::Matrix<double, kEven, kEven>> solver(even);
    const Eigen::Matrix<double, kEven, kOdd> taken = solver.solve(terms.cross);
    const Eigen::Matrix<double, kOdd, kOdd> odd = terms.odd - terms.cross.transpose() * taken;
    for (std::size_t c = 0; c < 3; ++c) {
      Even pattern;
      Odd along_u, along_v;
      pattern(0) = 0;
      for (int i = 0; i < kSeries; ++i) {
        const auto h = static_cast<std::size_t>(i);
        const double a = series.harmonic[c][h].real();
        pattern(i + 1) = a;
        along_u(i) = 2 * std::numbers::pi * kDifferences[h].u * a;
        along_v(i) = 2 * std::numbers::pi * kDifferences[h].v * a;
      }
      // The expected pattern's mean and contrast first; the even terms are drawn towards them.
      const double mm = series.mean[c] * series.mean[c] * window.n0;
      const double mp = series.mean[c] * terms.even.row(0).dot(pattern);
      const double pp = pattern.dot(terms.even * pattern);
      const double rm = series.mean[c] * terms.right_even[c](0);
      const double rp = pattern.dot(terms.right_even[c]);
      const double ridge = 1e-9 * (mm + pp);
      const double determinant = (mm + ridge) * (pp + ridge) - mp * mp;
      if (!(determinant > 0)) continue;
      const double gain_mean = ((pp + ridge) * rm - mp * rp) / determinant;
      const double gain = ((mm + ridge) * rp - mp * rm) / determinant;
      // A colour of the scene alone can imitate no pattern: demand a positive contrast.
      if (!(gain > 0)) continue;
      const double contrast = std::clamp(gain, 0.05, 5.0);
      Even start = gain * pattern;
      start(0) = gain_mean * series.mean[c];
      const Even rest = terms.right_even[c] - terms.even * start;
      const Even more = solver.solve(rest);
      const double left = window.q[c] - gain_mean * rm - gain * rp - more.dot(rest);
      const double variance = std::max(left, 1e-9 * window.q[c]) / std::max(window.pixels - 9, 8.0);
      if (!(variance > 0)) continue;
      const Odd right = terms.right_odd[c] - terms.cross.transpose() * (start + more);
      const double weight = contrast * contrast / variance;
      uu += weight * along_u.dot(odd * along_u);
      uv += weight * along_u.dot(odd * along_v);
      vv += weight * along_v.dot(odd * along_v);
      gradient_u += contrast / variance * along_u.dot(right);
      gradient_v += contrast / variance * along_v.dot(right);
      modulation += pp / variance * gain;
      modulation_weight += pp / variance;
    }
    const double trace = uu + vv;
    if (!(trace > 0) || !std::isfinite(trace)) return Shift{};
    if (!(uu * vv - uv * uv > 1e-9 * trace * trace)) {
      // One direction is unknown: move along the known one only.
      uu += 1e-5 * trace;
      vv += 1e-5 * trace;
    }
    const double determinant = uu * vv - uv * uv;
    Vec2 step{(vv * gradient_u - uv * gradient_v) / determinant,
              (uu * gradient_v - uv * gradient_u) / determinant};
    const double length = norm(step);
    if (!std::isfinite(length)) return Shift{};
    if (length > 0.15) step = (0.15 / length) * step;
    delta = delta + step;
    if (length < 2e-4) break;
  }
  result.delta = delta;
  result.info_uu = uu;
  result.info_uv = uv;
  result.info_vv = vv;
  result.modulation = modulation_weight > 0 ? modulation / modulation_weight : 0;
  return result;
}

}  // namespace reseau
