// Element intensities to colour: historical primaries, the area of each element, balance, output
// space, composed into one 3x3 matrix. Method: Hubicka et al. 2025 (arXiv:2501.06216). Pure
// functions, reentrant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/color/balance.h"
#include "core/color/colorimetry.h"
#include "core/color/matrix3.h"
#include "core/color/primaries.h"
#include "core/color/rgb_space.h"

namespace reseau {

enum class OutputSpace {
  kProcess,     // linear element intensity, 1 = clear film behind that element
  kXyz,         // CIE XYZ relative to D65, Y = 1
  kSrgbLinear,  // linear sRGB, not clipped; so are the others
  kDisplayP3,
  kRec2020,
  kProPhoto,  // white D50
  kAcesAp0,   // white of ACES
  kFilm,      // the film's own primaries, white D65
};

// The words of `--space`, in the order of the enum.
[[nodiscard]] std::vector<std::string> output_space_words();
// InputError for any other word, listing these.
[[nodiscard]] OutputSpace parse_output_space(std::string_view word);
[[nodiscard]] std::string space_word(OutputSpace space);

// Everything that decides which colour an element intensity becomes.
struct ColorRecipe {
  PrimarySet primaries = primary_sets().front();
  ScreenAreas areas = screen_areas().front();
  // Light, grid, dyes, and the adaptation, from the light of a set of stated colours to that of the
  // viewing and from there to D65.
  Viewing viewing;
  Balance balance = Balance::kNeutral;
  OutputSpace space = OutputSpace::kSrgbLinear;
  // Factors on the element intensities, by a person or a neutral area of the picture; 1 = none.
  Vector3 white_balance{1, 1, 1};
};

struct ColorModel {
  std::string primaries;  // name of the set
  Balance balance = Balance::kNeutral;
  OutputSpace space = OutputSpace::kProcess;

  Matrix3 output_from_process{};  // element intensity (1 = clear) to the output space
  Matrix3 xyz_from_process{};     // to XYZ, D65 white, Y = 1

  // Of the output space, for a file. A reader that follows OpenEXR gets XYZ / Y(1, 1, 1) from them:
  // for `process` these are the film's own elements and the colour of its clear réseau after the
  // balance; for `xyz` the axes of XYZ with equal energy (the numbers are XYZ relative to D65,
  // which `adopted_neutral` says); for `film` the elements with D65 as white; else the space's own.
  Chromaticities chromaticities;
  // x, y that should look neutral, for OpenEXR's `adoptedNeutral`: the white of the space, D65 for
  // `process`, `xyz` and `film`.
  Chromaticity adopted_neutral{};

  Xyz reseau{};          // XYZ of (1, 1, 1) after the balance
  double condition = 0;  // condition number of xyz_from_process
};

// InputError when the primaries cannot be used: singular, not finite, unable to be balanced; for
// areas or factors that are not positive; and as element_xyz().
[[nodiscard]] ColorModel make_color_model(const ColorRecipe& recipe);

// A built-in set under D65 with the areas of Dufaycolor. InputError for an unknown name, listing
// the known ones.
[[nodiscard]] ColorModel make_color_model(std::string_view primaries, Balance balance,
                                          OutputSpace space);

// From primaries of one's own: XYZ of the full elements as columns, under D65 with Y = 1, and the
// area shares of the elements (positive, any common scale).
[[nodiscard]] ColorModel make_color_model(std::string_view name, const Matrix3& element_xyz,
                                          const Vector3& areas, Balance balance, OutputSpace space);

}  // namespace reseau
