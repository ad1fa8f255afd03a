// Element intensities to colour: historical primaries, the area of each element, balance, output
// space, composed into one 3x3 matrix. Method and conventions: Hubicka et al. 2025
// (arXiv:2501.06216), recomputed conventions in core/color/README.md.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace reseau {

using Matrix3 = std::array<double, 9>;  // row-major
using Xyz = std::array<double, 3>;      // Y = 1 for the white

enum class Balance {
  kNone,        // primaries x areas as they are
  kBrightness,  // whole matrix divided by Y of the réseau
  kNeutral,     // columns scaled so that (1, 1, 1) is the white; the default
  kBradford,    // the réseau's own white adapted to the white, then brightness
};

enum class OutputSpace { kProcess, kXyz, kSrgbLinear };

// CIE x, y of red, green, blue and white, for the `chromaticities` of a file.
struct Chromaticities {
  std::array<std::array<double, 2>, 4> xy{};
};

// Sets that `--primaries` knows, e.g. "cornwell-clyne-1951" (the default).
[[nodiscard]] std::vector<std::string> primary_set_names();

struct ColorModel {
  Matrix3 output_from_process{};  // element intensity (1 = clear) to the output space
  Matrix3 xyz_from_process{};     // to XYZ, D65 white, Y = 1
  Chromaticities chromaticities;  // of the output space
};

// Throws InputError for an unknown name, listing the known ones.
[[nodiscard]] ColorModel make_color_model(std::string_view primaries, Balance balance,
                                          OutputSpace space);

// Words of the command line; InputError for anything else, listing the known ones.
[[nodiscard]] Balance parse_balance(std::string_view word);
[[nodiscard]] OutputSpace parse_output_space(std::string_view word);

}  // namespace reseau
