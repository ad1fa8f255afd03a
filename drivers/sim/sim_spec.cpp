#include "drivers/sim/sim_spec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/sim/pie/pie_model.h"
#include "drivers/sim/sim_key.h"
#include "drivers/sim/unit_model.h"

namespace reseau::sim {
namespace {

using Key = NumberKey;

const std::vector<WordKey>& word_keys() {
  static const std::vector<WordKey> keys{
      {"optics",
       {{"coolscan", set_coolscan}, {"plain", [](SimSpec& s) { s.optics = {}, s.stage = {}; }}},
       "lens, apertures and stage as measured, or Gaussians under a perfect stage; goes first"},
      {"adapter",
       {{"none", [](SimSpec& s) { s.unit.adapter = AdapterKind::kNone; }},
        {"sa21", [](SimSpec& s) { s.unit.adapter = AdapterKind::kSa21; }},
        {"sa30", [](SimSpec& s) { s.unit.adapter = AdapterKind::kSa30; }},
        {"mount", [](SimSpec& s) { s.unit.adapter = AdapterKind::kMount; }},
        {"aps", [](SimSpec& s) { s.unit.adapter = AdapterKind::kAps; }},
        {"feeder", [](SimSpec& s) { s.unit.adapter = AdapterKind::kFeeder; }}},
       "strip of up to 6 frames, roll, slide mount, APS, slide feeder, or nothing"},
  };
  return keys;
}

const std::vector<Key>& number_keys() {
  static const std::vector<Key> keys{
      {"wobble_px", 0, 20, false, "largest error of the stage",
       [](SimSpec& s, double v) { s.stage.wobble_px = v; }},
      {"blur_px", 0, 10, false, "standard deviation of the blur in red, green and blue",
       [](SimSpec& s, double v) {
         s.optics.blur_px[0] = s.optics.blur_px[1] = s.optics.blur_px[2] = v;
       }},
      {"ir_blur_px", 0, 10, false, "standard deviation of the blur in infrared",
       [](SimSpec& s, double v) { s.optics.blur_px[3] = v; }},
      {"aperture_px", 0.5, 4, false, "width over which a pixel integrates",
       [](SimSpec& s, double v) { s.optics.aperture_px = v; }},
      {"cells", 0, 16, true, "cells per pixel of the numerical integration; 0 as many as needed",
       [](SimSpec& s, double v) { s.optics.cells_per_px = as_int(v); }},
      {"noise", 0, 0.5, false, "standard deviation at full scale [fraction of full scale]",
       [](SimSpec& s, double v) { s.sensor.noise = v; }},
      {"bits", 8, 16, true, "of the A/D converter when no unit stands in between",
       [](SimSpec& s, double v) { s.sensor.adc_bits = as_int(v); }},
      {"level", 0.01, 10, false, "fraction of full scale that bare light reaches",
       [](SimSpec& s, double v) { s.sensor.clear_level = v; }},
      {"seed", 0, 9007199254740992.0, true, "of noise and scene",
       [](SimSpec& s, double v) { s.film.seed = static_cast<std::uint64_t>(v); }},
      {"cold", 0, 1, true, "the unit was just switched on",
       [](SimSpec& s, double v) { s.unit.cold = v != 0; }},
      {"film_arrives", 0, 100000, true, "film is pushed in after so many polls",
       [](SimSpec& s, double v) { s.unit.film_arrives_polls = as_int(v); }},
      {"busy_polls", 0, 100000, true, "polls that an operation stays busy",
       [](SimSpec& s, double v) { s.unit.busy_polls = as_int(v); }},
      {"busy_phases", 0, 1000, true, "phase queries an image READ answers with busy",
       [](SimSpec& s, double v) { s.unit.busy_phases = as_int(v); }},
      {"fragment", 0, 1048576, true, "longest IN transfer in bytes (0 = any)",
       [](SimSpec& s, double v) { s.unit.fragment_bytes = as_int(v); }},
      {"old_lut", 0, 1, true, "another program left a gamma curve in the unit",
       [](SimSpec& s, double v) { s.unit.old_lut = v != 0; }},
      {"focus_fails", 0, 1, true, "autofocus ends with an error",
       [](SimSpec& s, double v) { s.unit.focus_fails = v != 0; }},
      {"stale", 0, 1048576, true, "bytes an earlier program left in the pipe",
       [](SimSpec& s, double v) { s.unit.stale_bytes = as_int(v); }},
      {"unplug_after", 0, 1e9, true, "transfers until the unit is gone (0 = never)",
       [](SimSpec& s, double v) { s.unit.unplug_after = as_int(v); }},
      {"stall_after", 0, 1e9, true, "transfers until one stalls (0 = never)",
       [](SimSpec& s, double v) { s.unit.stall_after = as_int(v); }},
      {"again", 0, 1000, true, "PIE: times that the first READ of a pass has to come again",
       [](SimSpec& s, double v) { s.unit.again = as_int(v); }},
      {"bottom_up", 0, 1, true, "PIE: passes are read with the carriage coming back",
       [](SimSpec& s, double v) { s.unit.bottom_up = v != 0; }},
      {"silent_after", 0, 1e9, true, "transfers until the unit stops answering (0 = never)",
       [](SimSpec& s, double v) { s.unit.silent_after = as_int(v); }},
      {"timeout_after", 0, 1e9, true, "transfers until one gets no answer in time (0 = never)",
       [](SimSpec& s, double v) { s.unit.timeout_after = as_int(v); }},
      {"short_after", 0, 1e9, true, "transfers until half of one is lost (0 = never)",
       [](SimSpec& s, double v) { s.unit.short_after = as_int(v); }},
      {"garbage_after", 0, 1e9, true, "statuses until one is noise (0 = never)",
       [](SimSpec& s, double v) { s.unit.garbage_after = as_int(v); }},
      {"full_speed", 0, 1, true, "behind a cable or hub of full speed",
       [](SimSpec& s, double v) { s.unit.full_speed = v != 0; }},
      {"early_end", 0, 1, true, "a thumbnail ends with the film",
       [](SimSpec& s, double v) { s.unit.early_end = v != 0; }},
      {"lost_commands", 0, 100000, true,
       "of so many commands one is answered busy and lost (LS-40)",
       [](SimSpec& s, double v) { s.unit.lost_commands = as_int(v); }},
      {"slides", 0, 50, true, "in the magazine of adapter=feeder",
       [](SimSpec& s, double v) { s.unit.feeder_slides = as_int(v); }},
  };
  return keys;
}

std::vector<WordKey> all_word_keys() {
  std::vector<WordKey> keys = film_word_keys();
  keys.insert(keys.end(), word_keys().begin(), word_keys().end());
  return keys;
}

std::string number_text(double v) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, v);
  return {buffer, end.ptr};
}

