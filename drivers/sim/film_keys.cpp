#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "drivers/sim/film/picture_file.h"
#include "drivers/sim/film/screen_of.h"
#include "drivers/sim/sim_key.h"

namespace reseau::sim {
namespace {

// "spicer_dufay_blue" of "spicer-dufay-blue"; the short names of before stay the words.
std::string_view word_of(const ScreenName& screen) {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> all;
    for (const ScreenName& s : screen_names()) {
      std::string word(s.name);
      std::ranges::replace(word, '-', '_');
      if (word.starts_with("dufaycolor")) word.erase(5, 5);
      if (word.ends_with("dioptichrome_b")) word.resize(word.size() - 2);
      all.push_back(word);
    }
    return all;
  }();
  return words[static_cast<std::size_t>(screen.kind)];
}

// The screens as words that set them, and their full names.
WordKey with_screens(WordKey key, const std::function<void(SimSpec&, ScreenKind)>& set) {
  static const std::vector<std::string> full_names = [] {
    std::vector<std::string> all;
    for (const ScreenName& s : screen_names()) {
      all.emplace_back(s.name);
      std::ranges::replace(all.back(), '-', '_');
    }
    return all;
  }();
  for (const ScreenName& screen : screen_names()) {
    const std::string_view word = word_of(screen);
    key.words.try_emplace(word, [set, kind = screen.kind](SimSpec& s) { set(s, kind); });
    const std::string& full = full_names[static_cast<std::size_t>(screen.kind)];
    if (full != word) key.also.try_emplace(full, word);
  }
  return key;
}

// A holder with something that measures the scanner, filling its frame.
void set_target(SimSpec& s, SceneKind scene) {
  s.film.kind = FilmKind::kPlain;
  s.film.scene = scene;
  s.film.frame.border_px = 0;
}

template <DyeSource kSource>
void set_dyes(SimSpec& s) {
  s.film.dyes.source = kSource;
}

}  // namespace

const std::vector<WordKey>& film_word_keys() {
  static const std::vector<WordKey> keys{
      with_screens({"film",
                    {{"dufay", [](SimSpec& s) { s.film.kind = FilmKind::kDufay; }},
                     {"none", [](SimSpec& s) { s.film.kind = FilmKind::kPlain; }},
                     {"empty", [](SimSpec& s) { s.film.kind = FilmKind::kEmpty; }},
                     {"random", [](SimSpec& s) { set_target(s, SceneKind::kRandom); }},
                     {"razor", [](SimSpec& s) { set_target(s, SceneKind::kRazor); }},
                     {"clear", [](SimSpec& s) { set_target(s, SceneKind::kClear); }}},
                    "a film with the named screen, a silver picture without a réseau, no film, "
                    "blades with slanted edges, cells that are clear by chance, or a holder with "
                    "an open frame",
                    {}},
                   [](SimSpec& s, ScreenKind kind) {
                     s.film.kind = FilmKind::kDufay;
                     set_screen_kind(s.film.screen, kind);
                   }),
      {"scene",
       {{"chart", [](SimSpec& s) { s.film.scene = SceneKind::kChart; }},
        {"chart24", [](SimSpec& s) { s.film.scene = SceneKind::kChart; }},
        {"clear", [](SimSpec& s) { s.film.scene = SceneKind::kClear; }},
        {"edges", [](SimSpec& s) { s.film.scene = SceneKind::kEdges; }},
        {"image", [](SimSpec& s) { s.film.scene = SceneKind::kImage; }},
        {"natural", [](SimSpec& s) { s.film.scene = SceneKind::kNatural; }},
        {"random", [](SimSpec& s) { s.film.scene = SceneKind::kRandom; }},
        {"razor", [](SimSpec& s) { s.film.scene = SceneKind::kRazor; }},
        {"star", [](SimSpec& s) { s.film.scene = SceneKind::kStar; }},
        {"sweep", [](SimSpec& s) { s.film.scene = SceneKind::kSweep; }},
        {"zone", [](SimSpec& s) { s.film.scene = SceneKind::kZone; }}},
       "what the camera saw; or the name of an image file"},
      with_screens({"screen", {}, "the réseau, with its usual periods and fractions"},
                   [](SimSpec& s, ScreenKind kind) { set_screen_kind(s.film.screen, kind); }),
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
  };
  return keys;
}

const std::vector<NumberKey>& film_keys() {
  static const std::vector<NumberKey> keys{
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
      {"fade", 0, 1, false, "0 fresh dyes, 1 grey elements",
       [](SimSpec& s, double v) { s.film.dyes.fade = v; }},
      {"edge_angle", -89, 89, false,
       "of the borders of scene=edges, film=razor, film=random from the y axis [degree]",
       [](SimSpec& s, double v) { s.film.edge_angle_deg = v; }},
      {"random_cell_um", 1, 50, false, "side of a cell of film=random; which are clear, seed says",
       [](SimSpec& s, double v) { s.film.random_cell_um = v; }},
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
      {"spread_um", 0, 20, false,
       "standard deviation of the light's spread in the emulsion, 0 or from 1 on",
       [](SimSpec& s, double v) { s.film.emulsion.spread_um = v; }},
      {"silver_spread_um", 0, 20, false,
       "standard deviation of the silver's spread, 0 or from 1 on",
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
  };
  return keys;
}

bool apply_picture(SimSpec& spec, std::string_view name, std::string_view value) {
  std::error_code none;
  const bool file = name == "scene" && std::filesystem::is_regular_file(value, none);
  if (name != "image" && !file) return false;
  spec.film.scene = SceneKind::kImage;
  spec.film.picture = std::string(value);
  return true;
}

void load_picture(FilmSpec& film) {
  if (film.picture.empty() || film.raster != nullptr) return;
  film.raster = std::make_shared<SceneRaster>(read_scene_picture(film.picture));
}

void check_film(const FilmSpec& spec) {
  const FrameSpec& frame = spec.frame;
  const double margin = frame.border_px + frame.rebate_px;
  if (2 * (margin + frame.outside_px) > frame.width_px - 8 || 2 * margin > frame.height_px - 8) {
    throw InputError(
        "Border and rebate of the simulated film leave no picture; make border_px, rebate_px and "
        "outside_px smaller or the frame larger.");
  }
  const DeformSpec& deform = spec.deform;
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
  constexpr double kLeastSpreadUm = 1;
  for (const double um : {spec.emulsion.spread_um, spec.emulsion.silver_spread_um}) {
    if (um > 0 && um < kLeastSpreadUm) {
      throw InputError(
          "A spread of less than 1 um is finer than the simulated film is computed; give spread_um "
          "and silver_spread_um 0, or 1 and more.");
    }
  }
}

}  // namespace reseau::sim
