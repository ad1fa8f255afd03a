#include "core/color/spectrum.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

void require_usable(std::span<const ChartPoint> points) {
  if (points.size() < 2) {
    throw InputError("A spectrum needs at least two points; give it more readings.");
  }
  double previous_nm = -std::numeric_limits<double>::infinity();
  for (const ChartPoint& point : points) {
    if (!std::isfinite(point.wavelength_nm) || !std::isfinite(point.value)) {
      throw InputError("A spectrum holds something that is not a number; correct the table.");
    }
    if (point.wavelength_nm <= previous_nm) {
      throw InputError("The wavelengths of a spectrum must rise; sort the table.");
    }
    previous_nm = point.wavelength_nm;
  }
}

}  // namespace

Spectrum resample(std::span<const ChartPoint> points, const WavelengthGrid& grid, double lowest,
                  double highest) {
  require_usable(points);
  CHECK(grid.count >= 0 && grid.step_nm > 0 && lowest <= highest);
  Spectrum out{grid, {}};
  out.values.reserve(static_cast<std::size_t>(grid.count));
  std::size_t left = 0;
  for (int i = 0; i < grid.count; ++i) {
    const double nm = grid.wavelength_nm(i);
    while (left + 2 < points.size() && points[left + 1].wavelength_nm < nm) {
      ++left;
    }
    const ChartPoint& a = points[left];
    const ChartPoint& b = points[left + 1];
    const double t = (nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm);
    out.values.push_back(std::clamp(a.value + t * (b.value - a.value), lowest, highest));
  }
  return out;
}

Spectrum resample(const Spectrum& spectrum, const WavelengthGrid& grid) {
  CHECK(spectrum.values.size() == static_cast<std::size_t>(spectrum.grid.count));
  std::vector<ChartPoint> points;
  points.reserve(spectrum.values.size());
  for (int i = 0; i < spectrum.grid.count; ++i) {
    points.push_back(
        {spectrum.grid.wavelength_nm(i), spectrum.values[static_cast<std::size_t>(i)]});
  }
  constexpr double kHighest = std::numeric_limits<double>::max();
  return resample(points, grid, -kHighest, kHighest);
}

}  // namespace reseau
