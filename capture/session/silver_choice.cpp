#include "capture/session/silver_choice.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

#include "capture/image/scan_reader.h"
#include "capture/session/json_number.h"
#include "core/base/error.h"

namespace reseau {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kMostReceiptBytes = 16U << 20;

// Weights beyond this are no mixture of channels of one scan.
constexpr double kMostWeight = 100;

std::optional<SilverWeights> weights_in(const json& receipt) {
  const json::json_pointer at("/reconstruction/silver_from_rgb");
  if (!receipt.is_object() || !receipt.contains(at)) return std::nullopt;
  const json& silver = receipt.at(at);
  if (!silver.is_object() || !silver.contains("weights") || !silver["weights"].is_array() ||
      silver["weights"].size() != 3) {
    return std::nullopt;
  }
  SilverWeights out;
  const auto number = [](const json& value, double& to) {
    if (!value.is_number()) return false;
    to = value.get<double>();
    return std::isfinite(to) && std::abs(to) <= kMostWeight;
  };
  for (std::size_t i = 0; i < 3; ++i) {
    if (!number(silver["weights"][i], out.weights[i])) return std::nullopt;
  }
  if (silver.contains("offset") && !number(silver["offset"], out.offset)) return std::nullopt;
  return out;
}

SilverChoice of_receipt(const std::string& path, const json& receipt) {
  const auto weights = weights_in(receipt);
  if (!weights) {
    throw InputError("The receipt '" + path +
                     "' tells no weights that make silver of red, green and blue; give that of a "
                     "reconstruction whose scan had infrared.");
  }
  return {true, weights, std::filesystem::path(path).filename().string()};
}

SilverChoice of_scan(const std::string& path) {
  const Scan scan = read_scan(path);
  const auto learned = learn_silver_from_rgb(*scan.source, scan.tone, {});
  if (!learned) {
    throw InputError("From the scan '" + path +
                     "' the silver cannot be learned: it has no infrared, or its colours are too "
                     "much alike.");
  }
  return {true, learned->silver, std::filesystem::path(path).filename().string()};
}

}  // namespace

SilverChoice parse_silver_choice(const std::string& word) {
  if (word == "infrared") return {};
  if (word == "rgb") return {true, std::nullopt, ""};
  std::error_code problem;
  if (!std::filesystem::is_regular_file(word, problem)) {
    throw InputError("--silver-from " + word +
                     " is not understood; give infrared, rgb, or a file: the receipt of a scan "
                     "with infrared, or such a scan.");
  }
  std::ifstream file(word, std::ios::binary);
  const int first = file.peek();
  if (first != '{') return of_scan(word);
  if (std::filesystem::file_size(word, problem) > kMostReceiptBytes) {
    throw InputError("The file '" + word + "' is larger than any receipt.");
  }
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return of_receipt(word, json::parse(text, nullptr, false));
}

nlohmann::ordered_json learned_silver_to_json(const LearnedSilver& learned) {
  const auto& w = learned.silver.weights;
  return {{"weights", {number_or_null(w[0]), number_or_null(w[1]), number_or_null(w[2])}},
          {"offset", number_or_null(learned.silver.offset)},
          {"correlation", number_or_null(learned.correlation)},
          {"rms_relative", number_or_null(learned.rms_relative)},
          {"pixels", learned.n_pixels}};
}

}  // namespace reseau
