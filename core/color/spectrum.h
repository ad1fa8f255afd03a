// Spectra on an even grid of wavelengths, and digitised charts brought to such a grid.
// Pure functions, reentrant.
#pragma once

#include <span>
#include <vector>

namespace reseau {

// Wavelengths first_nm, first_nm + step_nm, ... (count of them).
struct WavelengthGrid {
  double first_nm = 380;
  double step_nm = 5;
  int count = 81;

  [[nodiscard]] double wavelength_nm(int index) const { return first_nm + index * step_nm; }
  bool operator==(const WavelengthGrid&) const = default;
};

// One value per wavelength of the grid; what the value is, the owner says (transmittance 0..1,
// relative power).
struct Spectrum {
  WavelengthGrid grid;
  std::vector<double> values;
};

struct ChartPoint {
  double wavelength_nm = 0;
  double value = 0;
};

// A chart read at irregular wavelengths to the grid: linear between points; beyond the first and
// the last point the outer segment continues; then clamped to lowest..highest. InputError when
// there are fewer than two points, when wavelengths do not rise, or when a number is not finite.
[[nodiscard]] Spectrum resample(std::span<const ChartPoint> points, const WavelengthGrid& grid,
                                double lowest, double highest);

// One spectrum to another grid by linear interpolation, the outermost segments continued.
[[nodiscard]] Spectrum resample(const Spectrum& spectrum, const WavelengthGrid& grid);

}  // namespace reseau
