#include "core/color/set_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

double halton(int n, int base) {
  double fraction = 1, value = 0;
  for (; n > 0; n /= base) {
    fraction /= base;
    value += fraction * (n % base);
  }
  return value;
}

// Inverse of the normal distribution by Newton's method, which from 0 converges from one side.
double normal_quantile(double p) {
  double x = 0;
  for (int i = 0; i < 100; ++i) {
    const double density = std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
    const double step = (p - 0.5 * std::erfc(-x / std::numbers::sqrt2)) / density;
    x += step;
    if (std::abs(step) < 1e-14) break;
  }
  return x;
}

// Of the logarithms of the intensities.
struct SceneParameters {
  double mean_green, red_offset, blue_offset;
  double sd_luminance, sd_red_blue, sd_green_magenta;
  double correlation;  // of luminance and red-blue
};

std::vector<Vector3> log_normal_scene(const SceneParameters& p) {
  std::vector<Vector3> scene;
  for (int k = 1; k <= 1000; ++k) {
    const double z0 = normal_quantile(halton(k, 2)), z1 = normal_quantile(halton(k, 3)),
                 z2 = normal_quantile(halton(k, 5));
    const double luminance = p.mean_green + p.sd_luminance * z0;
    const double red_blue =
        p.sd_red_blue * (p.correlation * z0 + std::sqrt(1 - p.correlation * p.correlation) * z1);
    const double green = p.sd_green_magenta * z2;
    // Five decimals, as the scenes are published.
    const auto intensity = [](double log) {
      return std::round(1e5 * std::min(1.0, std::exp(log))) / 1e5;
    };
    scene.push_back({intensity(luminance + p.red_offset + red_blue - green / 2),
                     intensity(luminance + green),
                     intensity(luminance + p.blue_offset - red_blue - green / 2)});
  }
  return scene;
}

Lab lab_of(const Matrix3& xyz_from_process, const Vector3& intensities, const Xyz& white,
           bool clamp) {
  Xyz xyz = multiply(xyz_from_process, intensities);
  if (clamp) {
    for (double& v : xyz) v = std::clamp(v, 0.0, 1.0);
  }
  return lab_from_xyz(xyz, white);
}

std::vector<double> ranks(std::span<const double> values) {
  std::vector<double> out;
  for (const double value : values) {
    const auto below =
        std::count_if(values.begin(), values.end(), [&](double v) { return v < value; });
    const auto same = std::count(values.begin(), values.end(), value);
    out.push_back(static_cast<double>(below) + (static_cast<double>(same) - 1) / 2);
  }
  return out;
}

}  // namespace

DeltaESummary set_difference(std::span<const Vector3> intensities, const ColorModel& a,
                             const ColorModel& b, const DifferenceConvention& convention) {
  const Xyz d65 = white_of(Illuminant::kD65);
  const bool own = convention.white == DifferenceConvention::LabWhite::kReseau;
  const Xyz white_a = own ? a.reseau : d65, white_b = own ? b.reseau : d65;
  std::vector<double> differences;
  differences.reserve(intensities.size());
  for (const Vector3& pixel : intensities) {
    differences.push_back(
        delta_e_2000(lab_of(a.xyz_from_process, pixel, white_a, convention.clamp_xyz),
                     lab_of(b.xyz_from_process, pixel, white_b, convention.clamp_xyz)));
  }
  return summarize_delta_e(differences, convention.worst_fraction);
}

std::vector<Vector3> stated_colors(std::string_view name) {
  if (name == "warm") return log_normal_scene({-1.29, 0.13, -0.28, 0.37, 0.26, 0.09, 0.0});
  if (name == "green") return log_normal_scene({-2.89, -0.13, -0.31, 1.18, 0.29, -0.17, 0.27});
  if (name == "even") {
    std::vector<Vector3> colors;
    for (int k = 1; k <= 1000; ++k) colors.push_back({halton(k, 2), halton(k, 3), halton(k, 5)});
    return colors;
  }
  throw InputError("There are no colours '" + std::string(name) +
                   "'; use warm, green, even, or a CSV file with the columns r,g,b.");
}

double spearman(std::span<const double> a, std::span<const double> b) {
  CHECK(a.size() == b.size());
  if (a.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const auto ra = ranks(a), rb = ranks(b);
  const double mean = (static_cast<double>(a.size()) - 1) / 2;
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < ra.size(); ++i) {
    ab += (ra[i] - mean) * (rb[i] - mean);
    aa += (ra[i] - mean) * (ra[i] - mean);
    bb += (rb[i] - mean) * (rb[i] - mean);
  }
  return ab / std::sqrt(aa * bb);
}

}  // namespace reseau
