// Chromatic adaptation. Pure, reentrant.
#pragma once

#include "core/color/colorimetry.h"

namespace reseau {

// XYZ seen under one white to XYZ that looks the same under another: linear Bradford transform (Lam
// 1985, as in ICC.1:2022 annex E). Maps source_white exactly on target_white, luminance included.
// InputError when the source white has no positive cone response (it is then no white).
[[nodiscard]] Matrix3 bradford_target_from_source(const Xyz& source_white, const Xyz& target_white);

}  // namespace reseau
