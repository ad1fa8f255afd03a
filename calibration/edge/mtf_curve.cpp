#include "calibration/edge/mtf_curve.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace reseau {
namespace {

constexpr int kPoints = 101;

// H(f) of one member and the derivatives of its parts by beta.
class MemberTransfer {
 public:
  MemberTransfer(const ProfileFit& fit, const ProfileMember& member)
      : fit_(fit), member_(member), real_(member.beta.size()), imaginary_(member.beta.size()) {}

  std::complex<double> at(double f) {
    std::array<double, 1 + kOpticsParameters> m{};
    const auto& parameters = fit_.parameters();
    transfer(fit_.optics(), fit_.options().normal, f, parameters,
             std::span(m).first(1 + parameters.size()));
    std::complex<double> sum = m[0];
    std::fill(real_.begin(), real_.end(), 0.0);
    std::fill(imaginary_.begin(), imaginary_.end(), 0.0);
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      real_[2 + k] = m[1 + k];
      sum += m[1 + k] * member_.beta[2 + k];
    }
    if (member_.tau > 0) {
      const std::size_t first = fit_.first_spline(member_);
      fit_.spline().transform(f, std::span(real_).subspan(first),
                              std::span(imaginary_).subspan(first));
      double re = 0, im = 0;
      for (std::size_t i = first; i < real_.size(); ++i) {
        re += real_[i] * member_.beta[i];
        im += imaginary_[i] * member_.beta[i];
      }
      sum += std::complex<double>(re, im);
    }
    return sum;
  }
  [[nodiscard]] std::span<const double> real() const { return real_; }
  [[nodiscard]] std::span<const double> imaginary() const { return imaginary_; }

 private:
  const ProfileFit& fit_;
  const ProfileMember& member_;
  std::vector<double> real_, imaginary_;
};

// The average over the members at any frequency.
class AverageTransfer {
 public:
  explicit AverageTransfer(const ProfileFit& fit) : fit_(fit) {
    for (const ProfileMember& m : fit.members()) members_.emplace_back(fit, m);
  }
  std::complex<double> at(double f) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      sum += fit_.members()[i].weight * members_[i].at(f);
    }
    return sum;
  }
  MemberTransfer& member(std::size_t i) { return members_[i]; }

 private:
  const ProfileFit& fit_;
  std::vector<MemberTransfer> members_;
};

double modulus(std::complex<double> h, double imaginary_variance) {
  const double im2 = std::max(0.0, h.imag() * h.imag() - imaginary_variance);
  return std::sqrt(h.real() * h.real() + im2);
}

// First fall below `level`, refined on `curve`, which is exact at any frequency.
template <typename Curve>
std::optional<MtfCrossing> crossing(std::span<const MtfPoint> points, double level, Curve curve) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (!(points[i].value < level && points[i - 1].value >= level)) continue;
    double a = points[i - 1].f_cy_per_px, b = points[i].f_cy_per_px;
    double va = points[i - 1].value, vb = points[i].value;
    double f = a;
    for (int round = 0; round < 6; ++round) {
      f = a + (b - a) * (va - level) / (va - vb);
      const double v = curve(f);
      if (std::abs(v - level) < 1e-9) break;
      if (v > level) {
        a = f;
        va = v;
      } else {
        b = f;
        vb = v;
      }
      if (!(va > vb)) break;
    }
    const double h = 0.25 * kMtfStepCyPerPx;
    const double slope = (curve(f + h) - curve(std::max(0.0, f - h))) / (f >= h ? 2 * h : f + h);
    if (!(slope < -1e-6)) return std::nullopt;
    const double t = (f - points[i - 1].f_cy_per_px) / kMtfStepCyPerPx;
    const double sd = points[i - 1].sd + t * (points[i].sd - points[i - 1].sd);
    return MtfCrossing{f, sd / -slope};
  }
  return std::nullopt;
}

