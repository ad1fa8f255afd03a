// What happens to the colour of the clear réseau. Pure functions, reentrant.
#pragma once

#include <string_view>

#include "core/color/colorimetry.h"

namespace reseau {

enum class Balance {
  kNone,        // primaries x areas as they are
  kBrightness,  // whole matrix divided by Y of the réseau: exposure only, the cast stays
  kNeutral,     // columns scaled so that (1, 1, 1) is the white; the default
  kBradford,    // the réseau's own colour adapted to the white, luminance included
};

// "none", "brightness", "neutral" or "bradford"; InputError for anything else, listing these.
[[nodiscard]] Balance parse_balance(std::string_view word);

// XYZ of the clear réseau: the columns of an area-weighted matrix (XYZ x area per element) added.
[[nodiscard]] Xyz reseau_color(const Matrix3& weighted_primaries);

// Factor on each element that makes the réseau match `white`. InputError when the primaries are
// singular, or when they cannot make the white (a factor would not be positive).
[[nodiscard]] Vector3 neutral_factors(const Matrix3& weighted_primaries, const Xyz& white);

// Area-weighted primaries to the matrix from element intensities (1 = clear) to XYZ. InputError as
// above; also when the réseau has no light, and for numbers that are not finite.
[[nodiscard]] Matrix3 apply_balance(const Matrix3& weighted_primaries, Balance balance,
                                    const Xyz& white);

}  // namespace reseau
