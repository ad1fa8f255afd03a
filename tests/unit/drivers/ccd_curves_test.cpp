#include "drivers/coolscan/ccd_curves.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/drivers/units.h"

namespace reseau::coolscan {
namespace {

// Two lines, one type, three points.
Bytes curves(int a0, int a1, int a2, int b0, int b1, int b2) {
  Bytes data = bytes_of({0x91, 0, 0, 0, 0, 12});
  for (const int v : {a0, a1, a2, b0, b1, b2}) {
    data.push_back(std::byte(v >> 8));
    data.push_back(std::byte(v & 0xFF));
  }
  return data;
}

TEST(CcdCurves, MapTheSecondLineToTheFirst) {
  const auto c = CcdCurves::parse(curves(100, 1000, 40000, 120, 900, 44000), {1, 3}, 2);
  ASSERT_TRUE(c);
  EXPECT_TRUE(c->table(0, 0).empty());
  const std::vector<std::uint16_t> t = c->table(1, 0);
  EXPECT_EQ(t[50], 50) << "unchanged below the first point";
  EXPECT_EQ(t[900], 1000);
  EXPECT_EQ(t[44000], 40000);
  EXPECT_EQ(t[(120 + 900) / 2], (100 + 1000) / 2);
  EXPECT_EQ(t[65535], std::lround(65535.0 * 40000 / 44000)) << "in proportion above the last";
  EXPECT_EQ(c->table(1, 7), t) << "a type that does not exist is the first";
}

TEST(CcdCurves, RefuseWhatIsShortOrFalls) {
  EXPECT_FALSE(CcdCurves::parse(curves(100, 1000, 900, 120, 900, 44000), {1, 3}, 2));
  EXPECT_FALSE(CcdCurves::parse(curves(1, 2, 3, 4, 5, 6), {2, 3}, 2));
  EXPECT_FALSE(parse_curve_page(Bytes(6)));
  EXPECT_FALSE(parse_curve_page(Bytes(20)));
}

TEST(CcdCurves, PageE3OfAnLs5000) {
  const auto page = parse_curve_page(
      from_hex("06E3002D 0701 0FA0 01 02 13 0000 0083 0106 0189 020C 028F 051F 0A3D"));
  EXPECT_EQ(page, (CurvePage{2, 19}));
}

}  // namespace
}  // namespace reseau::coolscan