std::string quoted(std::string_view text) {
  std::string result(text);
  result.insert(result.begin(), '"');
  result.push_back('"');
  return result;
}

double parse_number(const Key& key, std::string_view text) {
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool read = result.ec == std::errc() && result.ptr == text.data() + text.size();
  if (!read || !std::isfinite(value) || value < key.min || value > key.max ||
      (key.whole && value != std::floor(value))) {
    throw InputError("The simulated device cannot use " + quoted(text) + " for " +
                     quoted(key.name) + ": give a " + (key.whole ? "whole " : "") + "number from " +
                     number_text(key.min) + " to " + number_text(key.max) + ".");
  }
  return value;
}

// Letters to change, leave out or put in to make one word the other (Levenshtein).
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

// The lines of the help whose keys resemble the name most.
std::string nearest_settings(std::string_view name) {
  constexpr std::size_t kShown = 3;
  std::vector<std::pair<std::size_t, std::string>> lines;
  std::istringstream help(sim_key_help());
  for (std::string line; std::getline(help, line);) {
    const std::string key = line.substr(2, line.find('=') - 2);
    lines.emplace_back(distance(name, key), line);
  }
  std::ranges::stable_sort(lines, {}, &std::pair<std::size_t, std::string>::first);
  std::string text;
  for (std::size_t i = 0; i < kShown; ++i) text.append(lines[i].second).append("\n");
  return text;
}

