// Factors on the element intensities that make something in a picture neutral. Pure, reentrant.
#pragma once

#include "core/color/matrix3.h"

namespace reseau {

// `mean`: element intensities of what is to be neutral; `xyz_from_process` as in ColorModel. The
// factors make the three equal and keep their luminance. InputError, a sentence, when an element is
// dark or negative there.
[[nodiscard]] Vector3 neutral_white_balance(const Vector3& mean, const Matrix3& xyz_from_process);

}  // namespace reseau
