#include "capture/color/neutral_area.h"

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau {
namespace {

TEST(NeutralArea, WordsAreRead) {
  EXPECT_TRUE(parse_neutral_area("auto").whole);
  const NeutralArea area = parse_neutral_area("3,4,50,60");
  EXPECT_FALSE(area.whole);
  EXPECT_EQ(area.text(), "3,4,50,60");
  for (const char* word : {"", "1,2,3", "1,2,3,4,5", "1,2,0,4", "-1,2,3,4", "a,b,c,d", "1,2,3,4x",
                           "1;2;3;4", "99999999999,0,1,1"}) {
    EXPECT_THROW((void)parse_neutral_area(word), InputError) << word;
  }
}

TEST(AreaMean, IsTheMeanOfTheAreaHoweverTheRowsCome) {
  constexpr int kWidth = 10, kHeight = 9;
  std::vector<float> rgb(std::size_t{3} * kWidth * kHeight);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<float>(i);
  for (const int rows_at_once : {1, 2, 4, 9}) {
    AreaMean mean(parse_neutral_area("2,3,4,5"));
    mean.begin(kWidth, kHeight);
    for (int y = 0; y < kHeight; y += rows_at_once) {
      const int n = std::min(rows_at_once, kHeight - y);
      mean.rows(y, n,
                std::span(rgb).subspan(static_cast<std::size_t>(y) * kWidth * 3,
                                       static_cast<std::size_t>(n) * kWidth * 3));
    }
    // The middle of the area: x = 3.5, y = 5.
    EXPECT_NEAR(mean.mean()[0], 3 * (5 * kWidth + 3.5), 1e-9);
    EXPECT_NEAR(mean.mean()[2], 3 * (5 * kWidth + 3.5) + 2, 1e-9);
  }
}

TEST(AreaMean, RefusesWhatLiesOutsideAndLeavesOutWhatIsNoNumber) {
  AreaMean outside(parse_neutral_area("8,0,3,3"));
  EXPECT_THROW(outside.begin(10, 10), InputError);
  AreaMean mean(NeutralArea{});
  mean.begin(2, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mean.rows(0, 1, std::vector<float>{nan, 1, 1, 0.5F, 0.25F, 0.125F});
  EXPECT_EQ(mean.mean(), (Vector3{0.5, 0.25, 0.125}));
  AreaMean nothing(NeutralArea{});
  nothing.begin(1, 1);
  nothing.rows(0, 1, std::vector<float>{nan, nan, nan});
  EXPECT_THROW((void)nothing.mean(), InputError);
}

}  // namespace
}  // namespace reseau
