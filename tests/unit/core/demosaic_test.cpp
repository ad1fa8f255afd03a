// Ways to make one picture of three lattices: their names, and the ratio of the silver.
#include "core/reconstruct/demosaic.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/line/memory_line_source.h"
#include "core/reconstruct/silver_ratio.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {
namespace {

TEST(Demosaic, IsChosenByNameAndElseByTheQuality) {
  for (const Demosaic demosaic : kDemosaics)
    EXPECT_EQ(parse_demosaic(demosaic_name(demosaic)), demosaic);
  EXPECT_THROW((void)parse_demosaic("AMaZE"), InputError);
  EXPECT_EQ(demosaic_of(Quality::kDraft, {}), Demosaic::kBilinear);
  EXPECT_EQ(demosaic_of(Quality::kStandard, {}), Demosaic::kBicubic);
  EXPECT_EQ(demosaic_of(Quality::kBest, {}), Demosaic::kJoint);
  EXPECT_EQ(demosaic_of(Quality::kBest, Demosaic::kNearest), Demosaic::kNearest);
}

constexpr int kPlaneSide = 48;

// Silver of one plane, as a scan has it.
template <typename Silver>
std::vector<std::uint16_t> plane_samples(const Silver& silver) {
  std::vector<std::uint16_t> samples;
  for (int y = 0; y < kPlaneSide; ++y) {
    for (int x = 0; x < kPlaneSide; ++x)
      samples.push_back(static_cast<std::uint16_t>(std::lround(65535 * silver(x, y))));
  }
  return samples;
}

template <typename Silver, typename Body>
void with_ratio(const Silver& silver, double predicted, double noise_sd, const Body& body) {
  LineFormat format;
  format.width_px = format.n_lines = kPlaneSide;
  format.channels = {Channel::kInfrared};
  const MemoryLineSource source(format, plane_samples(silver));
  const ToneCurves tone = ToneCurves::linear();
  SilverSettings settings;
  settings.source = &source;
  settings.tone = &tone;
  settings.period_px = {Vec2{8, 0}, Vec2{0, 8}};
  settings.margin_px = 4;
  const SilverRows rows(settings, 0, kPlaneSide);
  const PixelBounds rect{0, 0, kPlaneSide, kPlaneSide};
  body(SilverRatio(rows, std::vector<float>(kPlaneSide * kPlaneSide, static_cast<float>(predicted)),
                   rect, noise_sd));
}

TEST(SilverRatio, IsTheSilverOverThePicture) {
  with_ratio([](int, int) { return 0.6; }, 0.4, 0.002,
             [](const SilverRatio& ratio) {
               EXPECT_NEAR(ratio.at(20, 20, 0, 0), 1.5F, 1e-3F);
               EXPECT_NEAR(ratio.at(20, 20, 0.5F, 0.25F), 1.5F, 1e-3F);
             });
  const auto wave = [](int x, int) { return 0.4 + 0.1 * std::sin(x / 3.0); };
  with_ratio(wave, 0.4, 0.002, [](const SilverRatio& ratio) {
    // Part of a pixel between two is between their ratios.
    EXPECT_NEAR(ratio.at(20, 20, 0.5F, 0), 0.5F * (ratio.at(20, 20, 0, 0) + ratio.at(21, 20, 0, 0)),
                1e-6F);
    EXPECT_GT(ratio.at(24, 20, 0, 0), 1.15F);
    EXPECT_LT(ratio.at(14, 20, 0, 0), 0.85F);
  });
}

TEST(SilverRatio, IsBoundedAndLeavesTheDarkAlone) {
  with_ratio([](int, int) { return 0.9; }, 0.01, 0.002,
             [](const SilverRatio& ratio) { EXPECT_EQ(ratio.at(20, 20, 0, 0), 4.0F); });
  with_ratio([](int, int) { return 0.0; }, 0.5, 0.002,
             [](const SilverRatio& ratio) { EXPECT_EQ(ratio.at(20, 20, 0, 0), 0.25F); });
  with_ratio([](int, int) { return 0.0002; }, 0.0001, 0.002,
             [](const SilverRatio& ratio) { EXPECT_NEAR(ratio.at(20, 20, 0, 0), 1, 0.01); });
  with_ratio([](int, int) { return 0.3; }, -1e-7, 0.002,
             [](const SilverRatio& ratio) { EXPECT_NEAR(ratio.at(20, 20, 0, 0), 1, 0.01); });
}

TEST(SilverRatio, NoiseDrawsItToOne) {
  const auto scatter = [](double said) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.3 * 0.4);
    double squares = 0;
    with_ratio([&](int, int) { return std::clamp(0.4 + noise(random), 0.0, 1.0); }, 0.4, said,
               [&squares](const SilverRatio& ratio) {
                 for (int y = 4; y < kPlaneSide - 4; ++y) {
                   for (int x = 4; x < kPlaneSide - 4; ++x)
                     squares += std::pow(static_cast<double>(ratio.at(x, y, 0, 0)) - 1, 2);
                 }
               });
    return std::sqrt(squares / ((kPlaneSide - 8) * (kPlaneSide - 8)));
  };
  EXPECT_NEAR(scatter(0.002), 0.3 * 70 / 256, 0.012);
  EXPECT_LT(scatter(0.3), 0.8 * scatter(0.002));
}

}  // namespace
}  // namespace reseau
