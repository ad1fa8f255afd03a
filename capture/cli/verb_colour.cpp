#include "capture/cli/verb_colour.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/color_choice.h"
#include "capture/cli/develop_choice.h"
#include "capture/cli/verbs.h"
#include "capture/cli/write_text.h"
#include "capture/color/color_plots.h"
#include "capture/color/color_record.h"
#include "capture/session/json_number.h"
#include "core/color/dominant_wavelength.h"
#include "core/color/gamut.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

constexpr std::array<const char*, 3> kElements{"red", "green", "blue"};

struct ShowOptions {
  ColorChoice color;
  std::string svg;
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string kind_of(const PrimarySet& set) {
  if (set.charts) {
    return set.charts->quantity == SpectralQuantity::kDensity ? "spectra (density)" : "spectra";
  }
  return set.stated->luminance ? "x, y, Y" : "x, y";
}

void list_sets(Reporter& reporter, ordered_json& json) {
  json["primaries"] = primary_set_names();
  json["sets"] = ordered_json::array();
  reporter.result_line("Primaries (--primaries); the first is the default");
  for (const PrimarySet& set : primary_sets()) {
    reporter.result_line(fmt::format("  {:<34}{:<19}{}", set.name, kind_of(set), set.about));
    json["sets"].push_back(
        {{"name", set.name}, {"kind", kind_of(set)}, {"about", set.about}, {"source", set.source}});
  }
  reporter.result_line("Single dyes (colour show only)");
  for (const DyeTable& table : dye_tables()) {
    reporter.result_line("  " + table.name);
    ordered_json dyes = ordered_json::array();
    for (const DyeChart& dye : table.dyes) dyes.push_back(dye.name);
    json["dyes"].push_back({{"name", table.name}, {"source", table.source}, {"dyes", dyes}});
  }
}

ExitCode list_colours(Work& work) {
  Reporter& reporter = work.reporter;
  ordered_json json = {{"schema", "reseau-colour-list/1"},
                       {"default", primary_set_names().front()}};
  list_sets(reporter, json);
  reporter.result_line("Areas (--areas), percent of red, green, blue");
  for (const ScreenAreas& screen : screen_areas()) {
    const Vector3& a = screen.share;
    reporter.result_line(fmt::format("  {:<34}{:.2f} {:.2f} {:.2f}", screen.name, 100 * a[0],
                                     100 * a[1], 100 * a[2]));
    json["areas"].push_back({{"name", screen.name}, {"share", {a[0], a[1], a[2]}}});
  }
  reporter.result_line("Lights (--light), x, y");
  for (const char* word : {"A", "B", "C", "D50", "D55", "D65", "D75", "E"}) {
    const Chromaticity xy = chromaticity_of(white_of(parse_light(word), SummationStep::k5nm));
    reporter.result_line(fmt::format("  {:<34}{:.5f} {:.5f}", word, xy[0], xy[1]));
    json["lights"].push_back({{"name", word}, {"xy", {xy[0], xy[1]}}});
  }
  reporter.result_line(
      "  3200K (black body below 4000 K), 5500K (daylight to 25000 K), planck:5000 (black body)");
  std::string spaces;
  for (const std::string& word : output_space_words())
    spaces += (spaces.empty() ? "" : ", ") + word;
  reporter.result_line("Spaces (--space)\n  " + spaces);
  json["spaces"] = output_space_words();
  reporter.result_json(json);
  return kExitOk;
}

// What a set comes to, in text and in JSON at once.
class Sheet {
 public:
  explicit Sheet(const ColorRecipe& recipe)
      : recipe_(recipe),
        model_(make_color_model(recipe)),
        light_(white_of(recipe.viewing.light, recipe.viewing.step)),
        elements_(element_xyz(recipe.primaries, recipe.viewing)) {}

  void print(Reporter& reporter) {
    json_ = {{"schema", "reseau-colour/1"}};
    json_.update(color_to_json(recipe_));
    add_elements();
    add_reseau();
    add_gamut();
    add_matrix();
    for (const std::string& line : lines_) reporter.result_line(line);
    reporter.result_json(json_);
  }