template <typename Curve>
void find_crossings(MtfCurve& out, Curve curve) {
  out.mtf50 = crossing(out.points, 0.5, curve);
  out.mtf30 = crossing(out.points, 0.3, curve);
  out.mtf10 = crossing(out.points, 0.1, curve);
}

// Variance of white noise in H, and how much more the lines of pixels really show.
struct Spread {
  std::vector<double> ratio = std::vector<double>(kPoints, 1.0);
  double correlation = 0;
};

Spread spread_of(const ProfileFit& fit, std::span<const ProfileSample> samples,
                 AverageTransfer& transfer) {
  Spread out;
  const ProfileMember& m = fit.best();
  const std::size_t p = m.beta.size();
  const double precision = 1 / (fit.noise() * fit.noise());
  // Scores of every line.
  std::vector<double> scores;
  std::size_t n_lines = 0;
  int line = 0;
  for (const ProfileSample& s : samples) {
    if (n_lines == 0 || s.line != line) {
      line = s.line;
      ++n_lines;
      scores.resize(n_lines * p, 0.0);
    }
    const ProfileFit::Row row = fit.row(s.distance, m);
    double rest = s.value - row.mean;
    const std::size_t first = fit.first_spline(m);
    for (std::size_t i = 0; i < row.n_dense; ++i) rest -= row.dense[i] * m.beta[i];
    for (std::size_t i = 0; i < row.spline.count; ++i) {
      rest -= row.spline.value[i] * m.beta[first + row.spline.first + i];
    }
    double* g = &scores[(n_lines - 1) * p];
    const double w = s.weight * rest * precision;
    for (std::size_t i = 0; i < row.n_dense; ++i) g[i] += w * row.dense[i];
    for (std::size_t i = 0; i < row.spline.count; ++i) {
      g[first + row.spline.first + i] += w * row.spline.value[i];
    }
  }
  if (n_lines < 3) return out;

  std::vector<double> a(p), pa(p), u(n_lines);
  std::array<double, 6> lagged{};
  const double n = double(n_lines);
  for (int k = 1; k < kPoints; ++k) {
    MemberTransfer& t = transfer.member(0);
    (void)t.at(k * kMtfStepCyPerPx);
    a.assign(t.real().begin(), t.real().end());
    m.precision->solve(a);
    fit.prior_times(m, a, pa);
    const double white = dot(a, t.real()) - dot(a, pa);
    for (std::size_t i = 0; i < n_lines; ++i) {
      u[i] = dot(a, {&scores[i * p], p});
    }
    const double found = dot(u, u) * n / (n - 1);
    if (!(white > 0)) continue;
    // A few lines cannot tell much about their own spread.
    constexpr double kPrior = 12;
    out.ratio[static_cast<std::size_t>(k)] = (n * found / white + kPrior) / (n + kPrior);
    if (k % 8 == 4 && k < 64 && found > 0) {
      for (std::size_t lag = 0; lag < lagged.size(); ++lag) {
        double sum = 0;
        for (std::size_t i = lag; i < n_lines; ++i) sum += u[i] * u[i - lag];
        lagged[lag] += sum / found;
      }
    }
  }
  if (lagged[0] > 0 && n_lines >= 8) {
    double factor = 1;
    for (std::size_t lag = 1; lag < lagged.size(); ++lag) {
      factor += 2 * (1 - double(lag) / double(lagged.size())) * lagged[lag] / lagged[0];
    }
    out.correlation = lagged[1] / lagged[0];
    factor = (n * factor + 20) / (n + 20);
    for (double& r : out.ratio) r *= std::clamp(factor, 0.9, 10.0);
  }
  out.ratio[0] = out.ratio[1];
  return out;
}

