// Chromatic adaptation. Pure, reentrant.
#pragma once

#include <string_view>

#include "core/color/colorimetry.h"

namespace reseau {

enum class AdaptationMethod {
  kBradford,  // Lam 1985, as in ICC.1:2022 annex E; the default
  kCat16,     // Li et al. 2017, complete adaptation
};

// "bradford" or "cat16"; InputError otherwise.
[[nodiscard]] AdaptationMethod parse_adaptation(std::string_view word);

// XYZ seen under one white to XYZ that looks the same under another: cone responses scaled by the
// ratio of those of the whites (von Kries). Maps source_white exactly on target_white, luminance
// included. InputError when the source white has no positive cone response (it is then no white).
[[nodiscard]] Matrix3 target_from_source(AdaptationMethod method, const Xyz& source_white,
                                         const Xyz& target_white);

[[nodiscard]] Matrix3 bradford_target_from_source(const Xyz& source_white, const Xyz& target_white);

}  // namespace reseau
