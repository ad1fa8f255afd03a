#include "core/color/delta_e.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/check.h"

namespace reseau {
namespace {

constexpr double kPow25To7 = 6103515625.0;

// CIE 15:2018, 8.2.1: cube root with a straight foot.
double lab_response(double ratio) {
  constexpr double kFoot = 216.0 / 24389.0;
  constexpr double kSlope = 24389.0 / 27.0;
  return ratio > kFoot ? std::cbrt(ratio) : (kSlope * ratio + 16.0) / 116.0;
}

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

double pow7(double v) {
  const double cubed = v * v * v;
  return cubed * cubed * v;
}

double hue_degrees(double a, double b) {
  if (a == 0 && b == 0) {
    return 0;
  }
  const double hue = std::atan2(b, a) * 180.0 / std::numbers::pi;
  return hue < 0 ? hue + 360.0 : hue;
}

struct HuePair {
  double difference = 0;  // second minus first, the short way round [degree]
  double mean = 0;        // [degree]
};

// Opposite hues sit on a discontinuity of the formula: exactly 180 degrees apart belongs to the
// plain side, so that rounding in atan2 must not push a pair across it.
HuePair combine_hues(double first, double second) {
  constexpr double kHalfTurn = 180.0 + 1e-9;
  const double plain = second - first;
  const double sum = first + second;
  if (std::abs(plain) <= kHalfTurn) {
    return {plain, sum / 2};
  }
  return {plain > 0 ? plain - 360.0 : plain + 360.0, (sum < 360.0 ? sum + 360.0 : sum - 360.0) / 2};
}

}  // namespace

Lab lab_from_xyz(const Xyz& xyz, const Xyz& white) {
  CHECK(white[0] > 0 && white[1] > 0 && white[2] > 0);
  std::array<double, 3> f{};
  for (std::size_t i = 0; i < 3; ++i) {
    f[i] = lab_response(std::max(xyz[i], 0.0) / white[i]);
  }
  return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

double delta_e_2000(const Lab& first, const Lab& second) {
  const double mean_chroma_ab =
      (std::hypot(first[1], first[2]) + std::hypot(second[1], second[2])) / 2;
  const double chroma_ab_7 = pow7(mean_chroma_ab);
  const double a_scale = 1.5 - 0.5 * std::sqrt(chroma_ab_7 / (chroma_ab_7 + kPow25To7));
  const double a1 = a_scale * first[1];
  const double a2 = a_scale * second[1];
  const double c1 = std::hypot(a1, first[2]);
  const double c2 = std::hypot(a2, second[2]);
  const double h1 = hue_degrees(a1, first[2]);
  const double h2 = hue_degrees(a2, second[2]);
  // A grey has no hue: the other's counts alone, which the sum gives since its own is 0.
  const HuePair hue = c1 * c2 == 0 ? HuePair{0, h1 + h2} : combine_hues(h1, h2);

  const double d_lightness = second[0] - first[0];
  const double d_chroma = c2 - c1;
  const double d_hue = 2 * std::sqrt(c1 * c2) * std::sin(radians(hue.difference / 2));
  const double lightness = (first[0] + second[0]) / 2;
  const double chroma = (c1 + c2) / 2;

  const double t =
      1 - 0.17 * std::cos(radians(hue.mean - 30)) + 0.24 * std::cos(radians(2 * hue.mean)) +
      0.32 * std::cos(radians(3 * hue.mean + 6)) - 0.20 * std::cos(radians(4 * hue.mean - 63));
  const double from_middle = (lightness - 50) * (lightness - 50);
  const double s_lightness = 1 + 0.015 * from_middle / std::sqrt(20 + from_middle);
  const double s_chroma = 1 + 0.045 * chroma;
  const double s_hue = 1 + 0.015 * chroma * t;
  const double blue = (hue.mean - 275) / 25;
  const double chroma_7 = pow7(chroma);
  const double rotation = -std::sin(radians(60 * std::exp(-blue * blue))) * 2 *
                          std::sqrt(chroma_7 / (chroma_7 + kPow25To7));

  const double l = d_lightness / s_lightness;
  const double c = d_chroma / s_chroma;
  const double h = d_hue / s_hue;
  const double squared = l * l + c * c + h * h + rotation * c * h;
  return std::sqrt(squared < 0 ? 0.0 : squared);
}

DeltaESummary summarize_delta_e(std::span<double> samples, double worst_fraction) {
  CHECK(worst_fraction >= 0 && worst_fraction <= 1);
  std::sort(samples.begin(), samples.end());
  const auto dropped =
      static_cast<std::size_t>(std::lround(worst_fraction * static_cast<double>(samples.size())));
  const auto kept = samples.first(samples.size() - dropped);
  if (kept.empty()) {
    return {};
  }
  const double n = static_cast<double>(kept.size());
  // Nearest rank: the smallest sample that at least 95 % do not exceed.
  const auto rank = static_cast<std::size_t>(std::ceil(0.95 * n));
  return {std::accumulate(kept.begin(), kept.end(), 0.0) / n, kept[rank - 1], kept.back(),
          kept.size()};
}

}  // namespace reseau
