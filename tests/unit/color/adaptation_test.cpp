#include "core/color/adaptation.h"

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

TEST(Bradford, AgreesWithThePublishedMatrixFromD50ToD65) {
  // Lindbloom's table for the ICC whites.
  const Matrix3 published{0.9555766, -0.0230393, 0.0631636,  -0.0282895, 1.0099416,
                          0.0210077, 0.0122982,  -0.0204830, 1.3299098};
  const Matrix3 own = bradford_target_from_source({0.96422, 1, 0.82521}, {0.95047, 1, 1.08883});
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(own[i], published[i], 2e-6);
  }
}

// Computed by another program from the printed cone matrix.
TEST(Cat16, AgreesWithAnIndependentMatrixFromD50ToD65) {
  const Matrix3 expected{0.9894962,  -0.0399233, 0.0439904, -0.0053911, 1.0066457,
                         -0.0017541, -0.0004037, 0.0150564, 1.3016843};
  const Matrix3 own =
      target_from_source(AdaptationMethod::kCat16, {0.96422, 1, 0.82521}, {0.95047, 1, 1.08883});
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(own[i], expected[i], 2e-7);
  }
  EXPECT_EQ(parse_adaptation("cat16"), AdaptationMethod::kCat16);
  EXPECT_THROW((void)parse_adaptation("cat02"), InputError);
}

TEST(Bradford, MapsWhiteOnWhiteAndBack) {
  const Xyz c = white_of(Illuminant::kC);
  const Xyz d65 = white_of(Illuminant::kD65);
  const Xyz mapped = multiply(bradford_target_from_source(c, d65), c);
  const Matrix3 there_and_back =
      multiply(bradford_target_from_source(d65, c), bradford_target_from_source(c, d65));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mapped[i], d65[i], 1e-15);
  }
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(there_and_back[i], kIdentity3[i], 1e-14);
  }
}

TEST(Bradford, RefusesAWhiteThatIsNone) {
  EXPECT_THROW((void)bradford_target_from_source({0, 0, 0}, {1, 1, 1}), InputError);
  EXPECT_THROW((void)bradford_target_from_source({0.1, 0.01, 1}, {1, 1, 1}), InputError);
}

}  // namespace
}  // namespace reseau
