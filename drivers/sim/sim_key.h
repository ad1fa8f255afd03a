// One setting of a simulated device's name.
#pragma once

#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include "drivers/sim/sim_spec.h"

namespace reseau::sim {

// For the setters: a NumberKey with `whole` has been checked to be a whole number in range.
[[nodiscard]] inline int as_int(double v) { return static_cast<int>(v); }

struct NumberKey {
  std::string_view name;
  double min, max;
  bool whole;  // whole numbers only
  std::string_view meaning;
  std::function<void(SimSpec&, double)> set;
};

struct WordKey {
  std::string_view name;
  std::map<std::string_view, std::function<void(SimSpec&)>> words;
  std::string_view meaning;
  // Other names of the same words; '-' counts as '_' besides.
  std::map<std::string_view, std::string_view> also{};
};

// Those of the film.
[[nodiscard]] const std::vector<WordKey>& film_word_keys();
[[nodiscard]] const std::vector<NumberKey>& film_keys();
// scene=FILE and image=FILE. Says whether it took the setting.
[[nodiscard]] bool apply_picture(SimSpec& spec, std::string_view name, std::string_view value);
// Throws InputError for settings that do not go together.
void check_film(const FilmSpec& spec);

// Those of lens, stage and sensor.
[[nodiscard]] const std::vector<NumberKey>& scanner_keys();

// Lens, apertures, stage and sensor as fitted to a razor's edge scanned by an LS-9000 (OPTICS.md).
void set_coolscan(SimSpec& spec);

}  // namespace reseau::sim
