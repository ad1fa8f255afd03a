// The tables and grids that the reconstruction looks things up in.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/line/memory_line_source.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/map_grid.h"
#include "core/reconstruct/radial_covariance.h"
#include "core/reconstruct/silver_rows.h"

namespace reseau {
namespace {

// A Dufaycolor at 4000 dpi, turned by 23 degrees.
const Mat2 kScreenFromScan{0.117, -0.050, 0.050, 0.118};

BlurLevels levels_at(double sigma_px, double noise_sd, bool detail) {
  BlurLevelSettings settings;
  settings.screen_from_scan = kScreenFromScan;
  settings.noise_sd = noise_sd;
  settings.least_sigma_px = settings.most_sigma_px = sigma_px;
  settings.detail = detail;
  return {ScreenPattern::dufaycolor(), settings};
}

// Silver behind one flat colour, at a pixel that lies at `s`.
double flat_silver(const BlurredCell& cell, const std::array<double, 3>& rgb, Vec2 s) {
  const auto share = cell.shares(static_cast<float>(s.x), static_cast<float>(s.y));
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += static_cast<double>(share[c]) * rgb[c];
  return sum;
}

TEST(RadialCovariance, BlurLowersThePeakAndKeepsAConstant) {
  const std::array<CovarianceTerm, 2> terms{
      {{3.0, std::numeric_limits<double>::infinity()}, {1.0, 5.0}}};
  const RadialCovariance sharp(terms, 0), soft(terms, 1.0);
  EXPECT_NEAR(sharp.at_square(0), 4.0, 2e-2);
  EXPECT_NEAR(sharp.at_square(25), 3 + std::exp(-1.0), 1e-2);
  EXPECT_LT(soft.at_square(0), 3.9);
  EXPECT_GT(soft.at_square(0), 3.7);
  EXPECT_NEAR(soft.at_square(1e6), 3 + std::exp(-26.0 / 5), 1e-2);
}

TEST(ElementKernels, FlatColoursComeBackAtAnyBlurAndPlace) {
  const std::array<double, 3> rgb{0.8, 0.1, 0.35};
  for (const double sigma : {0.45, 0.7, 1.1, 1.6}) {
    const BlurLevels levels = levels_at(sigma, 0.002, false);
    const BlurLevel& level = levels.levels().front();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-0.5, 0.5);
    for (int trial = 0; trial < 20; ++trial) {
      for (std::size_t site = 0; site < levels.sites().size(); ++site) {
        const Vec2 f{any(random), any(random)};
        const float* weight =
            level.elements.of(site, static_cast<float>(f.x), static_cast<float>(f.y));
        double sum = 0, total = 0;
        for (int y = -6; y <= 6; ++y) {
          for (int x = -6; x <= 6; ++x) {
            const Vec2 p{x - f.x, y - f.y};
            const double w = static_cast<double>(weight[(y + 6) * ElementKernels::kRow + x + 6]);
            sum +=
                w * flat_silver(level.cell, rgb, levels.sites()[site].middle + kScreenFromScan * p);
            total += w;
          }
        }
        const auto color = static_cast<std::size_t>(levels.sites()[site].color);
        EXPECT_NEAR(sum, rgb[color], 0.012) << sigma << " px, site " << site;
        EXPECT_NEAR(total, 1, 1e-3);
      }
    }
  }
}

TEST(ElementKernels, NoiseBoundsWhatIsRaised) {
  // At this blur the colours are all but gone; only the noise decides how far they are brought
  // back.
  const double sharp = levels_at(2.6, 0.0005, false).levels().front().elements.noise_gain();
  const double noisy = levels_at(2.6, 0.02, false).levels().front().elements.noise_gain();
  EXPECT_LT(noisy, 0.5 * sharp);
  EXPECT_LT(noisy, 4);
}

// What the element of `site` says of a pattern of silver, given at screen coordinates.
template <typename Silver>
double response_to(const BlurLevels& levels, std::size_t site, Vec2 f, const Silver& silver) {
  const float* weight =
      levels.levels().front().elements.of(site, static_cast<float>(f.x), static_cast<float>(f.y));
  double sum = 0;
  for (int y = -6; y <= 6; ++y) {
    for (int x = -6; x <= 6; ++x) {
      sum += static_cast<double>(weight[(y + 6) * ElementKernels::kRow + x + 6]) *
             silver(levels.sites()[site].middle + kScreenFromScan * Vec2{x - f.x, y - f.y});
    }
  }
  return sum;
}

TEST(ElementKernels, AnAlternationThatIsNotThePicturesIsNotFollowed) {
  BlurLevelSettings settings;
  settings.screen_from_scan = kScreenFromScan;
  settings.noise_sd = 0.05;
  settings.least_sigma_px = settings.most_sigma_px = 0.9;
  const BlurLevels open(ScreenPattern::dufaycolor(), settings);
  settings.line_alternation_sd = 1;
  const BlurLevels blind(ScreenPattern::dufaycolor(), settings);
  const BlurredCell& cell = open.levels().front().cell;
  const auto alternation = [&cell](Vec2 s) {
    const auto share = cell.shares(static_cast<float>(s.x), static_cast<float>(s.y));
    return static_cast<double>(share[0]) * std::cos(2 * std::numbers::pi * s.x);
  };
  const std::array<double, 3> rgb{0.8, 0.1, 0.35};
  const auto flat = [&](Vec2 s) { return flat_silver(cell, rgb, s); };
  for (std::size_t site = 0; site < open.sites().size(); ++site) {
    const Vec2 f{0.2, -0.3};
    const double followed = std::abs(response_to(open, site, f, alternation)),
                 left = std::abs(response_to(blind, site, f, alternation));
    if (open.sites()[site].color == 0) {
      EXPECT_GT(followed, 0.2);
    }
    EXPECT_LT(left, 0.03) << "site " << site;
    const auto color = static_cast<std::size_t>(open.sites()[site].color);
    EXPECT_NEAR(response_to(blind, site, f, flat), rgb[color], 0.03);
  }
}

TEST(DetailKernels, HaveTheSymmetryOfThePattern) {
  const BlurLevels levels = levels_at(0.7, 0.003, true);
  const DetailKernels& detail = *levels.levels().front().detail;
  const float* a = detail.of(0.2F, 0.7F);
  const float* b = detail.of(-0.2F, -0.7F);
  constexpr int kSide = DetailKernels::kSide, kRow = DetailKernels::kRow;
  for (int y = 0; y < kSide; ++y) {
    for (int c = 0; c < 3; ++c) {
      for (int x = 0; x < kSide; ++x) {
        EXPECT_EQ(a[(y * 3 + c) * kRow + x], b[((kSide - 1 - y) * 3 + c) * kRow + kSide - 1 - x]);
      }
    }
  }
}

TEST(BlurLevels, PlacesBetweenLevels) {
  BlurLevelSettings settings;
  settings.screen_from_scan = kScreenFromScan;
  settings.noise_sd = 0.01;
  settings.least_sigma_px = 0.6;
  settings.most_sigma_px = 0.7;
  const BlurLevels levels(ScreenPattern::dufaycolor(), settings);
  ASSERT_GE(levels.levels().size(), 2U);
  EXPECT_EQ(levels.place(0.1).index, 0U);
  EXPECT_EQ(levels.place(0.1).toward_next, 0);
  const BlurLevels::Place last = levels.place(5);
  EXPECT_EQ(last.index + 2, levels.levels().size());
  EXPECT_EQ(last.toward_next, 1);
}

TEST(MapGrid, ThereAndBackOnABentFilm) {
  std::vector<Vec2> bend(30 * 30);
  for (std::size_t i = 0; i < bend.size(); ++i) {
    bend[i] = {0.3 * std::sin(0.4 * static_cast<double>(i % 30)),
               0.3 * std::cos(0.3 * static_cast<double>(i / 30))};
  }
  const ScreenMap map(kScreenFromScan, {17.3, -4.1}, 40, 30, 30, bend);
  const PixelBounds rect{100, 200, 421, 333};
  const Vec2 shift{0.3, -0.2}, origin{20, 30};
  const MapGrid grid(map, shift, rect, origin);
  const InverseMapGrid back(map, shift, rect, origin, grid.lowest(), grid.highest());
  std::vector<ScreenPoint> row;
  for (int y = rect.y0; y < rect.y1; y += 11) {
    grid.row(y, row);
    ASSERT_EQ(row.size(), static_cast<std::size_t>(rect.width()));
    for (int x = rect.x0; x < rect.x1; x += 7) {
      const Vec2 p{static_cast<double>(x), static_cast<double>(y)};
      const Vec2 exact = map.screen_from_scan(p - shift) - origin;
      const ScreenPoint s = row[static_cast<std::size_t>(x - rect.x0)];
      EXPECT_NEAR(static_cast<double>(s.u), exact.x, 2e-3);
      EXPECT_NEAR(static_cast<double>(s.v), exact.y, 2e-3);
      const Vec2 again = back.at(exact);
      EXPECT_NEAR(again.x, p.x, 0.06);
      EXPECT_NEAR(again.y, p.y, 0.06);
    }
  }
}

TEST(SilverRows, ContinueThePatternBeyondTheFrame) {
  LineFormat format;
  format.width_px = 90;
  format.n_lines = 80;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  const BlurredCell cell(ScreenPattern::dufaycolor(), kScreenFromScan, 0.9);
  const auto silver = [&](int x, int y) {
    return flat_silver(cell, {0.9, 0.2, 0.1},
                       kScreenFromScan * Vec2{static_cast<double>(x), static_cast<double>(y)});
  };
  std::vector<std::uint16_t> samples(format.samples_per_line() * 80, 65535);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 90; ++x) {
      samples[(static_cast<std::size_t>(y) * 4 + 3) * 90 + static_cast<std::size_t>(x)] =
          static_cast<std::uint16_t>(std::lround(65535 * silver(x, y)));
    }
  }
  const MemoryLineSource source(format, samples);
  const ToneCurves tone = ToneCurves::linear();
  const Mat2 back = kScreenFromScan.inverse();
  const SilverSettings settings{
      &source, &tone, 1.0, true, {}, 0, {Vec2{back.a, back.c}, Vec2{back.b, back.d}}, 20};
  const SilverRows rows(settings, 0, 80);
  double worst_inside = 0, worst_beyond = 0;
  for (int y = -20; y < 100; ++y) {
    for (int x = -20; x < 110; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < 90 && y < 80;
      const double error = std::abs(static_cast<double>(*rows.at(x, y)) - silver(x, y));
      double& worst_here = inside ? worst_inside : worst_beyond;
      worst_here = std::max(worst_here, error);
    }
  }
  EXPECT_LT(worst_inside, 1e-4);
  EXPECT_LT(worst_beyond, 0.03);
  EXPECT_EQ(rows.clipped()[0], 90U * 80U);
  EXPECT_EQ(rows.clipped()[3], 0U);
}

TEST(ToneCurves, RefuseWhatIsNoNumber) {
  std::vector<float> table(65536, 0.5F);
  EXPECT_FALSE(ToneCurves({table, table, table, table}).is_linear());
  EXPECT_TRUE(ToneCurves::linear().is_linear());
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    table[77] = bad;
    EXPECT_THROW((void)ToneCurves({table, table, table, table}), InputError);
  }
}

}  // namespace
}  // namespace reseau