// Light within the window: its line spread on a fine grid.
MtfCurve windowed(const ProfileFit& fit, double window_px, const MtfCurve& all) {
  constexpr int kPerPx = 16;
  const int half = static_cast<int>(window_px * kPerPx);
  std::vector<double> even(static_cast<std::size_t>(half) + 1), odd(even.size());
  double total = 0;
  for (int i = 0; i <= half; ++i) {
    const double d = double(i) / kPerPx;
    const double right = fit.slope(d), left = fit.slope(-d);
    const double w = (i == 0 || i == half) ? 0.5 : 1.0;
    even[static_cast<std::size_t>(i)] = w * (i == 0 ? 2 * 0.5 * (right + left) : right + left);
    odd[static_cast<std::size_t>(i)] = w * (right - left);
    total += even[static_cast<std::size_t>(i)];
  }
  const auto value = [&](double f) {
    double re = 0, im = 0;
    // Rotation by recurrence: exact enough over some hundred steps.
    const std::complex<double> turn = std::polar(1.0, 2 * std::numbers::pi * f / kPerPx);
    std::complex<double> phase = 1;
    for (std::size_t i = 0; i < even.size(); ++i) {
      re += even[i] * phase.real();
      im += odd[i] * phase.imag();
      phase *= turn;
    }
    return std::hypot(re, im) / total;
  };
  MtfCurve out;
  if (!(total > 0)) return out;
  for (const MtfPoint& p : all.points) {
    out.points.push_back({p.f_cy_per_px, value(p.f_cy_per_px), p.sd});
  }
  find_crossings(out, value);
  return out;
}

}  // namespace

MtfOfEdge transfer_of(const ProfileFit& fit, std::span<const ProfileSample> samples,
                      double window_px) {
  MtfOfEdge out;
  AverageTransfer transfer(fit);
  const Spread spread = spread_of(fit, samples, transfer);
  out.line_correlation = spread.correlation;

  const std::size_t n_members = fit.members().size();
  std::vector<double> imaginary_variance(kPoints);
  std::vector<double> a, pa;
  double inflation = 0;
  for (int k = 0; k < kPoints; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double f = k * kMtfStepCyPerPx;
    std::complex<double> mean = 0;
    double real2 = 0, variance = 0, white_variance = 0, im_variance = 0;
    for (std::size_t j = 0; j < n_members; ++j) {
      const ProfileMember& m = fit.members()[j];
      MemberTransfer& t = transfer.member(j);
      const std::complex<double> h = t.at(f);
      a.assign(t.real().begin(), t.real().end());
      m.precision->solve(a);
      pa.resize(a.size());
      fit.prior_times(m, a, pa);
      const double by_prior = dot(a, pa);
      const double white = std::max(0.0, dot(a, t.real()) - by_prior);
      mean += m.weight * h;
      real2 += m.weight * h.real() * h.real();
      variance += m.weight * (by_prior + white * spread.ratio[i]);
      white_variance += m.weight * (by_prior + white);
      if (m.tau > 0 && k > 0) {
        a.assign(t.imaginary().begin(), t.imaginary().end());
        m.precision->forward(a);
        im_variance += m.weight * dot(a, a) * spread.ratio[i];
      }
    }
    const double between = std::max(0.0, real2 - mean.real() * mean.real());
    imaginary_variance[i] = im_variance;
    const double sd = k == 0 ? 0 : std::sqrt(variance + between);
    out.all.points.push_back({f, modulus(mean, im_variance), sd});
    if (k == 25) inflation = std::sqrt((variance + between) / std::max(1e-300, white_variance));
  }
  out.inflation = inflation;
  find_crossings(out.all, [&](double f) {
    const double at = std::min(f / kMtfStepCyPerPx, double(kPoints - 1));
    const auto i = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(kPoints - 2));
    const double t = at - double(i);
    return modulus(transfer.at(f), (1 - t) * imaginary_variance[i] + t * imaginary_variance[i + 1]);
  });
  out.window_px = std::min(window_px, fit.reach_px());
  out.window = windowed(fit, out.window_px, out.all);
  return out;
}

}  // namespace reseau
