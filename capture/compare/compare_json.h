// A comparison for programs (schema reseau-compare/1) and for people.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "capture/compare/compare.h"

namespace reseau::compare {

// The fields are described in README.md. Nothing that was not measured is left out silently: it is
// null, and `not_available` says why.
[[nodiscard]] nlohmann::ordered_json comparison_to_json(const Comparison& comparison,
                                                        const CompareOptions& options);

// Lines of text: the figures with their conventions.
[[nodiscard]] std::vector<std::string> describe_comparison(const Comparison& comparison,
                                                           const CompareOptions& options);

}  // namespace reseau::compare
