#include "calibration/edge/optics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

using std::numbers::pi;

struct Slope {
  double value = 1;
  double derivative = 0;
};

// Gauss-Legendre nodes of [0, 1].
constexpr int kFocusNodes = 24;
struct Nodes {
  std::array<double, kFocusNodes> x{}, w{};
  Nodes() {
    for (std::size_t i = 0; i < kFocusNodes; ++i) {
      double z = std::cos(pi * (double(i) + 0.75) / (kFocusNodes + 0.5));
      double slope = 0;
      for (int round = 0; round < 50; ++round) {
        double p = 1, before = 0;
        for (int n = 0; n < kFocusNodes; ++n) {
          const double next = ((2 * n + 1) * z * p - n * before) / (n + 1);
          before = p;
          p = next;
        }
        slope = kFocusNodes * (z * p - before) / (z * z - 1);
        const double step = p / slope;
        z -= step;
        if (std::abs(step) < 1e-15) break;
      }
      x[i] = 0.5 * (1 - z);
      w[i] = 1 / ((1 - z * z) * slope * slope);
    }
  }
};

struct Focus {
  double value = 0, by_s = 0, by_w = 0;
};

// Circular pupil, s = f / cut-off: (4/pi) int sin^2 t cos(8 pi W s (cos t - s)) dt over 0..acos s.
Focus pupil(double s, double w20) {
  if (s >= 1) return {};
  const double root = std::sqrt(1 - s * s);
  Focus out;
  out.by_s = -4 / pi * root;
  if (w20 == 0) {
    out.value = 2 / pi * (std::acos(s) - s * root);
    return out;
  }
  static const Nodes nodes;
  const double top = std::acos(s);
  for (std::size_t i = 0; i < kFocusNodes; ++i) {
    const double t = top * nodes.x[i];
    const double sine = std::sin(t), cosine = std::cos(t);
    const double weight = 4 / pi * top * nodes.w[i] * sine * sine;
    const double phase = 8 * pi * w20 * s * (cosine - s);
    const double sine_phase = std::sin(phase);
    out.value += weight * std::cos(phase);
    out.by_s -= weight * sine_phase * 8 * pi * w20 * (cosine - 2 * s);
    out.by_w -= weight * sine_phase * 8 * pi * s * (cosine - s);
  }
  return out;
}

struct Lens {
  double value = 1, by_q = 0, by_w = 0;
};

Lens lens(double q, double w20, double f) {
  const Focus focus = pupil(std::abs(q) * f, w20);
  if (q >= 0) return {focus.value, f * focus.by_s, focus.by_w};
  return {2 - focus.value, f * focus.by_s, -focus.by_w};
}

Slope gaussian(double variance, double f) {
  const double k = 2 * pi * pi * f * f;
  const double e = std::exp(-k * std::abs(variance));
  return {variance >= 0 ? e : 2 - e, -k * e};
}

// sin(pi r) / (pi r) of u = r^2, and its derivative by u.
Slope sinc_of_square(double u) {
  const double x = pi * pi * std::abs(u);
  Slope out;
  if (x < 1e-2) {
    out.value = 1 - x / 6 * (1 - x / 20 * (1 - x / 42));
    out.derivative = -pi * pi / 6 * (1 - x / 10 * (1 - x / 28 * (1 - x / 54)));
  } else {
    const double r = std::sqrt(x);
    out.value = std::sin(r) / r;
    out.derivative = pi * pi * (std::cos(r) - out.value) / (2 * x);
  }
  if (u < 0) out.value = 2 - out.value;
  return out;
}

}  // namespace

double& parameter(EdgeOptics& optics, int index) {
  switch (index) {
    case kDiffraction:
      return optics.diffraction_px;
    case kSigma2:
      return optics.sigma2_px2;
    case kAperture2:
      return optics.aperture2_px2;
    case kSmear2:
      return optics.smear2_px2;
    case kW20:
      return optics.w20_waves;
    case kHalo:
      return optics.halo;
    case kHaloSigma:
      return optics.halo_sigma_px;
    default:
      CHECK(index == kAspect2);
      return optics.aspect2;
  }
}

double parameter(const EdgeOptics& optics, int index) {
  EdgeOptics copy = optics;
  return parameter(copy, index);
}

void transfer(const EdgeOptics& o, const NormalCosines& normal, double f,
              std::span<const int> parameters, std::span<double> out) {
  const Lens t = lens(o.diffraction_px, o.w20_waves, f);
  const Slope g = gaussian(o.sigma2_px2, f);
  const double fx = f * normal.x, fy = f * normal.y;
  const Slope ax = sinc_of_square(o.aperture2_px2 * fx * fx);
  const double fy2 = o.aspect2 * fy * fy;
  const Slope ay = sinc_of_square(o.aperture2_px2 * fy2);
  const double along = std::max(fx, fy);
  const Slope smear =
      o.smear2_px2 != 0 ? sinc_of_square(o.smear2_px2 * along * along) : Slope{1, -pi * pi / 6};
  const double aperture = ax.value * ay.value;
  const double box = aperture * smear.value;
  double halo = 0;
  if (o.halo != 0 || parameters.size() > 3) {
    halo = std::exp(-2 * pi * pi * o.halo_sigma_px * o.halo_sigma_px * f * f);
  }
  const double core = t.value * g.value;
  const double mixed = (1 - o.halo) * core + o.halo * halo;
  out[0] = mixed * box;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    double d = 0;
    switch (parameters[i]) {
      case kDiffraction:
        d = (1 - o.halo) * t.by_q * g.value * box;
        break;
      case kSigma2:
        d = (1 - o.halo) * t.value * g.derivative * box;
        break;
      case kAperture2:
        d = mixed * smear.value *
            (ax.derivative * fx * fx * ay.value + ay.derivative * fy2 * ax.value);
        break;
      case kSmear2:
        d = mixed * aperture * smear.derivative * along * along;
        break;
      case kW20:
        d = (1 - o.halo) * t.by_w * g.value * box;
        break;
      case kHalo:
        d = (halo - core) * box;
        break;
      case kAspect2:
        d = mixed * smear.value * ax.value * ay.derivative * o.aperture2_px2 * fy * fy;
        break;
      default:
        d = -o.halo * 4 * pi * pi * o.halo_sigma_px * f * f * halo * box;
    }
    out[1 + i] = d;
  }
}

double transfer(const EdgeOptics& optics, const NormalCosines& normal, double f) {
  double out = 0;
  transfer(optics, normal, f, {}, std::span(&out, 1));
  return out;
}

double highest_frequency(const EdgeOptics& o, double most) {
  double top = most;
  if (o.sigma2_px2 > 0) top = std::min(top, std::sqrt(16.5 / (2 * pi * pi * o.sigma2_px2)));
  if (o.diffraction_px > 0) top = std::min(top, 1 / o.diffraction_px);
  if (o.halo != 0) top = std::max(top, std::min(most, 0.92 / std::max(o.halo_sigma_px, 0.1)));
  return top;
}

}  // namespace reseau
