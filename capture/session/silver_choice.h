// Where the silver picture comes from, as a person chooses it.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/reconstruct/silver_from_rgb.h"

namespace reseau {

struct SilverChoice {
  bool ignore_infrared = false;
  // For silver from red, green and blue; absent: by the elements of the scan itself.
  std::optional<SilverWeights> weights;
  std::string learned_on;  // where the weights are from, for receipts
};

// "infrared" (where there is none, from RGB), "rgb" (as if there were none), or a file: a receipt
// of a scan that had infrared, or such a scan itself, whose weights are used instead of infrared.
// InputError, a sentence, for files that do not tell weights; std::system_error.
[[nodiscard]] SilverChoice parse_silver_choice(const std::string& word);

// {"weights": [r, g, b], "offset", "correlation", "rms_relative", "pixels"}
[[nodiscard]] nlohmann::ordered_json learned_silver_to_json(const LearnedSilver& learned);

}  // namespace reseau
