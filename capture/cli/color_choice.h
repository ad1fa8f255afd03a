// The options that decide about colour, the same for every verb that has colours.
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "capture/cli/reporter.h"
#include "core/color/element_color.h"

namespace reseau::cli {

struct ColorChoice {
  std::string space = "srgb-linear";
  std::string primaries;  // empty: the default
  std::string balance = "neutral";
  std::string areas = "dufaycolor";
  std::string light = "D65";
  std::string adaptation = "bradford";
  std::string step = "5";
  std::string dye_density = "1";
  std::string dye_fading = "0";
  std::string white_balance = "1";

  // All options; the space and the primaries only where the verb has a use for them.
  void add_to(CLI::App& app, bool with_primaries = true, bool with_space = true);
  // InputError for what cannot be; what was assumed about a table is said on the reporter.
  [[nodiscard]] ColorRecipe resolve(Reporter& reporter) const;
};

// One number for all elements, or three "1,0.9,1". InputError, naming the option.
[[nodiscard]] Vector3 parse_triple(const std::string& word, const std::string& option);

}  // namespace reseau::cli