void apply(SimSpec& spec, std::string_view name, std::string_view value) {
  if (apply_picture(spec, name, value)) return;
  std::string asked(value);
  std::ranges::replace(asked, '-', '_');
  for (const WordKey& key : all_word_keys()) {
    if (key.name != name) continue;
    const auto also = key.also.find(asked);
    const auto found = key.words.find(also != key.also.end() ? also->second : asked);
    if (found != key.words.end()) return found->second(spec);
    std::string known;
    for (const auto& [word, set] : key.words) {
      if (!known.empty()) known.append(", ");
      known.append(quoted(word));
    }
    throw InputError("The simulated device does not know " + quoted(name) + "=" + quoted(value) +
                     "; known are " + known +
                     (name == "scene" ? ", and the name of an image file that exists." : "."));
  }
  for (const std::vector<Key>* keys : {&film_keys(), &number_keys(), &scanner_keys()}) {
    for (const Key& key : *keys) {
      if (key.name == name) return key.set(spec, parse_number(key, value));
    }
  }
  throw InputError("The simulated device has no setting " + quoted(name) + ". The nearest are:\n" +
                   nearest_settings(name) + "`reseau simulate --help` lists all.");
}

// The settings of a name: those that choose a screen or optics, or all others.
void apply_all(SimSpec& spec, std::string_view query, bool choices) {
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    const std::string_view pair = query.substr(0, end);
    query = end == std::string_view::npos ? "" : query.substr(end + 1);
    if (pair.empty()) continue;
    const std::size_t equals = pair.find('=');
    if (equals == std::string_view::npos) {
      throw InputError("In the name of a simulated device every setting has a value: " +
                       quoted(pair) + " should read key=value.");
    }
    const std::string_view name = pair.substr(0, equals);
    if ((name == "film" || name == "screen" || name == "optics") == choices) {
      apply(spec, name, pair.substr(equals + 1));
    }
  }
}

void check_together(const SimSpec& spec) {
  if (spec.unit.fragment_bytes % 512 != 0) {
    throw InputError("A simulated transfer ends at a packet: make fragment a multiple of 512.");
  }
  check_film(spec.film);
}

}  // namespace

SimSpec parse_sim_spec(std::string_view name, ScenePicture picture) {
  constexpr std::string_view kPrefix = "sim:";
  if (name.substr(0, kPrefix.size()) == kPrefix) name.remove_prefix(kPrefix.size());
  const std::size_t mark = name.find('?');
  SimSpec spec;
  spec.model = std::string(name.substr(0, mark));
  // The film lies under this unit's pixels.
  if (const UnitModel* const model = find_unit_model(spec.model)) {
    spec.film.frame.width_px = model->sensor_px;
    spec.film.frame.height_px = model->frame_height_px;
    spec.film.frame.pixel_um = spec.optics.pixel_um = 25400.0 / model->optical_dpi;
  } else if (const pie::PieModel* const pie_model = pie::find_pie_model(spec.model)) {
    pie::set_pie_defaults(*pie_model, spec);
  }
  const std::string_view settings = mark == std::string_view::npos ? "" : name.substr(mark + 1);
  // First what sets several values that other keys may change.
  for (const bool choices : {true, false}) apply_all(spec, settings, choices);
  spec.optics.pixel_um = spec.film.frame.pixel_um;
  check_together(spec);
  if (picture == ScenePicture::kLoad) load_picture(spec.film);
  return spec;
}

std::string sim_key_help() {
  std::string text;
  for (const WordKey& key : all_word_keys()) {
    std::string words;
    for (const auto& [word, set] : key.words) {
      if (!words.empty()) words.push_back('|');
      words.append(word);
    }
    text.append("  ").append(key.name).append("=").append(words);
    text.append("  ").append(key.meaning).append("\n");
  }
  text.append(
      "  image=FILE  what the camera saw, in place of scene; any picture OpenImageIO reads\n");
  std::vector<Key> numbers = film_keys();
  numbers.insert(numbers.end(), number_keys().begin(), number_keys().end());
  numbers.insert(numbers.end(), scanner_keys().begin(), scanner_keys().end());
  for (const Key& key : numbers) {
    text.append("  ").append(key.name).append("=").append(number_text(key.min));
    text.append("..").append(number_text(key.max));
    text.append("  ").append(key.meaning).append("\n");
  }
  return text;
}

}  // namespace reseau::sim
