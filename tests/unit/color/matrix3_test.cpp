#include "core/color/matrix3.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace reseau {
namespace {

constexpr Matrix3 kExample{2, 0, 1, 0, 3, 0, 1, 0, 4};

TEST(Matrix3, MultipliesVectorsAndMatrices) {
  EXPECT_EQ(multiply(kExample, Vector3{1, 2, 3}), (Vector3{5, 6, 13}));
  EXPECT_EQ(multiply(kExample, kExample), (Matrix3{5, 0, 6, 0, 9, 0, 6, 0, 17}));
}

TEST(Matrix3, InverseUndoesTheMatrix) {
  const Matrix3 product = multiply(inverse(kExample), kExample);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(product[i], kIdentity3[i], 1e-15);
  }
}

TEST(Matrix3, ColumnsRoundTrip) {
  EXPECT_EQ(from_columns(column(kExample, 0), column(kExample, 1), column(kExample, 2)), kExample);
  EXPECT_EQ(scale_columns(kExample, {1, 2, 10}), (Matrix3{2, 0, 10, 0, 6, 0, 1, 0, 40}));
}

TEST(ConditionNumber, IsTheRatioOfSingularValues) {
  EXPECT_DOUBLE_EQ(condition_number(kIdentity3), 1.0);
  EXPECT_NEAR(condition_number({100, 0, 0, 0, 10, 0, 0, 0, 0.5}), 200.0, 1e-11);
  // A rotation by 30 degrees on either side changes nothing.
  const double c = std::sqrt(3.0) / 2;
  const Matrix3 turn{c, -0.5, 0, 0.5, c, 0, 0, 0, 1};
  EXPECT_NEAR(condition_number(multiply(turn, {4, 0, 0, 0, 2, 0, 0, 0, 1})), 4.0, 1e-12);
}

TEST(ConditionNumber, IsInfiniteForSingularAndBrokenMatrices) {
  EXPECT_GT(condition_number({1, 2, 3, 2, 4, 6, 0, 0, 1}), 1e15);
  EXPECT_TRUE(std::isinf(condition_number(Matrix3{})));
  Matrix3 broken = kIdentity3;
  broken[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isinf(condition_number(broken)));
}

}  // namespace
}  // namespace reseau
