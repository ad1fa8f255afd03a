#include <charconv>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/verbs.h"
#include "capture/compare/compare.h"
#include "capture/compare/compare_json.h"
#include "capture/compare/error_map.h"
#include "core/base/error.h"

namespace reseau::cli {

namespace {

using compare::CompareOptions;
using compare::Comparison;
using compare::Rect;

struct CompareArguments {
  std::string a, b, map, crop, roi, offset;
  std::string registration_a, registration_b;
  std::string fit = "none", white = "D65", layer = "auto";
  double worst_percent = 1, full_scale = 0;
  CompareOptions compare;
};

// "12,-3" and the like.
std::vector<int> whole_numbers(const std::string& option, const std::string& text, std::size_t n,
                               const char* form) {
  std::vector<int> values;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (values.size() < n) {
    int value = 0;
    const auto read = std::from_chars(at, end, value);
    if (read.ec != std::errc()) break;
    values.push_back(value);
    at = read.ptr;
    if (values.size() == n || at == end || *at != ',') break;
    ++at;
  }
  if (values.size() != n || at != end) {
    throw InputError(fmt::format("{} takes whole pixels as {}, not '{}'.", option, form, text));
  }
  return values;
}

Rect rect_of(const std::string& option, const std::string& text) {
  const std::vector<int> v = whole_numbers(option, text, 4, "x,y,width,height");
  return {v[0], v[1], v[2], v[3]};
}

CompareOptions compare_options(const CompareArguments& options) {
  CompareOptions result = options.compare;
  result.fit = compare::parse_fit(options.fit);
  result.white = compare::parse_lab_white(options.white);
  result.layer = compare::parse_layer(options.layer);
  if (!options.crop.empty()) result.crop = rect_of("--crop", options.crop);
  if (!options.roi.empty()) result.edge = rect_of("--roi", options.roi);
  if (!options.offset.empty()) {
    const std::vector<int> v = whole_numbers("--offset", options.offset, 2, "x,y");
    result.offset_x_px = v[0];
    result.offset_y_px = v[1];
  }
  result.worst_fraction = options.worst_percent / 100;
  result.map_a = options.registration_a;
  result.map_b = options.registration_b;
  return result;
}

ExitCode run_compare(const CompareArguments& options, Work& work) {
  const CompareOptions settings = as_failure(Doing::kReadingOptions, [&] {
    if (!options.map.empty()) compare::check_error_map_name(options.map);
    return compare_options(options);
  });
  if (!options.map.empty()) refuse_existing(options.map);
  const std::optional<Comparison> c = as_failure(Doing::kReadingInput, [&] {
    return compare::compare_files(options.a, options.b, settings, work.signals.stop());
  });
  if (!c) {
    work.reporter.warning("Stopped.");
    return kExitCancelled;
  }
  nlohmann::ordered_json object = compare::comparison_to_json(*c, settings);
  if (!options.map.empty()) {
    if (!c->color) {
      throw Failure(kExitInput, "There is no colour difference to draw: " + c->no_color);
    }
    as_failure(Doing::kWriting,
               [&] { compare::write_error_map(*c, options.full_scale, options.map); });
    object["map"] = options.map;
  }
  work.reporter.result_json(object);
  for (const std::string& line : compare::describe_comparison(*c, settings)) {
    work.reporter.result_line(line);
  }
  for (const std::string& note : c->notes_a) work.reporter.note("A: " + note);
  for (const std::string& note : c->notes_b) work.reporter.note("B: " + note);
  for (const std::string& warning : c->warnings) work.reporter.warning(warning);
  return kExitOk;
}

void add_color_options(CLI::App& app, CompareArguments& options) {
  app.add_option("--fit", options.fit,
                 "none (default), gain: one factor on B, white: mean colour of B onto that of A")
      ->check(CLI::IsMember({"none", "gain", "white"}))
      ->group("Colour");
  app.add_option("--lab-white", options.white,
                 "White of CIELAB: D65 (default) or another after Bradford adaptation; own: (1, 1, "
                 "1) of each picture")
      ->check(CLI::IsMember({"D65", "D50", "A", "B", "C", "E", "own"}))
      ->group("Colour");
  app.add_option("--worst", options.worst_percent,
                 "Percent of the pixels, the worst, left out of the trimmed figures; default 1")
      ->check(CLI::Range(0.0, 99.0))
      ->group("Colour");
  app.add_flag("--clamp", options.compare.clamp_xyz, "Clamp X, Y and Z to 0..1 before CIELAB")
      ->group("Colour");
  app.add_flag("--adapt", options.compare.adapt_own_white,
               "Take each picture's own (1, 1, 1) as white and adapt it to D65 (Bradford)")
      ->group("Colour");
  app.add_flag("--linear", options.compare.untagged_is_linear,
               "TIFF and PNG without a profile are linear instead of sRGB")
      ->group("Colour");
  app.add_option(
         "--layer", options.layer,
         "Of a truth: element intensities, what the camera saw, or (default) what suits the "
         "other picture")
      ->check(CLI::IsMember({"auto", "process", "scene"}))
      ->group("Colour");
}

void add_place_options(CLI::App& app, CompareArguments& options) {
  app.add_option("--crop", options.crop, "Only this part of A [px]")
      ->type_name("X,Y,W,H")
      ->group("Place");
  app.add_option("--border", options.compare.border_px, "Leave out this many pixels on every side")
      ->check(CLI::Range(0, 1000000))
      ->group("Place");
  app.add_option("--offset", options.offset, "Pixel of B where pixel 0,0 of A is")
      ->type_name("X,Y")
      ->group("Place");
  app.add_option("--roi", options.roi, "Where the slanted edge is in A; otherwise it is searched")
      ->type_name("X,Y,W,H")
      ->group("Place");
}

}  // namespace

void add_compare(Program& program) {
  auto options = std::make_shared<CompareArguments>();
  CLI::App* app = program.add_verb(
      "compare",
      "Compares two pictures, or a result with its truth, pixel by pixel: colour difference "
      "(CIEDE2000),\nregistration error (where both carry u and v), resolution at a slanted edge, "
      "noise, shift. A is the\nreference. OpenEXR, TIFF and PNG, each with the colours it "
      "declares; "
      "a truth is seen through the\nprimaries of the result beside it.",
      "reseau compare truth.exr pictures/film.exr --map error.svg\n"
      "reseau compare box3_07.exr again/box3_07.exr --fit gain --json",
      [options](Work& work) { return run_compare(*options, work); });
  app->add_option("A", options->a, "The reference: a picture, a truth or a map")->required();
  app->add_option("B", options->b, "What is compared with it")->required();
  app->add_option("--map", options->map,
                  "Write the colour difference as a picture with scales, .svg or .png; must not "
                  "exist")
      ->group("Files");
  app->add_option("--full-scale", options->full_scale,
                  "ΔE2000 at the end of the scale of --map; default the 99th percentile")
      ->check(CLI::PositiveNumber)
      ->group("Files");
  app->add_option("--registration-a", options->registration_a,
                  "EXR with u and v of A, as 'register --map' writes it")
      ->group("Files");
  app->add_option("--registration-b", options->registration_b, "The same of B")->group("Files");
  add_color_options(*app, *options);
  add_place_options(*app, *options);
  program.prints_own_json(app);
}

}  // namespace reseau::cli
