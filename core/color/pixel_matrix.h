#pragma once

#include <span>

#include "core/color/matrix3.h"

namespace reseau {

// Multiplies every pixel of [pixel][3] by the matrix, in place, in float, on several cores. The
// same bytes for any number of threads. Values that are not finite stay so. Reentrant.
void transform_pixels(std::span<float> rgb, const Matrix3& matrix);

}  // namespace reseau
