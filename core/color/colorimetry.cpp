#include "core/color/colorimetry.h"

#include <cmath>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/tables.h"

namespace reseau {
namespace {

Observer make_observer(std::span<const ObserverRow> rows) {
  Observer out;
  out.grid = {rows.front().wavelength_nm, rows[1].wavelength_nm - rows[0].wavelength_nm,
              static_cast<int>(rows.size())};
  for (const ObserverRow& row : rows) {
    out.xbar.push_back(row.xbar);
    out.ybar.push_back(row.ybar);
    out.zbar.push_back(row.zbar);
  }
  return out;
}

Spectrum make_illuminant(double IlluminantRow::*power) {
  const auto rows = illuminant_table();
  Spectrum out;
  out.grid = {rows.front().wavelength_nm, rows[1].wavelength_nm - rows[0].wavelength_nm,
              static_cast<int>(rows.size())};
  for (const IlluminantRow& row : rows) {
    out.values.push_back(row.*power);
  }
  return out;
}

}  // namespace

const Observer& observer_5nm() {
  static const Observer observer = make_observer(observer_table_5nm());
  return observer;
}

const Observer& observer_1nm() {
  static const Observer observer = make_observer(observer_table_1nm());
  return observer;
}

Illuminant parse_illuminant(std::string_view name) {
  if (name == "A") return Illuminant::kA;
  if (name == "B") return Illuminant::kB;
  if (name == "C") return Illuminant::kC;
  if (name == "D50") return Illuminant::kD50;
  if (name == "D65") return Illuminant::kD65;
  if (name == "E") return Illuminant::kE;
  throw InputError("There is no illuminant '" + std::string(name) +
                   "'; use A, B, C, D50, D65 or E.");
}

const Spectrum& illuminant_spectrum(Illuminant illuminant) {
  static const std::array<Spectrum, 6> spectra{
      make_illuminant(&IlluminantRow::a),   make_illuminant(&IlluminantRow::b),
      make_illuminant(&IlluminantRow::c),   make_illuminant(&IlluminantRow::d50),
      make_illuminant(&IlluminantRow::d65), make_illuminant(&IlluminantRow::e)};
  return spectra[static_cast<std::size_t>(illuminant)];
}

Spectrum daylight_spectrum(double temperature_k) {
  const double t = temperature_k;
  if (!(t >= 4000 && t <= 25000)) {
    throw InputError("Daylight is defined from 4000 K to 25000 K; choose a temperature between.");
  }
  // CIE 15:2018, 3.1: chromaticity of daylight, then the weights of its two components.
  const double x = t <= 7000
                       ? 0.244063 + 0.09911e3 / t + 2.9678e6 / (t * t) - 4.6070e9 / (t * t * t)
                       : 0.237040 + 0.24748e3 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t);
  const double y = -3.000 * x * x + 2.870 * x - 0.275;
  const double m = 0.0241 + 0.2562 * x - 0.7341 * y;
  const auto thousandths = [](double v) { return std::round(1000 * v) / 1000; };
  const double m1 = thousandths((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
  const double m2 = thousandths((0.0300 - 31.4424 * x + 30.0717 * y) / m);
  std::vector<ChartPoint> points;
  for (const DaylightRow& row : daylight_table()) {
    points.push_back({row.wavelength_nm, row.s0 + m1 * row.s1 + m2 * row.s2});
  }
  return resample(points, observer_5nm().grid, 0, 1e6);
}

Xyz xyz_from_transmittance(const Spectrum& transmittance, const Spectrum& light,
                           const Observer& observer) {
  CHECK(transmittance.grid == observer.grid && light.grid == observer.grid);
  Xyz sum{};
  double white_y = 0;
  for (std::size_t i = 0; i < observer.ybar.size(); ++i) {
    const double power = light.values[i] * transmittance.values[i];
    sum[0] += power * observer.xbar[i];
    sum[1] += power * observer.ybar[i];
    sum[2] += power * observer.zbar[i];
    white_y += light.values[i] * observer.ybar[i];
  }
  return {sum[0] / white_y, sum[1] / white_y, sum[2] / white_y};
}

Xyz white_of(const Spectrum& light, const Observer& observer) {
  const Spectrum clear{observer.grid, std::vector<double>(observer.ybar.size(), 1.0)};
  return xyz_from_transmittance(clear, light, observer);
}

Xyz white_of(Illuminant illuminant) {
  return white_of(illuminant_spectrum(illuminant), observer_5nm());
}

Chromaticity chromaticity_of(const Xyz& xyz) {
  const double sum = xyz[0] + xyz[1] + xyz[2];
  if (sum == 0) {
    return {0, 0};
  }
  return {xyz[0] / sum, xyz[1] / sum};
}

Xyz xyz_from_chromaticity(const Chromaticity& xy, double luminance) {
  if (!(xy[1] > 0) || !std::isfinite(xy[0]) || !std::isfinite(xy[1]) || !std::isfinite(luminance)) {
    throw InputError(
        "A chromaticity needs finite x and y with y above 0, and a finite luminance; correct it.");
  }
  const double k = luminance / xy[1];
  return {xy[0] * k, luminance, (1 - xy[0] - xy[1]) * k};
}

}  // namespace reseau