 private:
  void add_elements() {
    const Viewing& viewing = recipe_.viewing;
    const std::string& about = recipe_.primaries.about;
    lines_.push_back(fmt::format("{}{}, {} under {}, sums of {} nm", recipe_.primaries.name,
                                 about.empty() ? "" : " (" + about + ")",
                                 kind_of(recipe_.primaries), viewing.light.name,
                                 viewing.step == SummationStep::k1nm ? 1 : 5));
    const std::string source = first_line(recipe_.primaries.source);
    if (!source.empty()) lines_.push_back(source);
    if (recipe_.primaries.stated && recipe_.primaries.stated->light) {
      lines_.push_back(fmt::format("stated for {}, adapted to the light ({})",
                                   recipe_.primaries.stated->light->name,
                                   json_["adaptation"].get<std::string>()));
    }
    lines_.push_back("           x        y        Y %     dominant wavelength");
    const Observer& observer = observer_of(viewing.step);
    for (int i = 0; i < 3; ++i) {
      const Xyz xyz = column(elements_, i);
      const Chromaticity xy = chromaticity_of(xyz);
      const auto nm = dominant_wavelength_nm(xy, chromaticity_of(light_), observer);
      const auto* name = kElements[static_cast<std::size_t>(i)];
      lines_.push_back(fmt::format("{:<8} {:.5f}  {:.5f}  {:7.3f}  {}", name, xy[0], xy[1],
                                   100 * xyz[1], nm ? fmt::format("{:.2f} nm", *nm) : "purple"));
      ordered_json element = {{"x", number_or_null(xy[0])},
                              {"y", number_or_null(xy[1])},
                              {"Y", number_or_null(xyz[1])},
                              {"dominant_wavelength_nm", nullptr}};
      if (nm) element["dominant_wavelength_nm"] = *nm;
      json_["elements"][name] = element;
    }
  }

  void add_reseau() {
    const Vector3& a = recipe_.areas.share;
    const Matrix3 weighted = scale_columns(elements_, a);
    const Xyz reseau = reseau_color(weighted);
    const Chromaticity xy = chromaticity_of(reseau);
    lines_.push_back(fmt::format("réseau   {:.5f}  {:.5f}  {:7.3f}  areas {:.2f} {:.2f} {:.2f} %",
                                 xy[0], xy[1], 100 * reseau[1], 100 * a[0], 100 * a[1],
                                 100 * a[2]));
    json_["reseau"] = {{"x", number_or_null(xy[0])},
                       {"y", number_or_null(xy[1])},
                       {"Y", number_or_null(reseau[1])}};
    const Vector3 k = multiply(inverse(weighted), light_);
    lines_.push_back(fmt::format("neutral  needs red, green, blue times {:.4f}, {:.4f}, {:.4f}",
                                 k[0], k[1], k[2]));
    json_["neutral_factors"] = {number_or_null(k[0]), number_or_null(k[1]), number_or_null(k[2])};
  }

  void add_gamut() {
    const GamutFigures g = gamut_of(model_.xyz_from_process);
    lines_.push_back(fmt::format(
        "gamut    x, y area {:.4f}, {:.1f} % of sRGB's; covers {:.1f} % of sRGB's triangle; CIELAB "
        "volume {:.0f}, {:.1f} % of sRGB's (balance {})",
        g.area_xy, 100 * g.area_of_srgb, 100 * g.coverage, g.volume, 100 * g.volume_of_srgb,
        balance_word(recipe_.balance)));
    json_["gamut"] = {{"area_xy", number_or_null(g.area_xy)},
                      {"area_of_srgb", number_or_null(g.area_of_srgb)},
                      {"coverage_of_srgb", number_or_null(g.coverage)},
                      {"lab_volume", number_or_null(g.volume)},
                      {"lab_volume_of_srgb", number_or_null(g.volume_of_srgb)}};
  }

