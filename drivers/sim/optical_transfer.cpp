#include "drivers/sim/optical_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace reseau::sim {
namespace {

constexpr int kNodes = 16;

struct GaussLegendre {
  std::array<double, kNodes> x{}, w{};
};

// Nodes and weights on [-1, 1]: Newton's method on the Legendre polynomial.
GaussLegendre make_rule() {
  GaussLegendre rule;
  for (int i = 0; i < kNodes; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5)), slope = 1;
    for (int step = 0; step < 100; ++step) {
      double p = 1, before = 0;
      for (int k = 1; k <= kNodes; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = kNodes * (x * p - before) / (x * x - 1);
      const double change = p / slope;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    rule.x[static_cast<std::size_t>(i)] = x;
    rule.w[static_cast<std::size_t>(i)] = 2 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

double sinc(double x) { return std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x; }

double gaussian(double sigma, double f_squared) {
  return std::exp(-2 * std::numbers::pi * std::numbers::pi * sigma * sigma * f_squared);
}

}  // namespace

double lens_transfer(double s_x, double s_y, double w_x, double w_y) {
  static const GaussLegendre rule = make_rule();
  const double s = std::hypot(s_x, s_y);
  if (s >= 1) return 0;
  if (s == 0) return 1;
  // Over the overlap of two pupils 2 s apart their wavefronts differ by a plane: its slopes along
  // and across the shift, in radians per pupil radius.
  const double g_x = 8 * std::numbers::pi * w_x * s_x, g_y = 8 * std::numbers::pi * w_y * s_y;
  const double along = (g_x * s_x + g_y * s_y) / s, across = (g_y * s_x - g_x * s_y) / s;
  // Place along the shift is sin(t) - s and half the width there cos(t), which takes the root out.
  const double begin = std::asin(s), length = std::numbers::pi / 2 - begin;
  const int panels = 1 + static_cast<int>((std::abs(along) * (1 - s) + std::abs(across)) / 5);
  double sum = 0;
  for (int panel = 0; panel < panels; ++panel) {
    const double half = length / (2 * panels), middle = begin + (2 * panel + 1) * half;
    for (std::size_t i = 0; i < kNodes; ++i) {
      const double t = middle + half * rule.x[i], c = std::cos(t);
      const double value = std::cos(along * (std::sin(t) - s)) * c * c * sinc(across * c);
      sum += half * rule.w[i] * value;
    }
  }
  return 4 / std::numbers::pi * sum;
}

OpticalTransfer::OpticalTransfer(const OpticsSpec& optics, int channel)
    : astigmatism_um_(optics.astigmatism_um),
      core_px_(optics.blur_px[static_cast<std::size_t>(channel)]),
      halo_fraction_(optics.halo_fraction),
      halo_px_(optics.halo_px),
      aperture_x_px_(optics.aperture_px),
      aperture_y_px_(optics.aperture_y_px > 0 ? optics.aperture_y_px : optics.aperture_px) {
  const auto c = static_cast<std::size_t>(channel);
  const double n = optics.f_number[c], wavelength = optics.wavelength_um[c];
  if (n <= 0) return;
  cutoff_ = optics.pixel_um / (wavelength * n);
  // A focus error d bends the wavefront by d NA^2 / 2 at the edge of the pupil, NA = 1 / (2 N).
  waves_per_um_ = 1 / (8 * n * n * wavelength);
}

double OpticalTransfer::sharp(double f_x, double f_y, double defocus_um) const {
  const double core = gaussian(core_px_, f_x * f_x + f_y * f_y);
  if (!has_lens()) return core;
  return core * lens_transfer(f_x / cutoff_, f_y / cutoff_, waves(defocus_um + astigmatism_um_ / 2),
                              waves(defocus_um - astigmatism_um_ / 2));
}

double OpticalTransfer::aperture(double f_x, double f_y) const {
  return sinc(std::numbers::pi * aperture_x_px_ * f_x) *
         sinc(std::numbers::pi * aperture_y_px_ * f_y);
}

double OpticalTransfer::halo(double f_squared) const { return gaussian(halo_px_, f_squared); }

double OpticalTransfer::operator()(double f_x, double f_y, double defocus_um) const {
  const double lens = sharp(f_x, f_y, defocus_um);
  const double mixed = halo_fraction_ == 0 ? lens
                                           : (1 - halo_fraction_) * lens +
                                                 halo_fraction_ * halo(f_x * f_x + f_y * f_y);
  return mixed * aperture(f_x, f_y);
}

PsfGrid sample_psf(const OpticsSpec& optics, int channel, double defocus_um, int samples_per_px,
                   int radius_px) {
  if (samples_per_px < 1 || radius_px < 1 || radius_px > 256 ||
      2 * radius_px * samples_per_px > 4095 || channel < 0 || channel > 3) {
    throw InputError(
        "A point spread function cannot be sampled like that: ask for channel 0 to 3, at least 1 "
        "sample per pixel, a radius of 1 to 256 pixels and at most 4096 samples a side.");
  }
  const OpticalTransfer otf(optics, channel);
  // The function is even, so a quarter of the plane and cosines suffice. Sampling the transfer at
  // 1 / period lets the grid's copies fall that far away.
  const double period = std::max(64.0, 4.0 * radius_px);
  double highest = 4.0 * samples_per_px;
  if (otf.has_lens()) highest = std::min(highest, otf.cutoff());
  if (otf.core_px() > 0) highest = std::min(highest, 1.0 / otf.core_px());
  const auto n = static_cast<std::size_t>(std::ceil(highest * period)) + 1;
  const int reach = radius_px * samples_per_px;
  const auto half = static_cast<std::size_t>(reach);
  std::vector<double> cosines(n * (half + 1));  // [frequency][place]
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t i = 0; i <= half; ++i) {
      const double x = static_cast<double>(i) / samples_per_px;
      cosines[a * (half + 1) + i] =
          (a == 0 ? 1.0 : 2.0) / period *
          std::cos(2 * std::numbers::pi * static_cast<double>(a) / period * x);
    }
  }
  std::vector<double> quarter((half + 1) * (half + 1), 0.0), row(half + 1);
  for (std::size_t b = 0; b < n; ++b) {
    std::ranges::fill(row, 0.0);
    for (std::size_t a = 0; a < n; ++a) {
      const double t =
          otf(static_cast<double>(a) / period, static_cast<double>(b) / period, defocus_um);
      if (t == 0) continue;
      for (std::size_t i = 0; i <= half; ++i) row[i] += t * cosines[a * (half + 1) + i];
    }
    for (std::size_t j = 0; j <= half; ++j) {
      const double c = cosines[b * (half + 1) + j];
      for (std::size_t i = 0; i <= half; ++i) quarter[j * (half + 1) + i] += c * row[i];
    }
  }
  PsfGrid grid;
  grid.samples_per_px = samples_per_px;
  grid.radius_px = radius_px;
  grid.side = static_cast<int>(2 * half + 1);
  grid.values.resize((2 * half + 1) * (2 * half + 1));
  for (std::size_t j = 0; j <= 2 * half; ++j) {
    for (std::size_t i = 0; i <= 2 * half; ++i) {
      const std::size_t y = j > half ? j - half : half - j, x = i > half ? i - half : half - i;
      grid.values[j * (2 * half + 1) + i] = quarter[y * (half + 1) + x];
    }
  }
  return grid;
}

}  // namespace reseau::sim
