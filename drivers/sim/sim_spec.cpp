#include "drivers/sim/sim_spec.h"

#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "drivers/sim/sim_key.h"

namespace reseau::sim {
namespace {

using Key = NumberKey;

struct WordKey {
  std::string_view name;
  std::map<std::string_view, std::function<void(SimSpec&)>> words;
  std::string_view meaning;
};

int as_int(double v) { return static_cast<int>(v); }

template <ScreenKind kKind>
void set_screen(SimSpec& s) {
  set_screen_kind(s.film.screen, kKind);
}
template <DyeSource kSource>
void set_dyes(SimSpec& s) {
  s.film.dyes.source = kSource;
}

const std::vector<WordKey>& word_keys() {
  static const std::vector<WordKey> keys{
      {"film",
       {{"dufay", [](SimSpec& s) { s.film.kind = FilmKind::kDufay; }},
        {"none", [](SimSpec& s) { s.film.kind = FilmKind::kPlain; }},
        {"empty", [](SimSpec& s) { s.film.kind = FilmKind::kEmpty; }}},
       "Dufaycolor, a silver picture without a réseau, or no film"},
      {"scene",
       {{"chart", [](SimSpec& s) { s.film.scene = SceneKind::kChart; }},
        {"chart24", [](SimSpec& s) { s.film.scene = SceneKind::kChart; }},
        {"edges", [](SimSpec& s) { s.film.scene = SceneKind::kEdges; }},
        {"image", [](SimSpec& s) { s.film.scene = SceneKind::kImage; }},
        {"natural", [](SimSpec& s) { s.film.scene = SceneKind::kNatural; }},
        {"star", [](SimSpec& s) { s.film.scene = SceneKind::kStar; }},
        {"sweep", [](SimSpec& s) { s.film.scene = SceneKind::kSweep; }},
        {"zone", [](SimSpec& s) { s.film.scene = SceneKind::kZone; }}},
       "what the camera saw"},
      {"optics",
       {{"coolscan", set_coolscan}, {"plain", [](SimSpec& s) { s.optics = {}, s.stage = {}; }}},
       "lens, apertures and stage as measured, or Gaussians under a perfect stage; goes first"},
      {"screen",
       {{"dioptichrome", set_screen<ScreenKind::kDioptichrome>},
        {"dufay", set_screen<ScreenKind::kDufay>},
        {"finlay", set_screen<ScreenKind::kFinlay>},
        {"improved_dioptichrome", set_screen<ScreenKind::kImprovedDioptichrome>},
        {"joly", set_screen<ScreenKind::kJoly>},
        {"omnicolore", set_screen<ScreenKind::kOmnicolore>},
        {"paget", set_screen<ScreenKind::kPaget>},
        {"spicer_dufay_blue", set_screen<ScreenKind::kSpicerDufayBlue>},
        {"spicer_dufay_green", set_screen<ScreenKind::kSpicerDufayGreen>},
        {"thames", set_screen<ScreenKind::kThames>},
        {"warner_powrie", set_screen<ScreenKind::kWarnerPowrie>}},
       "the réseau of film=dufay, with its usual periods and fractions"},
      {"dyes",
       {{"collins_giles", set_dyes<DyeSource::kCollinsGiles>},
        {"cornwell_clyne", set_dyes<DyeSource::kCornwellClyne>},
        {"dioptichrome", set_dyes<DyeSource::kDioptichrome>},
        {"harrison_horner", set_dyes<DyeSource::kHarrisonHorner>},
        {"measured", set_dyes<DyeSource::kMeasured>},
        {"neblette", set_dyes<DyeSource::kNeblette>},
        {"thames", set_dyes<DyeSource::kThames>}},
       "as a scanner measured them, or printed spectra seen by LEDs"},
      {"taking",
       {{"dufay", [](SimSpec& s) { s.film.emulsion.ideal_taking = false; }},
        {"ideal", [](SimSpec& s) { s.film.emulsion.ideal_taking = true; }}},
       "how elements divide the camera's light: with overlap, or each its own third"},
      {"gap",
       {{"clear", [](SimSpec& s) { s.film.print.dark_gaps = false; }},
        {"dark", [](SimSpec& s) { s.film.print.dark_gaps = true; }}},
       "what lies between elements where overlap_um is negative"},
      {"adapter",
       {{"sa21", [](SimSpec& s) { s.unit.adapter = AdapterKind::kSa21; }},
        {"sa30", [](SimSpec& s) { s.unit.adapter = AdapterKind::kSa30; }}},
       "strip film adapter: up to 6 frames, or a roll"},
  };
  return keys;
}

const std::vector<Key>& number_keys() {
  static const std::vector<Key> keys{
      {"angle", -360, 360, false, "red lines from the y axis [degree]",
       [](SimSpec& s, double v) { s.film.screen.angle_deg = v; }},
      {"axes", 80, 100, false, "between the two directions of the réseau [degree]",
       [](SimSpec& s, double v) { s.film.screen.axes_deg = v; }},
      {"period_um", 20, 400, false, "both periods of the réseau",
       [](SimSpec& s, double v) { s.film.screen.period_u_um = s.film.screen.period_v_um = v; }},
      {"period_u_um", 20, 400, false, "period along the red lines",
       [](SimSpec& s, double v) { s.film.screen.period_u_um = v; }},
      {"period_v_um", 20, 400, false, "period across the red lines",
       [](SimSpec& s, double v) { s.film.screen.period_v_um = v; }},
      {"phase_u", -1e6, 1e6, false, "screen coordinate u of the first pixel",
       [](SimSpec& s, double v) { s.film.screen.phase_u = v; }},
      {"phase_v", -1e6, 1e6, false, "screen coordinate v of the first pixel",
       [](SimSpec& s, double v) { s.film.screen.phase_v = v; }},
      {"red_fraction", 0.05, 0.95, false, "width of the lines (Dufaycolor: red) [period]",
       [](SimSpec& s, double v) { s.film.screen.red_fraction = v; }},
      {"green_fraction", 0.05, 0.95, false,
       "length of the first kind of square (Dufaycolor: green) [period]",
       [](SimSpec& s, double v) { s.film.screen.green_fraction = v; }},
      {"bend_px", 0, 100, false, "largest smooth displacement of the réseau",
       [](SimSpec& s, double v) { s.film.screen.bend_px = v; }},
      {"mirrored", 0, 1, true, "film laid in the other way round",
       [](SimSpec& s, double v) { s.film.mirrored = v != 0; }},
      {"wobble_px", 0, 20, false, "largest error of the stage",
       [](SimSpec& s, double v) { s.stage.wobble_px = v; }},
      {"fade", 0, 1, false, "0 fresh dyes, 1 grey elements",
       [](SimSpec& s, double v) { s.film.dyes.fade = v; }},
      {"edge_angle", -89, 89, false, "of the borders of scene=edges from the y axis [degree]",
       [](SimSpec& s, double v) { s.film.edge_angle_deg = v; }},
      {"finest", 0.01, 8, false, "frequency of scene=zone at half its smaller side [cycles/px]",
       [](SimSpec& s, double v) { s.film.finest_cy_per_px = v; }},
      {"spokes", 2, 720, true, "of scene=star",
       [](SimSpec& s, double v) { s.film.spokes = as_int(v); }},
      {"outside_px", 0, 2000, false, "bare light beside the film, inside the frame",
       [](SimSpec& s, double v) { s.film.frame.outside_px = v; }},
      {"perspective_x", -0.05, 0.05, false, "change of scale from the middle to the side",
       [](SimSpec& s, double v) { s.film.deform.perspective_x = v; }},
      {"perspective_y", -0.05, 0.05, false, "change of scale from the middle to the end",
       [](SimSpec& s, double v) { s.film.deform.perspective_y = v; }},
      {"radial", -0.05, 0.05, false, "relative displacement in the corner of the frame",
       [](SimSpec& s, double v) { s.film.deform.radial = v; }},
      {"warp_px", 0, 20, false, "amplitude of a shorter wave in the réseau, both axes",
       [](SimSpec& s, double v) { s.film.deform.warp_px = v; }},
      {"warp_length_px", 60, 20000, false, "its length",
       [](SimSpec& s, double v) { s.film.deform.warp_length_px = v; }},
      {"curl_um", -3000, 3000, false, "height of the film's sides above its middle",
       [](SimSpec& s, double v) { s.film.deform.curl_um = v; }},
      {"overlap_um", -10, 10, false, "of neighbouring elements; negative: a gap between them",
       [](SimSpec& s, double v) { s.film.print.overlap_um = v; }},
      {"position_noise_um", 0, 10, false, "rms displacement of printed lines and elements",
       [](SimSpec& s, double v) { s.film.print.position_noise_um = v; }},
      {"width_noise_um", 0, 10, false, "rms variation of their width",
       [](SimSpec& s, double v) { s.film.print.width_noise_um = v; }},
      {"noise_length_um", 20, 100000, false, "along a line, over which its errors change",
       [](SimSpec& s, double v) { s.film.print.noise_length_um = v; }},
      {"missing", 0, 0.5, false, "fraction of lines and elements that were not printed",
       [](SimSpec& s, double v) { s.film.print.missing = v; }},
      {"hd_gamma", 0, 4, false,
       "slope of density against log exposure; 0: transmittance = exposure",
       [](SimSpec& s, double v) { s.film.emulsion.hd.gamma = v; }},
      {"hd_dmin", 0, 1, false, "density of full exposure",
       [](SimSpec& s, double v) { s.film.emulsion.hd.d_min = v; }},
      {"hd_dmax", 1.2, 5, false, "density without exposure",
       [](SimSpec& s, double v) { s.film.emulsion.hd.d_max = v; }},
      {"hd_toe", 0.01, 1, false, "density over which either end of the curve bends",
       [](SimSpec& s, double v) { s.film.emulsion.hd.toe = v; }},
      {"hd_speed", -2, 2, false, "log exposure at which the straight line reaches hd_dmin",
       [](SimSpec& s, double v) { s.film.emulsion.hd.log_speed = v; }},
      {"spread_um", 0, 20, false, "standard deviation of the light's spread in the emulsion",
       [](SimSpec& s, double v) { s.film.emulsion.spread_um = v; }},
      {"silver_spread_um", 0, 20, false, "standard deviation of the silver's spread",
       [](SimSpec& s, double v) { s.film.emulsion.silver_spread_um = v; }},
      {"grain", 0, 0.5, false, "relative rms of a pixel's silver at density 1",
       [](SimSpec& s, double v) { s.film.emulsion.grain = v; }},
      {"grain_um", 1, 50, false, "size of the grain",
       [](SimSpec& s, double v) { s.film.emulsion.grain_um = v; }},
      {"ir_leak", 0, 1, false, "dye density in infrared, of that in red light",
       [](SimSpec& s, double v) { s.film.dyes.infrared_leak = v; }},
      {"dust", 0, 1000, false, "specks and hairs per square centimetre",
       [](SimSpec& s, double v) { s.film.damage.dust_per_cm2 = v; }},
      {"dust_um", 2, 500, false, "typical radius of a speck",
       [](SimSpec& s, double v) { s.film.damage.dust_um = v; }},
      {"scratches", 0, 100, false, "per centimetre of the film's width",
       [](SimSpec& s, double v) { s.film.damage.scratches_per_cm = v; }},
      {"bubbles", 0, 500, false, "in the gelatine, per square centimetre",
       [](SimSpec& s, double v) { s.film.damage.bubbles_per_cm2 = v; }},
      {"bubble_um", 5, 1000, false, "typical radius of a bubble",
       [](SimSpec& s, double v) { s.film.damage.bubble_um = v; }},
      {"faded_areas", 0, 1, false, "how far dyes are faded in the worst places",
       [](SimSpec& s, double v) { s.film.damage.faded_areas = v; }},
      {"stains", 0, 1, false, "blue light that the darkest stains take",
       [](SimSpec& s, double v) { s.film.damage.stains = v; }},
      {"general", 0, 1, true, "render also a plain film by the general path",
       [](SimSpec& s, double v) { s.film.general_path = v != 0; }},
      {"width_px", 16, 20000, true, "of a frame",
       [](SimSpec& s, double v) { s.film.frame.width_px = as_int(v); }},
      {"height_px", 16, 20000, true, "of a frame",
       [](SimSpec& s, double v) { s.film.frame.height_px = as_int(v); }},
      {"frames", 1, 40, true, "on the strip",
       [](SimSpec& s, double v) { s.film.frame.n_frames = as_int(v); }},
      {"border_px", 0, 2000, false, "dark border around the picture",
       [](SimSpec& s, double v) { s.film.frame.border_px = v; }},
      {"rebate_px", 0, 2000, false, "clear rebate around the border",
       [](SimSpec& s, double v) { s.film.frame.rebate_px = v; }},
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
      {"silent_after", 0, 1e9, true, "transfers until the unit stops answering (0 = never)",
       [](SimSpec& s, double v) { s.unit.silent_after = as_int(v); }},
  };
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

void apply(SimSpec& spec, std::string_view name, std::string_view value) {
  for (const WordKey& key : word_keys()) {
    if (key.name != name) continue;
    const auto found = key.words.find(value);
    if (found != key.words.end()) return found->second(spec);
    std::string known;
    for (const auto& [word, set] : key.words) {
      if (!known.empty()) known.append(", ");
      known.append(quoted(word));
    }
    throw InputError("The simulated device does not know " + quoted(name) + "=" + quoted(value) +
                     "; known are " + known + ".");
  }
  for (const std::vector<Key>* keys : {&number_keys(), &scanner_keys()}) {
    for (const Key& key : *keys) {
      if (key.name == name) return key.set(spec, parse_number(key, value));
    }
  }
  throw InputError("The simulated device has no setting " + quoted(name) + ". Known settings:\n" +
                   sim_key_help());
}

// The settings of a name: the one that chooses the screen, or all others.
void apply_all(SimSpec& spec, std::string_view query, bool screen) {
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
    if ((pair.substr(0, equals) == "screen") == screen) {
      apply(spec, pair.substr(0, equals), pair.substr(equals + 1));
    }
  }
}

void check_together(const SimSpec& spec) {
  if (spec.unit.fragment_bytes % 512 != 0) {
    throw InputError("A simulated transfer ends at a packet: make fragment a multiple of 512.");
  }
  const FrameSpec& frame = spec.film.frame;
  const double margin = frame.border_px + frame.rebate_px;
  if (2 * (margin + frame.outside_px) > frame.width_px - 8 || 2 * margin > frame.height_px - 8) {
    throw InputError(
        "Border and rebate of the simulated film leave no picture; make border_px, rebate_px and "
        "outside_px smaller or the frame larger.");
  }
  const DeformSpec& deform = spec.film.deform;
  if (frame.n_frames > 1 &&
      (deform.perspective_x != 0 || deform.perspective_y != 0 || deform.radial != 0)) {
    throw InputError(
        "Perspective and radial displacement belong to one frame; leave out frames, or "
        "perspective_x, perspective_y and radial.");
  }
  if (deform.warp_px * 2 * 3.1416 > 0.6 * deform.warp_length_px) {
    throw InputError(
        "So short and strong a wave would fold the réseau; make warp_px smaller or warp_length_px "
        "larger.");
  }
}

}  // namespace

SimSpec parse_sim_spec(std::string_view name) {
  constexpr std::string_view kPrefix = "sim:";
  if (name.substr(0, kPrefix.size()) == kPrefix) name.remove_prefix(kPrefix.size());
  const std::size_t mark = name.find('?');
  SimSpec spec;
  spec.model = std::string(name.substr(0, mark));
  const std::string_view settings = mark == std::string_view::npos ? "" : name.substr(mark + 1);
  // The screen first: it sets periods and fractions that other keys may change.
  for (const bool screen : {true, false}) apply_all(spec, settings, screen);
  check_together(spec);
  return spec;
}

std::string sim_key_help() {
  std::string text;
  for (const WordKey& key : word_keys()) {
    std::string words;
    for (const auto& [word, set] : key.words) {
      if (!words.empty()) words.push_back('|');
      words.append(word);
    }
    text.append("  ").append(key.name).append("=").append(words);
    text.append("  ").append(key.meaning).append("\n");
  }
  std::vector<Key> numbers = number_keys();
  numbers.insert(numbers.end(), scanner_keys().begin(), scanner_keys().end());
  for (const Key& key : numbers) {
    text.append("  ").append(key.name).append("=").append(number_text(key.min));
    text.append("..").append(number_text(key.max));
    text.append("  ").append(key.meaning).append("\n");
  }
  return text;
}

}  // namespace reseau::sim
