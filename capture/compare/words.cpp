#include <array>
#include <utility>

#include <fmt/format.h>

#include "capture/compare/compare.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

template <typename Value>
using Word = std::pair<const char*, Value>;

constexpr std::array<Word<Fit>, 3> kFits{
    {{"none", Fit::kNone}, {"gain", Fit::kGain}, {"white", Fit::kWhite}}};
constexpr std::array<Word<LabWhite>, 7> kWhites{{{"D65", LabWhite::kD65},
                                                 {"D50", LabWhite::kD50},
                                                 {"A", LabWhite::kA},
                                                 {"B", LabWhite::kB},
                                                 {"C", LabWhite::kC},
                                                 {"E", LabWhite::kE},
                                                 {"own", LabWhite::kOwn}}};
constexpr std::array<Word<Layer>, 3> kLayers{
    {{"auto", Layer::kAuto}, {"process", Layer::kProcess}, {"scene", Layer::kScene}}};

template <typename Words>
auto value_in(const Words& words, std::string_view word) {
  std::string known;
  for (const auto& [name, value] : words) {
    if (word == name) return value;
    if (!known.empty()) known += ", ";
    known += name;
  }
  throw InputError(fmt::format("There is no '{}' here; use one of {}.", word, known));
}

template <typename Words, typename Value>
std::string name_in(const Words& words, Value value) {
  for (const auto& [name, known] : words) {
    if (known == value) return name;
  }
  CHECK(false);
}

}  // namespace

std::string word_of(Fit fit) { return name_in(kFits, fit); }
std::string word_of(LabWhite white) { return name_in(kWhites, white); }
Fit parse_fit(std::string_view word) { return value_in(kFits, word); }
LabWhite parse_lab_white(std::string_view word) { return value_in(kWhites, word); }
Layer parse_layer(std::string_view word) { return value_in(kLayers, word); }

}  // namespace reseau::compare
