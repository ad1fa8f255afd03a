#include "core/color/element_color.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace reseau {
namespace {

constexpr std::array<const char*, 8> kSpaceWords{"process", "xyz",      "srgb-linear", "display-p3",
                                                 "rec2020", "prophoto", "aces-ap0",    "film"};

Chromaticities element_chromaticities(const Matrix3& xyz_from_process, const Chromaticity& white) {
  return {{chromaticity_of(column(xyz_from_process, 0)),
           chromaticity_of(column(xyz_from_process, 1)),
           chromaticity_of(column(xyz_from_process, 2)), white}};
}

Chromaticities xyz_chromaticities() { return {{{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}}}}; }

bool all_positive(const double* first, const double* last) {
  return std::all_of(first, last, [](double v) { return std::isfinite(v) && v > 0; });
}

void require_usable(const Matrix3& element_xyz, const Vector3& areas) {
  if (!all_positive(areas.data(), areas.data() + 3)) {
    throw InputError("Each element must cover a positive share of the area; correct the areas.");
  }
  constexpr std::array<const char*, 3> kElements{"red", "green", "blue"};
  for (std::size_t i = 0; i < 3; ++i) {
    if (all_positive(element_xyz.data() + 3 + i, element_xyz.data() + 4 + i)) continue;
    throw InputError(std::string("The ") + kElements[i] +
                     " element lets no light through; each primary needs a luminance above 0. "
                     "Correct the set.");
  }
}

void fill_output(ColorModel& model) {
  const Chromaticity d65 = chromaticity_of(white_of(Illuminant::kD65));
  const Matrix3& xyz = model.xyz_from_process;
  model.adopted_neutral = d65;
  switch (model.space) {
    case OutputSpace::kProcess:
      model.output_from_process = kIdentity3;
      model.chromaticities = element_chromaticities(xyz, chromaticity_of(model.reseau));
      return;
    case OutputSpace::kXyz:
      model.output_from_process = xyz;
      model.chromaticities = xyz_chromaticities();
      return;
    case OutputSpace::kFilm:
      model.chromaticities = element_chromaticities(xyz, d65);
      break;
    default:
      model.chromaticities = rgb_space_chromaticities(space_word(model.space));
      model.adopted_neutral = model.chromaticities.xy[3];
      break;
  }
  model.output_from_process = multiply(rgb_from_xyz_d65(model.chromaticities), xyz);
}

// `weighted`: XYZ under `light` of element x area, columns. `d65_from_light`: adaptation.
ColorModel balanced_model(std::string_view name, const Matrix3& weighted, const Xyz& light,
                          const Matrix3& d65_from_light, const Vector3& white_balance,
                          Balance balance, OutputSpace space) {
  ColorModel model;
  model.primaries = name;
  model.balance = balance;
  model.space = space;
  model.xyz_from_process = apply_balance(weighted, balance, light);
  if (d65_from_light != kIdentity3) {
    model.xyz_from_process = multiply(d65_from_light, model.xyz_from_process);
  }
  model.reseau = reseau_color(model.xyz_from_process);
  model.condition = condition_number(model.xyz_from_process);
  fill_output(model);
  if (white_balance != Vector3{1, 1, 1}) {
    model.output_from_process = scale_columns(model.output_from_process, white_balance);
  }
  return model;
}

Matrix3 weighted_by(const Matrix3& element_xyz, const Vector3& areas) {
  require_usable(element_xyz, areas);
  const double total = areas[0] + areas[1] + areas[2];
  return scale_columns(element_xyz, {areas[0] / total, areas[1] / total, areas[2] / total});
}

}  // namespace

std::vector<std::string> output_space_words() { return {kSpaceWords.begin(), kSpaceWords.end()}; }

std::string space_word(OutputSpace space) { return kSpaceWords[static_cast<std::size_t>(space)]; }

OutputSpace parse_output_space(std::string_view word) {
  std::string known;
  for (std::size_t i = 0; i < kSpaceWords.size(); ++i) {
    if (word == kSpaceWords[i]) return static_cast<OutputSpace>(i);
    known += (i == 0                        ? ""
              : i + 1 == kSpaceWords.size() ? " or "
                                            : ", ") +
             std::string(kSpaceWords[i]);
  }
  throw InputError("There is no output space '" + std::string(word) + "'; use " + known + ".");
}

ColorModel make_color_model(const ColorRecipe& recipe) {
  if (!all_positive(recipe.white_balance.data(), recipe.white_balance.data() + 3)) {
    throw InputError("The factors of a white balance must be positive numbers; correct them.");
  }
  const Viewing& viewing = recipe.viewing;
  const Matrix3 weighted = weighted_by(element_xyz(recipe.primaries, viewing), recipe.areas.share);
  const Xyz light = white_of(viewing.light, viewing.step);
  const Xyz d65 = white_of(Illuminant::kD65);
  return balanced_model(
      recipe.primaries.name, weighted, light,
      light == d65 ? kIdentity3 : target_from_source(viewing.adaptation, light, d65),
      recipe.white_balance, recipe.balance, recipe.space);
}

ColorModel make_color_model(std::string_view primaries, Balance balance, OutputSpace space) {
  ColorRecipe recipe;
  recipe.primaries = find_primary_set(primaries);
  recipe.balance = balance;
  recipe.space = space;
  return make_color_model(recipe);
}

ColorModel make_color_model(std::string_view name, const Matrix3& element_xyz, const Vector3& areas,
                            Balance balance, OutputSpace space) {
  return balanced_model(name, weighted_by(element_xyz, areas), white_of(Illuminant::kD65),
                        kIdentity3, {1, 1, 1}, balance, space);
}

}  // namespace reseau
