#include "calibration/edge/mean_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

using std::numbers::pi;

// Positions: sixteenths of a pixel up to 8, quarters beyond.
constexpr int kPerPixel = 16;
constexpr int kFineEnd = 8 * kPerPixel;
constexpr int kCoarseStep = 4;
constexpr double kHighest = 8;
// The straight slope of M at frequency 0 (a lens) is carried by -slope f exp(-kDecay f), whose
// profile is known in closed form; what remains falls off fast enough to be summed.
constexpr double kDecay = 10;

class SineTable {
 public:
  explicit SineTable(int n) : n_(n), values_(static_cast<std::size_t>(n)) {
    for (int i = 0; i < n; ++i) {
      values_[static_cast<std::size_t>(i)] = {std::sin(2 * pi * i / n), std::cos(2 * pi * i / n)};
    }
  }
  struct Pair {
    double sine, cosine;
  };
  [[nodiscard]] int size() const { return n_; }
  [[nodiscard]] const Pair& operator[](unsigned i) const { return values_[i]; }

 private:
  int n_;
  std::vector<Pair> values_;
};

struct Terms {
  std::size_t n = 0;
  std::vector<double> value, slope;  // [frequency][column]
};

// Sums of sines and cosines at position `step` sixteenths of a pixel; `Columns` known when compiled
// so that the loop is unrolled.
template <std::size_t Columns>
void sum_terms(const Terms& terms, const SineTable& table, unsigned step, double* out) {
  std::array<double, Columns> value{}, slope{};
  const unsigned mask = static_cast<unsigned>(table.size()) - 1;
  unsigned phase = 0;
  for (std::size_t k = 0; k < terms.n; ++k) {
    const SineTable::Pair& p = table[phase];
    const double* v = &terms.value[k * Columns];
    const double* s = &terms.slope[k * Columns];
    for (std::size_t c = 0; c < Columns; ++c) {
      value[c] += v[c] * p.sine;
      slope[c] += s[c] * p.cosine;
    }
    phase = (phase + step) & mask;
  }
  for (std::size_t c = 0; c < Columns; ++c) {
    out[2 * c] = value[c];
    out[2 * c + 1] = slope[c];
  }
}

using SumFunction = void (*)(const Terms&, const SineTable&, unsigned, double*);
constexpr std::array<SumFunction, MeanProfile::kMost> kSums = {
    sum_terms<1>, sum_terms<2>, sum_terms<3>, sum_terms<4>, sum_terms<5>,
    sum_terms<6>, sum_terms<7>, sum_terms<8>, sum_terms<9>};

const SineTable& table_for(int period_px) {
  static const SineTable narrow(128 * kPerPixel), middle(256 * kPerPixel), wide(512 * kPerPixel);
  return period_px == 128 ? narrow : period_px == 256 ? middle : wide;
}

}  // namespace

MeanProfile::MeanProfile(const EdgeOptics& optics, const NormalCosines& normal, double reach_px,
                         std::span<const int> parameters)
    : columns_(1 + parameters.size()), reach_px_(reach_px) {
  CHECK(reach_px > 0 && reach_px <= 100 && columns_ <= kMost);
  const int period_px = reach_px <= 40 ? 128 : reach_px <= 80 ? 256 : 512;
  const SineTable& sines = table_for(period_px);
  const double df = 1.0 / period_px;
  const double top = std::max(2.0, highest_frequency(optics, kHighest));

  // Slope of M at 0 and its derivatives.
  std::array<double, kMost> fall{};
  fall[0] = 4 / pi * optics.diffraction_px * (1 - optics.halo);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i] == kDiffraction) fall[1 + i] = 4 / pi * (1 - optics.halo);
    if (parameters[i] == kHalo) fall[1 + i] = -4 / pi * optics.diffraction_px;
  }

  Terms terms;
  terms.n = static_cast<std::size_t>(top * period_px) + 1;
  terms.value.resize(terms.n * columns_);
  terms.slope.resize(terms.n * columns_);
  std::array<double, kMost> m{};
  for (std::size_t k = 0; k < terms.n; ++k) {
    const double f = df * double(k);
    transfer(optics, normal, f, parameters, std::span(m).first(columns_));
    const double carried = f * std::exp(-kDecay * f);
    for (std::size_t c = 0; c < columns_; ++c) {
      const double rest = m[c] + fall[c] * carried;
      terms.value[k * columns_ + c] = k == 0 ? 0 : df * rest / (pi * f);
      terms.slope[k * columns_ + c] = k == 0 ? df * rest : 2 * df * rest;
    }
  }

  const int last = static_cast<int>(std::ceil(reach_px)) * kPerPixel + kCoarseStep;
  const std::size_t n_rows =
      last <= kFineEnd ? static_cast<std::size_t>(last) + 1
                       : static_cast<std::size_t>(kFineEnd + (last - kFineEnd) / kCoarseStep + 1);
  table_.resize(n_rows * columns_ * 2);
  for (std::size_t row = 0; row < n_rows; ++row) {
    const int step = row <= kFineEnd ? static_cast<int>(row)
                                     : kFineEnd + (static_cast<int>(row) - kFineEnd) * kCoarseStep;
    double* out = &table_[row * columns_ * 2];
    kSums[columns_ - 1](terms, sines, static_cast<unsigned>(step), out);
    const double d = double(step) / kPerPixel;
    const double w = kDecay * kDecay + 4 * pi * pi * d * d;
    for (std::size_t c = 0; c < columns_; ++c) {
      // The sum leaves out its term of frequency 0.
      if (c == 0) out[0] += df * d;
      out[2 * c] -= fall[c] * 2 * d / w;
      out[2 * c + 1] -= fall[c] * (2 / w - 16 * pi * pi * d * d / (w * w));
    }
    out[0] += 0.5;
  }
}

