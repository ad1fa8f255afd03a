// Samples and transfer function of a spread that is a spline in the target's axes.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <utility>

#include <Eigen/Core>

#include "calibration/random/lens_tails.h"
#include "calibration/random/random_psf_fit.h"
#include "calibration/random/random_target.h"
#include "calibration/random/spline_cells.h"

namespace reseau {
namespace {

using random_target::cubic_spline;
using random_target::cubic_spline_slope;
using random_target::from_middle;

// Value and slopes of the spline, and its rows by knots.
struct At {
  double value = 0, by_u = 0, by_v = 0;
  Eigen::VectorXd row;
};

At spline_at(const RandomPsf::Fit& fit, Vec2 place) {
  const Eigen::Index n = fit.n_knots;
  const double h = fit.step_px, half = -from_middle(0, n);
  At out;
  out.row = Eigen::VectorXd::Zero(n * n);
  const double pu = place.x / h + half, pv = place.y / h + half;
  const auto first_u = static_cast<Eigen::Index>(std::floor(pu)) - 1;
  const auto first_v = static_cast<Eigen::Index>(std::floor(pv)) - 1;
  for (auto j = first_v; j < first_v + 4; ++j) {
    for (auto i = first_u; i < first_u + 4; ++i) {
      if (i < 0 || j < 0 || i >= n || j >= n) continue;
      const double u = pu - static_cast<double>(i), v = pv - static_cast<double>(j);
      const double knot = fit.knots[j * n + i];
      const double w = cubic_spline(u) * cubic_spline(v) / (h * h);
      out.row[j * n + i] = w;
      out.value += knot * w;
      out.by_u += knot * cubic_spline_slope(u) * cubic_spline(v) / (h * h * h);
      out.by_v += knot * cubic_spline(u) * cubic_spline_slope(v) / (h * h * h);
    }
  }
  return out;
}

double sinc(double x) {
  return std::abs(x) < 1e-9 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

// The transfer at a frequency of the scan, and its rows by knots.
struct Wave {
  std::complex<double> value;
  Eigen::VectorXd real, imaginary;

  Wave(const RandomPsf::Fit& fit, Vec2 scan) {
    // A wave of the scan, in the target's axes.
    const Vec2 f = fit.target_from_scan.inverse().transposed() * scan;
    const Eigen::Index n = fit.n_knots;
    const double h = fit.step_px, sum = fit.knots.sum();
    const double spline = std::pow(sinc(h * f.x) * sinc(h * f.y), 4);
    real.resize(n * n);
    imaginary.resize(n * n);
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < n; ++i) {
        const double phase =
            -2 * std::numbers::pi * h * (f.x * from_middle(i, n) + f.y * from_middle(j, n));
        real[j * n + i] = spline * std::cos(phase);
        imaginary[j * n + i] = spline * std::sin(phase);
      }
    }
    value = {real.dot(fit.knots) / sum, imaginary.dot(fit.knots) / sum};
    // The sum of the knots is one as well.
    real = (real.array() - value.real()) / sum;
    imaginary = (imaginary.array() - value.imag()) / sum;
  }
};

}  // namespace

void fill_samples(RandomPsf& out) {
  const RandomPsf::Fit& fit = *out.fit;
  const double contrast = fit.knots.sum(), area = std::abs(fit.target_from_scan.determinant());
  const Eigen::VectorXd to_u =
      (fit.shift_u.array() - fit.shift_u.dot(fit.knots) / contrast) / contrast;
  const Eigen::VectorXd to_v =
      (fit.shift_v.array() - fit.shift_v.dot(fit.knots) / contrast) / contrast;
  const Vec2 middle{fit.shift_u.dot(fit.knots) / contrast, fit.shift_v.dot(fit.knots) / contrast};
  out.side = fit.n_knots;
  out.step_px = fit.step_px;
  double variances = 0, squares = 0;
  for (int y = 0; y < out.side; ++y) {
    for (int x = 0; x < out.side; ++x) {
      const Vec2 scan{from_middle(x, out.side) * out.step_px,
                      from_middle(y, out.side) * out.step_px};
      const At at = spline_at(fit, fit.target_from_scan * scan + middle);
      const double value = at.value / contrast;
      // The sum of the knots and the place of the middle are as unsure as they are.
      const Eigen::VectorXd row = ((at.row.array() - value) / contrast).matrix() +
                                  at.by_u / contrast * to_u + at.by_v / contrast * to_v;
      const double variance = std::max(0.0, row.dot(fit.covariance * row)) * area * area;
      out.psf.push_back(value * area);
      out.sd.push_back(std::sqrt(variance));
      variances += variance;
      squares += value * value * area * area;
    }
  }
  out.relative_sd = squares > 0 ? std::sqrt(variances / squares) : 0;
}

