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

namespace {

// Complex numbers without the library's care for infinities, which costs more than the arithmetic.
struct Fast {
  double re = 0, im = 0;
};
Fast fast(Complex z) { return {z.real(), z.imag()}; }
Fast operator*(Fast a, Fast b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
Fast operator+(Fast a, Fast b) { return {a.re + b.re, a.im + b.im}; }
double real_product(Fast a, Fast b) { return a.re * b.re + a.im * b.im; }  // Re(conj(a) b)

constexpr std::size_t kHalf = 1 + kSeries;  // the mean and the stored half of the harmonics
using HalfRow = std::array<Fast, kHalf>;

// Of two real series, given by their halves: Re(a^H b).
double inner(const HalfRow& a, const HalfRow& b) {
  double sum = 0.5 * real_product(a[0], b[0]);
  for (std::size_t i = 1; i < kHalf; ++i) sum += real_product(a[i], b[i]);
  return 2 * sum;
}

// Upper half of the Gram matrix's rows: what the mean and the stored harmonics have in common with
// all terms.
struct HalfGram {
  std::array<std::array<Fast, kTerms>, kHalf> entry;
  explicit HalfGram(const Moments& m) {
    for (std::size_t i = 0; i < kHalf; ++i) {
      const std::size_t row = i == 0 ? 0 : 2 * i - 1;
      for (std::size_t j = 0; j < kTerms; ++j) entry[i][j] = fast(moment_at(m, kPlaces[row][j]));
    }
  }
  [[nodiscard]] HalfRow times(const HalfRow& a) const {
    HalfRow out;
    for (std::size_t i = 0; i < kHalf; ++i) {
      Fast sum = entry[i][0] * a[0];
      for (std::size_t k = 1; k < kHalf; ++k) {
        sum = sum + entry[i][2 * k - 1] * a[k] + entry[i][2 * k] * Fast{a[k].re, -a[k].im};
      }
      out[i] = sum;
    }
    return out;
  }
};

}  // namespace

Shift fit_shift(const Moments& window, const ColorSeries& series) {
  Shift result;
  if (!(window.n0 > 0) || window.pixels < 24) return result;
  const HalfGram gram_half(window);
  Vec2 delta;
  double uu = 0, uv = 0, vv = 0;
  double modulation = 0, modulation_weight = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    uu = uv = vv = 0;
    double gradient_u = 0, gradient_v = 0;
    modulation = modulation_weight = 0;
    std::array<Fast, kSeries> turn;
    for (std::size_t i = 0; i < kSeries; ++i) {
      const double angle =
          2 * std::numbers::pi * (kDifferences[i].u * delta.x + kDifferences[i].v * delta.y);
      turn[i] = {std::cos(angle), std::sin(angle)};
    }
    for (std::size_t c = 0; c < 3; ++c) {
      // Columns: d/d delta_u, d/d delta_v, the mean, the pattern.
      HalfRow right{}, along_u{}, along_v{}, mean{}, pattern{};
      right[0] = {window.r0[c], 0};
      mean[0] = {series.mean[c], 0};
      for (std::size_t i = 0; i < kSeries; ++i) {
        right[i + 1] = fast(window.r[c][i]);
        const Fast a = fast(series.harmonic[c][i]) * turn[i];
        pattern[i + 1] = a;
        const double ku = 2 * std::numbers::pi * kDifferences[i].u;
        const double kv = 2 * std::numbers::pi * kDifferences[i].v;
        along_u[i + 1] = {-ku * a.im, ku * a.re};
        along_v[i + 1] = {-kv * a.im, kv * a.re};
      }
      const HalfRow g_mean = gram_half.times(mean), g_pattern = gram_half.times(pattern);
      const HalfRow g_u = gram_half.times(along_u), g_v = gram_half.times(along_v);
      const double mm = inner(mean, g_mean), mp = inner(mean, g_pattern);
      const double pp = inner(pattern, g_pattern);
      const double rm = inner(mean, right), rp = inner(pattern, right);
      const double um = inner(mean, g_u), up = inner(pattern, g_u);
      const double vm = inner(mean, g_v), vp = inner(pattern, g_v);
      const double ru = inner(along_u, right), rv = inner(along_v, right);
      // Best mean and contrast at this delta, then what is left for delta.
      const double ridge = 1e-9 * (mm + pp);
      const double a = mm + ridge, b = mp, d = pp + ridge;
      const double determinant = a * d - b * b;
      if (!(determinant > 0)) continue;
      const auto solve = [&](double x, double y) {
        return std::array<double, 2>{(d * x - b * y) / determinant, (a * y - b * x) / determinant};
      };
      const auto gains = solve(rm, rp);
      // A colour of the scene alone can imitate no pattern: demand a positive contrast.
      if (!(gains[1] > 0)) continue;
      const double contrast = std::clamp(gains[1], 0.05, 5.0);
      const double left = window.q[c] - (gains[0] * rm + gains[1] * rp);
      const double variance = std::max(left, 1e-9 * window.q[c]) / std::max(window.pixels - 6, 8.0);
      if (!(variance > 0)) continue;
      const auto from_u = solve(um, up), from_v = solve(vm, vp);
      const double weight = contrast * contrast / variance;
      uu += weight * (inner(along_u, g_u) - (um * from_u[0] + up * from_u[1]));
      uv += weight * (inner(along_u, g_v) - (um * from_v[0] + up * from_v[1]));
      vv += weight * (inner(along_v, g_v) - (vm * from_v[0] + vp * from_v[1]));
      gradient_u += contrast / variance * (ru - (um * gains[0] + up * gains[1]));
      gradient_v += contrast / variance * (rv - (vm * gains[0] + vp * gains[1]));
      modulation += pp / variance * gains[1];
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