MeanProfile::Cell MeanProfile::cell(double d) const {
  const double at = std::min(std::abs(d), reach_px_) * kPerPixel;
  if (at < kFineEnd) {
    const auto left = static_cast<std::size_t>(at);
    return {left, 1.0 / kPerPixel, at - double(left)};
  }
  const double coarse = (at - kFineEnd) / kCoarseStep;
  const auto left = static_cast<std::size_t>(coarse);
  return {left + kFineEnd, double(kCoarseStep) / kPerPixel, coarse - double(left)};
}

MeanProfile::At MeanProfile::at(double d) const {
  const Cell c = cell(d);
  const double* a = &table_[c.left * columns_ * 2];
  const double* b = a + columns_ * 2;
  const double t = c.t, u = 1 - t;
  const double h00 = (1 + 2 * t) * u * u, h01 = t * t * (3 - 2 * t);
  const double h10 = t * u * u * c.step, h11 = -t * t * u * c.step;
  At out;
  const double value = h00 * a[0] + h01 * b[0] + h10 * a[1] + h11 * b[1];
  out.value = d >= 0 ? value : 1 - value;
  out.slope = 6 * t * u * (b[0] - a[0]) / c.step + u * (1 - 3 * t) * a[1] + t * (3 * t - 2) * b[1];
  const double sign = d >= 0 ? 1 : -1;
  for (std::size_t p = 1; p < columns_; ++p) {
    out.by_parameter[p - 1] =
        sign * (h00 * a[2 * p] + h01 * b[2 * p] + h10 * a[2 * p + 1] + h11 * b[2 * p + 1]);
  }
  return out;
}

double MeanProfile::value(double d, std::span<const double> shift) const {
  const Cell c = cell(d);
  const double* a = &table_[c.left * columns_ * 2];
  const double* b = a + columns_ * 2;
  const double t = c.t, u = 1 - t;
  const double h00 = (1 + 2 * t) * u * u, h01 = t * t * (3 - 2 * t);
  const double h10 = t * u * u * c.step, h11 = -t * t * u * c.step;
  double value = h00 * a[0] + h01 * b[0] + h10 * a[1] + h11 * b[1];
  for (std::size_t p = 0; p < shift.size(); ++p) {
    const double* x = a + 2 * (p + 1);
    const double* y = b + 2 * (p + 1);
    value += shift[p] * (h00 * x[0] + h01 * y[0] + h10 * x[1] + h11 * y[1]);
  }
  return d >= 0 ? value : 1 - value;
}

double MeanProfile::slope(double d, std::span<const double> shift) const {
  const Cell c = cell(d);
  const double* a = &table_[c.left * columns_ * 2];
  const double* b = a + columns_ * 2;
  const double t = c.t, u = 1 - t;
  const double by_value = 6 * t * u / c.step, left = u * (1 - 3 * t), right = t * (3 * t - 2);
  double slope = by_value * (b[0] - a[0]) + left * a[1] + right * b[1];
  for (std::size_t p = 0; p < shift.size(); ++p) {
    const double* x = a + 2 * (p + 1);
    const double* y = b + 2 * (p + 1);
    slope += shift[p] * (by_value * (y[0] - x[0]) + left * x[1] + right * y[1]);
  }
  return slope;
}

}  // namespace reseau
