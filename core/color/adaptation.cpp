#include "core/color/adaptation.h"

#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/color/tables.h"

namespace reseau {
namespace {

Matrix3 cones_from_xyz(std::string_view transform) {
  Matrix3 matrix{};
  std::size_t at = 0;
  for (const ConeRow& row : cone_table()) {
    if (row.transform != transform) continue;
    CHECK(at < matrix.size());
    matrix[at++] = row.x;
    matrix[at++] = row.y;
    matrix[at++] = row.z;
  }
  CHECK(at == matrix.size());
  return matrix;
}

const Matrix3& cones_of(AdaptationMethod method) {
  static const Matrix3 bradford = cones_from_xyz("bradford");
  static const Matrix3 cat16 = cones_from_xyz("cat16");
  return method == AdaptationMethod::kCat16 ? cat16 : bradford;
}

}  // namespace

AdaptationMethod parse_adaptation(std::string_view word) {
  if (word == "bradford") return AdaptationMethod::kBradford;
  if (word == "cat16") return AdaptationMethod::kCat16;
  throw InputError("There is no adaptation '" + std::string(word) + "'; use bradford or cat16.");
}

Matrix3 target_from_source(AdaptationMethod method, const Xyz& source_white,
                           const Xyz& target_white) {
  const Matrix3& cones = cones_of(method);
  const Vector3 source = multiply(cones, source_white);
  const Vector3 target = multiply(cones, target_white);
  if (!(source[0] > 0 && source[1] > 0 && source[2] > 0)) {
    throw InputError(
        "The white to adapt from is outside the colours that an eye can take for white; choose "
        "other primaries or another balance.");
  }
  const Matrix3 gains{target[0] / source[0], 0, 0, 0, target[1] / source[1], 0, 0, 0,
                      target[2] / source[2]};
  return multiply(inverse(cones), multiply(gains, cones));
}

Matrix3 bradford_target_from_source(const Xyz& source_white, const Xyz& target_white) {
  return target_from_source(AdaptationMethod::kBradford, source_white, target_white);
}

}  // namespace reseau
