#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/color_choice.h"
#include "capture/cli/failure.h"
#include "capture/cli/verb_colour.h"
#include "capture/color/color_record.h"
#include "capture/color/primaries_file.h"
#include "capture/session/json_number.h"
#include "core/base/error.h"
#include "core/color/set_difference.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

struct ColourCompareArguments {
  std::vector<std::string> sets;
  ColorChoice color;
  std::string colors = "warm";
  std::string lab_white = "D65";
  double drop_percent = 1;
  bool clamp = false;
  bool csv = false;
};

struct Pair {
  std::string a, b;
  DeltaESummary difference;
};

struct Table {
  std::vector<std::string> names;
  std::vector<Vector3> intensities;
  std::vector<Pair> pairs;  // b before a in `names`
};

DifferenceConvention convention_of(const ColourCompareArguments& options) {
  DifferenceConvention convention;
  if (options.lab_white == "reseau") {
    convention.white = DifferenceConvention::LabWhite::kReseau;
  } else if (options.lab_white != "D65") {
    throw InputError("There is no white '" + options.lab_white +
                     "' for CIELAB; use D65 or reseau.");
  }
  if (!(options.drop_percent >= 0 && options.drop_percent < 100)) {
    throw InputError(fmt::format("--drop {} cannot be; it is a percentage from 0 to below 100.",
                                 options.drop_percent));
  }
  convention.worst_fraction = options.drop_percent / 100;
  convention.clamp_xyz = options.clamp;
  return convention;
}

std::vector<Vector3> colors_of(const std::string& word) {
  const bool file = word.find('/') != std::string::npos || word.ends_with(".csv");
  if (!file) return stated_colors(word);
  return as_failure(Doing::kReadingInput, [&] { return load_intensities(word); });
}

Table make_table(const ColourCompareArguments& options, Reporter& reporter) {
  const DifferenceConvention convention = convention_of(options);
  Table table;
  table.intensities = colors_of(options.colors);
  std::vector<ColorModel> models;
  for (const std::string& word : options.sets) {
    ColorChoice choice = options.color;
    choice.primaries = word;
    choice.space = "xyz";
    const ColorRecipe recipe = choice.resolve(reporter);
    models.push_back(make_color_model(recipe));
    table.names.push_back(recipe.primaries.name);
    for (std::size_t b = 0; b + 1 < models.size(); ++b) {
      table.pairs.push_back(
          {table.names.back(), table.names[b],
           set_difference(table.intensities, models.back(), models[b], convention)});
    }
  }
  return table;
}

std::string csv_of(const Table& table) {
  std::string text = "a,b,mean,p95,max,n\n";
  for (const Pair& pair : table.pairs) {
    const DeltaESummary& d = pair.difference;
    text +=
        fmt::format("{},{},{:.6f},{:.6f},{:.6f},{}\n", pair.a, pair.b, d.mean, d.p95, d.max, d.n);
  }
  text.pop_back();
  return text;
}

void print_text(const Table& table, const ColourCompareArguments& options, Reporter& reporter) {
  reporter.result_line(fmt::format(
      "ΔE2000, mean / maximum, {} colours ({}), balance {}, light {}, CIELAB white {}, worst {} % "
      "left out{}",
      table.intensities.size(), options.colors, options.color.balance, options.color.light,
      options.lab_white, options.drop_percent, options.clamp ? ", XYZ clamped to 0..1" : ""));
  std::size_t width = 9;
  for (const std::string& name : table.names) width = std::max(width, name.size() + 2);
  std::size_t at = 0;
  for (std::size_t a = 0; a < table.names.size(); ++a) {
    std::string line = fmt::format("{:>2} {:<{}}", a + 1, table.names[a], width);
    for (std::size_t b = 0; b < a; ++b) {
      const DeltaESummary& d = table.pairs[at++].difference;
      line += fmt::format("{:>16}", fmt::format("{:.2f} / {:.2f}", d.mean, d.max));
    }
    reporter.result_line(line);
  }
  std::string below = fmt::format("{:<{}}", "against", width + 3);
  for (std::size_t b = 0; b + 1 < table.names.size(); ++b) below += fmt::format("{:>16}", b + 1);
  reporter.result_line(below);
}

ordered_json json_of(const Table& table, const ColourCompareArguments& options,
                     const ColorRecipe& common) {
  ordered_json json = {{"schema", "reseau-colour-compare/1"},
                       {"colours", options.colors},
                       {"n_colours", table.intensities.size()},
                       {"balance", balance_word(common.balance)},
                       {"light", common.viewing.light.name},
                       {"lab_white", options.lab_white},
                       {"worst_percent_left_out", options.drop_percent},
                       {"xyz_clamped", options.clamp},
                       {"sets", table.names},
                       {"pairs", ordered_json::array()}};
  for (const Pair& pair : table.pairs) {
    const DeltaESummary& d = pair.difference;
    json["pairs"].push_back({{"a", pair.a},
                             {"b", pair.b},
                             {"mean", number_or_null(d.mean)},
                             {"p95", number_or_null(d.p95)},
                             {"max", number_or_null(d.max)},
                             {"n", d.n}});
  }
  return json;
}

ExitCode run(const ColourCompareArguments& given, Work& work) {
  ColourCompareArguments options = given;
  if (options.sets.empty()) {
    options.sets = {"cornwell-clyne-1951-tab1", "hubicka-2025",       "harrison-horner-1939",
                    "cornwell-clyne-1951",      "collins-giles-1952", "neblette-1952"};
  }
  return as_failure(Doing::kReadingOptions, [&] {
    if (options.sets.size() < 2) {
      throw InputError("One set has nothing to be compared with; name two or more.");
    }
    const Table table = make_table(options, work.reporter);
    if (options.csv) {
      work.reporter.result_line(csv_of(table));
    } else {
      print_text(table, options, work.reporter);
    }
    ColorChoice common = options.color;
    work.reporter.result_json(json_of(table, options, common.resolve(work.reporter)));
    return kExitOk;
  });
}

}  // namespace

void add_colour_compare(Program& program, CLI::App* group) {
  auto options = std::make_shared<ColourCompareArguments>();
  CLI::App* app = program.add_verb_below(
      group, "compare",
      "Colour difference (CIEDE2000) between every two sets of primaries on the same element "
      "intensities.\nThe convention of Hubička et al. 2025 by default: CIELAB against D65 for "
      "both, "
      "the worst 1 % left\nout, of the mean as well. Without sets: the six of that paper.",
      "reseau colour compare harrison-horner-1939 neblette-1952 my-dyes.csv\n"
      "reseau colour compare --colours green --balance brightness --csv",
      [options](Work& work) { return run(*options, work); });
  app->add_option("SETS", options->sets, "Sets of 'reseau colour list', or CSV files");
  app->add_option("--colours,--colors", options->colors,
                  "warm (default), green, even, or a CSV file with the columns r,g,b");
  app->add_option("--lab-white", options->lab_white,
                  "D65 (default), or reseau: each set against its own clear réseau");
  app->add_option("--drop", options->drop_percent, "Percent of the largest left out (default 1)");
  app->add_flag("--clamp", options->clamp, "XYZ to 0..1 first, as Color-Screen does");
  app->add_flag("--csv", options->csv, "The table as CSV");
  options->color.add_to(*app, false, false);
  program.prints_own_json(app);
}

}  // namespace reseau::cli
