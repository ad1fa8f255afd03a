#include "capture/color/primaries_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/base/error.h"
#include "core/color/color_csv.h"
#include "core/color/primary_file.h"

namespace reseau {
namespace {

constexpr std::uintmax_t kMostBytes = 16U << 20;

std::string contents(const std::filesystem::path& path) {
  std::error_code problem;
  if (!std::filesystem::is_regular_file(path, problem)) {
    throw InputError("'" + path.string() + "' is not a file; give a CSV table.");
  }
  if (std::filesystem::file_size(path, problem) > kMostBytes) {
    throw InputError("The file '" + path.string() +
                     "' is larger than 16 MB; a table of spectra is far smaller.");
  }
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file.is_open() || file.bad()) {
    throw InputError("The file '" + path.string() + "' cannot be read; check its permissions.");
  }
  return text;
}

// Reads with `parse`, and says which file a complaint is about.
template <typename Parse>
auto of_file(const std::filesystem::path& path, const Parse& parse) {
  const std::string text = contents(path);
  try {
    return parse(text);
  } catch (const InputError& error) {
    throw InputError("In '" + path.string() + "': " + error.what());
  }
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool looks_like_a_path(const std::string& word) {
  return word.find('/') != std::string::npos || word.ends_with(".csv") || word.ends_with(".txt");
}

PrimarySet only_set(const std::string& path, const std::string& wanted) {
  auto sets = of_file(path, [&](const std::string& text) {
    return parse_primary_sets(text, std::filesystem::path(path).filename().string(),
                              TableOrigin::kOwn);
  });
  if (wanted.empty() && sets.size() == 1) return std::move(sets.front());
  std::string known;
  for (PrimarySet& set : sets) {
    if (set.name == wanted) return std::move(set);
    known += (known.empty() ? "" : ", ") + set.name;
  }
  throw InputError(wanted.empty() ? "The file '" + path + "' holds several sets; choose one as '" +
                                        path + "#NAME': " + known + "."
                                  : "The file '" + path + "' holds no set '" + wanted +
                                        "'; it has: " + known + ".");
}

}  // namespace

bool names_primaries_file(const std::string& word) {
  const auto names = primary_set_names();
  if (std::find(names.begin(), names.end(), word) != names.end()) return false;
  return exists(word) || exists(word.substr(0, word.rfind('#'))) || looks_like_a_path(word);
}

PrimarySet load_primary_set(const std::string& word) {
  const auto names = primary_set_names();
  if (std::find(names.begin(), names.end(), word) != names.end()) return find_primary_set(word);
  if (exists(word)) return only_set(word, "");
  const auto hash = word.rfind('#');
  if (hash != std::string::npos && exists(word.substr(0, hash))) {
    return only_set(word.substr(0, hash), word.substr(hash + 1));
  }
  if (looks_like_a_path(word)) {
    throw InputError("There is no file '" + word + "'; check the path.");
  }
  return find_primary_set(word);  // says which there are
}

std::vector<Vector3> load_intensities(const std::string& path) {
  return of_file(path, [](const std::string& text) {
    const CsvText table = parse_color_csv(text);
    const auto r = table.column({"r", "red", "R"}), g = table.column({"g", "green", "G"}),
               b = table.column({"b", "blue", "B"});
    if (!r || !g || !b) throw InputError("a table of colours needs the columns r,g,b.");
    std::vector<Vector3> colors;
    for (const CsvLine& row : table.rows) {
      const auto value = [&](std::size_t column) {
        const double v =
            csv_number(row.fields[column], table.decimal_comma, row.number, "an intensity");
        if (!(v >= 0 && v <= 16)) {
          throw InputError("Line " + std::to_string(row.number) +
                           " of the table: an intensity lies between 0 and 1 (clear film); "
                           "correct it.");
        }
        return v;
      };
      colors.push_back({value(*r), value(*g), value(*b)});
    }
    return colors;
  });
}

}  // namespace reseau
