#include "capture/color/color_record.h"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/session/json_number.h"
#include "core/base/error.h"

namespace reseau {
namespace {

using nlohmann::ordered_json;

constexpr const char* kMatrixAttribute = "reseau.outputFromProcess";

std::string triple(const Vector3& v) { return fmt::format("{},{},{}", v[0], v[1], v[2]); }

ordered_json triple_json(const Vector3& v) {
  return {number_or_null(v[0]), number_or_null(v[1]), number_or_null(v[2])};
}

std::string matrix_text(const Matrix3& matrix) {
  std::string text;
  for (const double value : matrix) text += fmt::format("{}{}", text.empty() ? "" : " ", value);
  return text;
}

std::optional<Matrix3> read_matrix(const std::string& text) {
  Matrix3 matrix{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (double& value : matrix) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    at = next;
  }
  return at == end ? std::optional(matrix) : std::nullopt;
}

}  // namespace

std::string balance_word(Balance balance) {
  constexpr std::array kWords{"none", "brightness", "neutral", "bradford"};
  return kWords[static_cast<std::size_t>(balance)];
}

ordered_json matrix_json(const Matrix3& m) {
  ordered_json rows = ordered_json::array();
  for (std::size_t i = 0; i < 9; i += 3) rows.push_back(triple_json({m[i], m[i + 1], m[i + 2]}));
  return rows;
}

void declare_color(const ColorRecipe& recipe, ExrOptions& options) {
  const ColorModel model = make_color_model(recipe);
  options.chromaticities = model.chromaticities;
  options.adopted_neutral = model.adopted_neutral;
  // Luminance of (1, 1, 1) when the light behind the film has 100 cd/m2.
  options.white_luminance = 100 * (recipe.space == OutputSpace::kProcess ? model.reseau[1] : 1.0);
  const Viewing& viewing = recipe.viewing;
  const std::pair<const char*, std::string> attributes[] = {
      {"reseau.primaries", recipe.primaries.name},
      {"reseau.balance", balance_word(recipe.balance)},
      {"reseau.space", space_word(recipe.space)},
      {"reseau.light", viewing.light.name},
      {"reseau.areas", triple(recipe.areas.share)},
      {"reseau.dyeDensity", triple(viewing.dyes.density)},
      {"reseau.dyeFading", triple(viewing.dyes.fading)},
      {"reseau.whiteBalance", triple(recipe.white_balance)},
      {kMatrixAttribute, matrix_text(model.output_from_process)},
  };
  for (const auto& [name, value] : attributes) options.attributes.emplace_back(name, value);
}

Matrix3 output_from_process_of(const ExrReader& reader, const std::string& name) {
  const auto text = reader.attribute(kMatrixAttribute);
  if (!text) {
    throw InputError("The picture '" + name +
                     "' does not say how its colours were made, so they cannot be made anew; "
                     "reconstruct it again from its scan.");
  }
  const auto matrix = read_matrix(*text);
  if (!matrix || !(condition_number(*matrix) < 1e6)) {
    throw InputError("The picture '" + name +
                     "' holds a damaged record of how its colours were made; reconstruct it again "
                     "from its scan.");
  }
  return *matrix;
}

ordered_json color_to_json(const ColorRecipe& recipe) {
  const Viewing& viewing = recipe.viewing;
  ordered_json object = {
      {"space", space_word(recipe.space)},
      {"primaries", recipe.primaries.name},
      {"primaries_source", recipe.primaries.source},
      {"balance", balance_word(recipe.balance)},
      {"light", viewing.light.name},
      {"areas", triple_json(recipe.areas.share)},
      {"adaptation", viewing.adaptation == AdaptationMethod::kCat16 ? "cat16" : "bradford"},
      {"step_nm", viewing.step == SummationStep::k1nm ? 1 : 5},
      {"dye_density", triple_json(viewing.dyes.density)},
      {"dye_fading", triple_json(viewing.dyes.fading)},
      {"white_balance", triple_json(recipe.white_balance)},
      {"output_from_process", matrix_json(make_color_model(recipe).output_from_process)}};
  if (!recipe.primaries.notes.empty()) object["primaries_notes"] = recipe.primaries.notes;
  return object;
}

Matrix3 srgb_from_output(const ColorRecipe& recipe) {
  if (recipe.space == OutputSpace::kSrgbLinear) return kIdentity3;
  ColorRecipe plain = recipe;
  plain.white_balance = {1, 1, 1};
  const Matrix3 output = make_color_model(plain).output_from_process;
  plain.space = OutputSpace::kSrgbLinear;
  return multiply(make_color_model(plain).output_from_process, inverse(output));
}

}  // namespace reseau
