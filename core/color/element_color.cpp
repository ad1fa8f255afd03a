#include "core/color/element_color.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace reseau {
namespace {

Chromaticities process_chromaticities(const Matrix3& xyz_from_process) {
  return {{chromaticity_of(column(xyz_from_process, 0)),
           chromaticity_of(column(xyz_from_process, 1)),
           chromaticity_of(column(xyz_from_process, 2)),
           chromaticity_of(reseau_color(xyz_from_process))}};
}

Chromaticities xyz_chromaticities() { return {{{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}}}}; }

void require_usable(const Matrix3& element_xyz, const Vector3& areas) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  if (!std::all_of(areas.begin(), areas.end(), positive)) {
    throw InputError("Each element must cover a positive share of the area; correct the areas.");
  }
  if (!std::all_of(element_xyz.begin() + 3, element_xyz.begin() + 6, positive)) {
    throw InputError("Each primary needs a luminance above 0; correct the set.");
  }
}

}  // namespace

OutputSpace parse_output_space(std::string_view word) {
  if (word == "process") return OutputSpace::kProcess;
  if (word == "xyz") return OutputSpace::kXyz;
  if (word == "srgb-linear") return OutputSpace::kSrgbLinear;
  throw InputError("There is no output space '" + std::string(word) +
                   "'; use process, xyz or srgb-linear.");
}

ColorModel make_color_model(std::string_view primaries, Balance balance, OutputSpace space) {
  return make_color_model(primaries, element_primaries(primaries, Illuminant::kD65),
                          dufaycolor_areas(), balance, space);
}

ColorModel make_color_model(std::string_view name, const Matrix3& element_xyz, const Vector3& areas,
                            Balance balance, OutputSpace space) {
  require_usable(element_xyz, areas);
  const double total = areas[0] + areas[1] + areas[2];
  const Matrix3 weighted =
      scale_columns(element_xyz, {areas[0] / total, areas[1] / total, areas[2] / total});

  ColorModel model;
  model.primaries = name;
  model.balance = balance;
  model.space = space;
  const Xyz white = white_of(Illuminant::kD65);
  model.xyz_from_process = apply_balance(weighted, balance, white);
  model.reseau = reseau_color(model.xyz_from_process);
  model.condition = condition_number(model.xyz_from_process);
  model.adopted_neutral = chromaticity_of(white);
  switch (space) {
    case OutputSpace::kProcess:
      model.output_from_process = kIdentity3;
      model.chromaticities = process_chromaticities(model.xyz_from_process);
      break;
    case OutputSpace::kXyz:
      model.output_from_process = model.xyz_from_process;
      model.chromaticities = xyz_chromaticities();
      break;
    case OutputSpace::kSrgbLinear:
      model.output_from_process = multiply(srgb_from_xyz_d65(), model.xyz_from_process);
      model.chromaticities = srgb_chromaticities();
      break;
  }
  return model;
}

}  // namespace reseau
