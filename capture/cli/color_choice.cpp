#include "capture/cli/color_choice.h"

#include <charconv>

#include <fmt/format.h>

#include "capture/cli/failure.h"
#include "capture/color/primaries_file.h"
#include "core/base/error.h"

namespace reseau::cli {

Vector3 parse_triple(const std::string& word, const std::string& option) {
  Vector3 out{};
  const char* at = word.data();
  const char* const end = at + word.size();
  std::size_t n = 0;
  while (n < 3) {
    const auto [next, error] = std::from_chars(at, end, out[n]);
    if (error != std::errc()) break;
    ++n;
    at = next;
    if (at == end || *at != ',') break;
    ++at;
  }
  if (at != end || (n != 1 && n != 3)) {
    throw InputError(fmt::format(
        "{} {} is not understood; give one number, or three for red, green and blue as 1,0.9,1.",
        option, word));
  }
  return n == 1 ? Vector3{out[0], out[0], out[0]} : out;
}

void ColorChoice::add_to(CLI::App& app, bool with_primaries, bool with_space) {
  const char* const group = "Colour";
  if (with_space) {
    app.add_option("--space", space,
                   "process, xyz, srgb-linear (default), display-p3, rec2020, prophoto, aces-ap0 "
                   "or film")
        ->group(group);
  }
  if (with_primaries) {
    app.add_option("--primaries", primaries,
                   "Colours of the elements: a name of 'reseau colour list', or a CSV file")
        ->group(group);
  }
  app.add_option("--balance", balance, "none, brightness, neutral (default) or bradford")
      ->group(group);
  app.add_option("--light,--illuminant", light,
                 "Light behind the film: A B C D50 D55 D65 (default) D75 E, 3200K, planck:5000")
      ->group(group);
  app.add_option("--areas", areas, "Areas of the elements: 42,27,31 or a screen of 'colour list'")
      ->group(group);
  app.add_option("--dye-density", dye_density, "Dye in the elements, 1 as printed; one or R,G,B")
      ->group(group);
  app.add_option("--dye-fading", dye_fading, "Share of the dye that is gone, 0..1; one or R,G,B")
      ->group(group);
  app.add_option("--white-balance", white_balance, "Factors on the elements; one or R,G,B")
      ->group(group);
  app.add_option("--adaptation", adaptation, "bradford (default) or cat16")->group(group);
  app.add_option("--step-nm", step, "Sums over spectra in steps of 5 (default) or 1 nm")
      ->group(group);
}

ColorRecipe ColorChoice::resolve(Reporter& reporter) const {
  ColorRecipe recipe;
  recipe.space = parse_output_space(space);
  recipe.balance = parse_balance(balance);
  recipe.areas = parse_areas(areas);
  recipe.viewing.light = parse_light(light);
  recipe.viewing.adaptation = parse_adaptation(adaptation);
  recipe.viewing.step = parse_summation_step(step);
  recipe.viewing.dyes.density = parse_triple(dye_density, "--dye-density");
  recipe.viewing.dyes.fading = parse_triple(dye_fading, "--dye-fading");
  recipe.white_balance = parse_triple(white_balance, "--white-balance");
  if (!primaries.empty()) {
    const Doing doing =
        names_primaries_file(primaries) ? Doing::kReadingInput : Doing::kReadingOptions;
    recipe.primaries = as_failure(doing, [&] { return load_primary_set(primaries); });
  }
  // What was assumed stands before what may be wrong because of it.
  for (const std::string& note : recipe.primaries.notes) {
    reporter.note(recipe.primaries.name + ": " + note);
  }
  // Fails now for colours that cannot be.
  static_cast<void>(make_color_model(recipe));
  return recipe;
}

}  // namespace reseau::cli