  void add_matrix() {
    const Matrix3& m = model_.output_from_process;
    lines_.push_back(fmt::format("balance {}: {} from element intensities",
                                 balance_word(recipe_.balance), space_word(recipe_.space)));
    for (std::size_t i = 0; i < 9; i += 3) {
      lines_.push_back(fmt::format("{:12.7f} {:12.7f} {:12.7f}", m[i], m[i + 1], m[i + 2]));
    }
    json_["xyz_from_process"] = matrix_json(model_.xyz_from_process);
    json_["condition"] = number_or_null(model_.condition);
    json_["chromaticities_rgbw"] = ordered_json::array();
    for (const Chromaticity& xy : model_.chromaticities.xy) {
      json_["chromaticities_rgbw"].push_back({number_or_null(xy[0]), number_or_null(xy[1])});
    }
    json_["adopted_neutral"] = {number_or_null(model_.adopted_neutral[0]),
                                number_or_null(model_.adopted_neutral[1])};
  }

  const ColorRecipe& recipe_;
  ColorModel model_;
  Xyz light_;
  Matrix3 elements_;
  std::vector<std::string> lines_;
  ordered_json json_;
};

const DyeTable* find_dyes(const std::string& name) {
  for (const DyeTable& table : dye_tables()) {
    if (table.name == name) return &table;
  }
  return nullptr;
}

ExitCode show_dyes(const DyeTable& table, const ShowOptions& options, Reporter& reporter) {
  constexpr std::array<const char*, 6> kColors{"#c62828", "#1e4fbf", "#2e7d32",
                                               "#ef6c00", "#6a1b9a", "#00838f"};
  std::vector<TransmittanceCurve> curves;
  ordered_json json = {
      {"schema", "reseau-colour-dyes/1"}, {"name", table.name}, {"source", table.source}};
  reporter.result_line(table.source);
  for (const DyeChart& dye : table.dyes) {
    reporter.result_line(fmt::format("{:<24}{} readings, {:.0f} to {:.0f} nm", dye.name,
                                     dye.points.size(), dye.points.front().wavelength_nm,
                                     dye.points.back().wavelength_nm));
    curves.push_back({dye.name, kColors[curves.size() % kColors.size()],
                      resample(dye.points, {380, 1, 401}, 0, 1), dye.points.front().wavelength_nm,
                      dye.points.back().wavelength_nm});
    json["dyes"].push_back(dye.name);
  }
  if (!options.svg.empty())
    write_text(options.svg, transmittance_svg(table.name, curves), reporter);
  reporter.result_json(json);
  return kExitOk;
}

ExitCode show(const ShowOptions& options, Work& work) {
  if (!options.svg.empty()) refuse_existing(options.svg);
  if (const DyeTable* dyes = find_dyes(options.color.primaries)) {
    return show_dyes(*dyes, options, work.reporter);
  }
  const ColorRecipe recipe =
      as_failure(Doing::kReadingOptions, [&] { return options.color.resolve(work.reporter); });
  Sheet(recipe).print(work.reporter);
  if (!options.svg.empty()) write_text(options.svg, primary_set_svg(recipe), work.reporter);
  return kExitOk;
}

}  // namespace

void add_colour(Program& program) {
  CLI::App* group = program.add_group("colour", "Colours of the elements.",
                                      "reseau colour list\n"
                                      "reseau colour show harrison-horner-1939 --illuminant D65");
  program.prints_own_json(program.add_verb_below(
      group, "list",
      "Primaries, areas, lights and spaces that the program knows, with their sources (--json).",
      "reseau colour list\n"
      "reseau colour list --json",
      list_colours));
  auto options = std::make_shared<ShowOptions>();
  CLI::App* app = program.add_verb_below(
      group, "show",
      "What a set of primaries comes to: chromaticities, luminances, dominant wavelengths, the "
      "colour of\nthe réseau, its gamut, and the matrix from element intensities to an output "
      "space.",
      "reseau colour show harrison-horner-1939 --illuminant D65 --svg harrison.svg\n"
      "reseau colour show my-dyes.csv --light 5500K --space xyz --balance none --json",
      [options](Work& work) { return show(*options, work); });
  app->add_option("NAME", options->color.primaries,
                  "A set of 'reseau colour list', or a CSV file; default the first set");
  app->add_option("--svg", options->svg,
                  "Write the chromaticity diagram and the transmittance curves to this file");
  options->color.add_to(*app, false);
  program.prints_own_json(app);
  add_colour_compare(program, group);
  add_colour_apply(program, group);
  add_colour_profile(program, group);
}

}  // namespace reseau::cli
