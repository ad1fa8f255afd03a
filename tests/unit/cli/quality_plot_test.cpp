#include "capture/cli/quality_plot.h"

#include <gtest/gtest.h>

namespace reseau::cli {
namespace {

TEST(QualityPlot, FindsTheParetoFront) {
  const std::vector<QualityPoint> points{{"draft", 0.1, 1.4},
                                         {"draft", 0.3, 1.6},
                                         {"slow", 0.5, 1.5},
                                         {"best", 0.6, 0.7},
                                         {"standard", 0.2, 1.0}};
  const std::vector<QualityMean> means = quality_means(points);
  ASSERT_EQ(means.size(), 4U);
  EXPECT_EQ(means[0].quality, "draft");
  EXPECT_NEAR(means[0].seconds, 0.2, 1e-12);
  EXPECT_NEAR(means[0].delta_e, 1.5, 1e-12);
  EXPECT_FALSE(means[0].on_front) << "standard takes as long and is truer";
  EXPECT_FALSE(means[1].on_front);
  EXPECT_TRUE(means[2].on_front);
  EXPECT_TRUE(means[3].on_front);
  const std::string svg = quality_plot(points);
  EXPECT_NE(svg.find("slow (not on the front)"), std::string::npos);
  EXPECT_EQ(svg.find("best (not"), std::string::npos);
  EXPECT_EQ(svg, quality_plot(points));
}

TEST(QualityPlot, NothingMeasuredIsAnEmptyPlot) {
  EXPECT_TRUE(quality_means({}).empty());
  EXPECT_NE(quality_plot({}).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace reseau::cli
