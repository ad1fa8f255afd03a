#include "core/color/adaptation.h"

#include "core/base/error.h"

namespace reseau {
namespace {
// Lam, K. M. (1985), PhD thesis, University of Bradford; ICC.1:2022 annex E.
constexpr Matrix3 kConesFromXyz{0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                                0.0367, 0.0389, -0.0685, 1.0296};
}  // namespace

Matrix3 bradford_target_from_source(const Xyz& source_white, const Xyz& target_white) {
  const Vector3 source = multiply(kConesFromXyz, source_white);
  const Vector3 target = multiply(kConesFromXyz, target_white);
  if (!(source[0] > 0 && source[1] > 0 && source[2] > 0)) {
    throw InputError(
        "The white to adapt from is outside the colours that an eye can take for white; choose "
        "other primaries or another balance.");
  }
  const Matrix3 gains{target[0] / source[0], 0, 0, 0, target[1] / source[1], 0, 0, 0,
                      target[2] / source[2]};
  return multiply(inverse(kConesFromXyz), multiply(gains, kConesFromXyz));
}

}  // namespace reseau
