#include "core/color/balance.h"

#include <string>

#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau {
namespace {

// Real sets lie below 10. At 1e4 an error of one part in ten thousand would be the whole colour.
constexpr double kWorstCondition = 1e4;

void require_regular(const Matrix3& weighted_primaries) {
  if (!(condition_number(weighted_primaries) < kWorstCondition)) {
    throw InputError(
        "The three primaries are not independent colours (two are alike, or all three lie on one "
        "line of the chromaticity diagram), so no picture can be made with them; correct them or "
        "use another set.");
  }
}

}  // namespace

Balance parse_balance(std::string_view word) {
  if (word == "none") return Balance::kNone;
  if (word == "brightness") return Balance::kBrightness;
  if (word == "neutral") return Balance::kNeutral;
  if (word == "bradford") return Balance::kBradford;
  throw InputError("There is no balance '" + std::string(word) +
                   "'; use none, brightness, neutral or bradford.");
}

Xyz reseau_color(const Matrix3& weighted_primaries) {
  return multiply(weighted_primaries, Vector3{1, 1, 1});
}

Vector3 neutral_factors(const Matrix3& weighted_primaries, const Xyz& white) {
  require_regular(weighted_primaries);
  const Vector3 factors = multiply(inverse(weighted_primaries), white);
  if (!(factors[0] > 0 && factors[1] > 0 && factors[2] > 0)) {
    throw InputError(
        "The white lies outside the colours that these primaries can make; use another set, or the "
        "balance 'brightness'.");
  }
  return factors;
}

Matrix3 apply_balance(const Matrix3& weighted_primaries, Balance balance, const Xyz& white) {
  require_regular(weighted_primaries);
  const Xyz reseau = reseau_color(weighted_primaries);
  if (!(reseau[1] > 0)) {
    throw InputError("The primaries let no light through; use another set.");
  }
  switch (balance) {
    case Balance::kNone:
      break;
    case Balance::kBrightness:
      return scale(weighted_primaries, 1.0 / reseau[1]);
    case Balance::kNeutral:
      return scale_columns(weighted_primaries, neutral_factors(weighted_primaries, white));
    case Balance::kBradford:
      return multiply(bradford_target_from_source(reseau, white), weighted_primaries);
  }
  return weighted_primaries;
}

}  // namespace reseau