RandomPsf::Point RandomPsf::mtf(double fx, double fy) const {
  if (!fit) return {};
  const Wave wave(*fit, {fx, fy});
  const double modulus = std::abs(wave.value);
  if (!(modulus > 0)) return {};
  const Eigen::VectorXd row =
      wave.value.real() / modulus * wave.real + wave.value.imag() / modulus * wave.imaginary;
  return {modulus, std::sqrt(std::max(0.0, row.dot(fit->covariance * row)))};
}

RandomPsf::Point RandomPsf::mtf_of_all(double fx, double fy) const {
  if (fx == 0 && fy == 0) return {1, 0};
  const Point inside = mtf(fx, fy);
  return {(1 - outside) * inside.value,
          std::hypot((1 - outside) * inside.sd, outside_sd * inside.value)};
}

void find_tails(RandomPsf& out) {
  constexpr int kSteps = 14;
  constexpr double kFirst = 0.1, kStep = 0.05;  // cycles/px
  const Eigen::Index n = 2 * kSteps;
  random_target::AxisTransfer axis{Eigen::VectorXd(n), Eigen::VectorXd(n), Eigen::VectorXd(n), {}};
  Eigen::MatrixXd rows(n, out.fit->knots.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const double f = kFirst + kStep * static_cast<double>(i % kSteps);
    const bool along_x = i < kSteps;
    const Wave wave(*out.fit, along_x ? Vec2{f, 0} : Vec2{0, f});
    axis.f_cy_per_px[i] = f;
    axis.along_x[i] = along_x ? 1 : 0;
    axis.value[i] = wave.value.real();
    rows.row(i) = wave.real.transpose();
  }
  axis.covariance = rows * out.fit->covariance * rows.transpose();
  const random_target::LensTails tails =
      random_target::fit_tails(axis, 0.5 * out.side * out.step_px);
  if (!tails.ok) return;
  out.outside = tails.outside;
  out.outside_sd = tails.outside_sd;
  out.diffraction_px = tails.diffraction_px;
  out.diffraction_sd = tails.diffraction_sd;
}

RandomPsf::Point RandomPsf::mtf50(double direction_rad) const {
  const double c = std::cos(direction_rad), s = std::sin(direction_rad);
  constexpr double kStep = 0.02;
  for (double f = 0; f < 1; f += kStep) {
    if (mtf_of_all((f + kStep) * c, (f + kStep) * s).value > 0.5) continue;
    double low = f, high = f + kStep;
    for (int k = 0; k < 30; ++k) {
      const double at = 0.5 * (low + high);
      (mtf_of_all(at * c, at * s).value > 0.5 ? low : high) = at;
    }
    const double slope = (mtf_of_all((low + 1e-3) * c, (low + 1e-3) * s).value -
                          mtf_of_all((low - 1e-3) * c, (low - 1e-3) * s).value) /
                         2e-3;
    if (!(std::abs(slope) > 1e-6)) return {};
    return {low, mtf_of_all(low * c, low * s).sd / std::abs(slope)};
  }
  return {};
}

const char* code(RandomStatus status) {
  switch (status) {
    case RandomStatus::kOk:
      return "ok";
    case RandomStatus::kTooSmall:
      return "too_small";
    case RandomStatus::kNoSamples:
      return "clipped_or_not_finite";
    case RandomStatus::kNoContrast:
      return "no_contrast";
    case RandomStatus::kOtherTarget:
      return "not_this_target";
    case RandomStatus::kNotTold:
      return "rank_deficient";
    case RandomStatus::kTooFewSamples:
      return "too_few_samples";
  }
  return "unknown";
}

const char* sentence(RandomStatus status) {
  switch (status) {
    case RandomStatus::kOk:
      return "Measured.";
    case RandomStatus::kTooSmall:
      return "The picture of the target is smaller than 48 pixels a side.";
    case RandomStatus::kNoSamples:
      return "More than 2 % of the samples are clipped or no numbers; expose less, or give another "
             "region.";
    case RandomStatus::kNoContrast:
      return "All samples are alike: there is no target.";
    case RandomStatus::kOtherTarget:
      return "The picture does not look like the random target of this seed and cell size; check "
             "--target and the resolution, and lay the target in within 7 degrees of the axes.";
    case RandomStatus::kNotTold:
      return "The cells of the target repeat the pixels, so that the spread cannot be told; use "
             "cells of another size, or turn the target by a few degrees.";
    case RandomStatus::kTooFewSamples:
      return "There are too few samples for the spread; give a larger region.";
  }
  return "";
}

}  // namespace reseau
