// Deconvolution of the silver: how much sharper, with which noise, and that nothing rings where the
// frame ends or dust lies.
#include "core/reconstruct/deconvolution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/line/memory_line_source.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/sharpness_field.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/silver_sharpener.h"
#include "core/reconstruct/tone_curve.h"
#include "core/screen/screen_pattern.h"

namespace reseau {
namespace {

constexpr int kFrameSide = 200;
constexpr double kNoise = 0.003;
const Mat2 kTurnedScreen{0.117, -0.050, 0.050, 0.118};
constexpr std::array kMethods{Deconvolution::kWiener, Deconvolution::kRichardsonLucy};

BlurLevels sharpened_levels(Deconvolution method, double least_px, double most_px) {
  BlurLevelSettings settings;
  settings.screen_from_scan = kTurnedScreen;
  settings.noise_sd = kNoise;
  settings.least_sigma_px = least_px;
  settings.most_sigma_px = most_px;
  settings.ratio = 1.15;
  settings.deconvolution = method;
  return {ScreenPattern::dufaycolor(), settings};
}

std::array<Vec2, 2> periods_px() {
  const Mat2 inverse = kTurnedScreen.inverse();
  return {Vec2{inverse.a, inverse.c}, Vec2{inverse.b, inverse.d}};
}

// Calls body with the rows of a frame of silver(x, y), sharpened.
template <typename Silver, typename Body>
void with_sharpened(const Silver& silver, const SilverSharpener* sharpener, const Body& body) {
  LineFormat format;
  format.width_px = format.n_lines = kFrameSide;
  format.channels = {Channel::kInfrared};
  std::vector<std::uint16_t> samples;
  for (int y = 0; y < kFrameSide; ++y) {
    for (int x = 0; x < kFrameSide; ++x)
      samples.push_back(
          static_cast<std::uint16_t>(std::lround(65535 * std::clamp(silver(x, y), 0.0, 1.0))));
  }
  const MemoryLineSource source(format, std::move(samples));
  const ToneCurves tone = ToneCurves::linear();
  SilverSettings settings;
  settings.source = &source;
  settings.tone = &tone;
  settings.period_px = periods_px();
  settings.margin_px = 20;
  settings.sharpener = sharpener;
  body(SilverRows(settings, 0, kFrameSide));
}

// Half the swing of a wave along x about column x0.
double amplitude(const SilverRows& rows, double f, int x0) {
  double sine = 0, cosine = 0;
  const int n = static_cast<int>(std::round(4 / f));
  for (int x = x0; x < x0 + n; ++x) {
    const double phase = 2 * std::numbers::pi * f * x,
                 value = static_cast<double>(*rows.at(x, 100));
    sine += value * std::sin(phase);
    cosine += value * std::cos(phase);
  }
  return 2 * std::hypot(sine, cosine) / n;
}

TEST(Deconvolution, IsChosenByName) {
  for (const Deconvolution method : kMethods)
    EXPECT_EQ(parse_deconvolution(deconvolution_name(method)), method);
  EXPECT_EQ(parse_deconvolution("none"), Deconvolution::kNone);
  EXPECT_THROW((void)parse_deconvolution("unsharp"), InputError);
}

TEST(Deconvolution, RaisesTheTransferWithinItsBounds) {
  const BlurShape round;
  for (const Deconvolution method : kMethods) {
    for (const double sigma : {0.6, 1.0, 1.5}) {
      const SharpeningKernel kernel(method, round, sigma, kNoise);
      EXPECT_NEAR(kernel.gain({0, 0}), 1, 1e-5);
      for (double f = 0.02; f <= 0.5; f += 0.02) {
        const double before = round.transfer({f, 0}, sigma), after = before * kernel.gain({f, 0});
        EXPECT_LT(kernel.gain({f, 0}), 1.1 * SharpeningKernel::kMostGain);
        EXPECT_LT(after, 1.08);
        if (f < 0.3) {
          EXPECT_GT(after, before) << f;
        }
      }
      // At the réseau's own frequency most of the transfer is back.
      EXPECT_GT(round.transfer({0.127, 0}, sigma) * kernel.gain({0.127, 0}), 0.75) << sigma;
      const SharpeningKernel noisy(method, round, sigma, 0.3);
      if (method == Deconvolution::kWiener) {
        EXPECT_LT(noisy.noise_gain(), kernel.noise_gain());
      }
      if (method == Deconvolution::kRichardsonLucy) {
        EXPECT_GE(kernel.iterations(), 1);
        EXPECT_LE(kernel.iterations(), SharpeningKernel::kMostIterations);
      }
    }
  }
}

TEST(SilverSharpener, GivesAWaveBackByTheGainOfItsPlace) {
  constexpr double kF = 0.16, kSwing = 0.05;
  // From 0.6 px on the left to 1.2 px on the right, in variance.
  const BlurSurface blur({0.9, 0.54, 0}, {kFrameSide, kFrameSide}, 0.6, 1.2);
  for (const Deconvolution method : kMethods) {
    const BlurLevels levels = sharpened_levels(method, 0.6, 1.2);
    const SilverSharpener sharpener(levels, blur, periods_px());
    with_sharpened(
        [&](int x, int) { return 0.4 + kSwing * std::sin(2 * std::numbers::pi * kF * x); },
        &sharpener,
        [&](const SilverRows& rows) {
          for (const int x0 : {30, 85, 145}) {
            const BlurLevels::Place place = levels.place(blur.sigma_px({x0 + 12.5, 100}));
            const auto gain = [&](std::size_t level) {
              return levels.levels()[level].sharpening->gain({kF, 0});
            };
            const double expected =
                gain(place.index) + static_cast<double>(place.toward_next) *
                                        (gain(place.index + 1) - gain(place.index));
            EXPECT_NEAR(amplitude(rows, kF, x0) / kSwing, expected, 0.06 * expected)
                << deconvolution_name(method) << " at " << x0;
          }
        });
  }
}

// The silver behind one flat colour, and what it should become.
struct FlatColour {
  explicit FlatColour(const BlurLevels& levels, double sigma)
      : before(ScreenPattern::dufaycolor(), kTurnedScreen, sigma), after(levels.levels()[0].cell) {}

  [[nodiscard]] static double of(const BlurredCell& cell, int x, int y) {
    const Vec2 s = kTurnedScreen * Vec2{static_cast<double>(x), static_cast<double>(y)};
    const auto share = cell.shares(static_cast<float>(s.x), static_cast<float>(s.y));
    return 0.5 * static_cast<double>(share[0]) + 0.3 * static_cast<double>(share[1]) +
           0.4 * static_cast<double>(share[2]);
  }
  BlurredCell before;
  const BlurredCell& after;
};

TEST(SilverSharpener, NothingRingsAtTheBordersOfTheFrame) {
  for (const Deconvolution method : kMethods) {
    const BlurLevels levels = sharpened_levels(method, 0.9, 0.9);
    const BlurSurface blur(0.9);
    const SilverSharpener sharpener(levels, blur, periods_px());
    const FlatColour colour(levels, 0.9);
    with_sharpened([&](int x, int y) { return FlatColour::of(colour.before, x, y); }, &sharpener,
                   [&](const SilverRows& rows) {
                     double inside = 0, border = 0;
                     for (int y = 0; y < kFrameSide; ++y) {
                       for (int x = 0; x < kFrameSide; ++x) {
                         const double off = std::abs(static_cast<double>(*rows.at(x, y)) -
                                                     FlatColour::of(colour.after, x, y));
                         const int depth = std::min({x, y, kFrameSide - 1 - x, kFrameSide - 1 - y});
                         double& most = depth < 16 ? border : inside;
                         most = std::max(most, off);
                       }
                     }
                     EXPECT_LT(inside, 0.02) << deconvolution_name(method);
                     EXPECT_LT(border, inside + 0.02) << deconvolution_name(method);
                   });
  }
}

TEST(SilverSharpener, NothingRingsAboutDust) {
  constexpr double kMiddle = 100.3, kRadius = 5;
  for (const Deconvolution method : kMethods) {
    const BlurLevels levels = sharpened_levels(method, 0.9, 0.9);
    const BlurSurface blur(0.9);
    const SilverSharpener sharpener(levels, blur, periods_px());
    const FlatColour colour(levels, 0.9);
    const auto distance = [](int x, int y) { return std::hypot(x - kMiddle, y - kMiddle); };
    with_sharpened(
        [&](int x, int y) {
          // The rim of an opaque speck under the same blur.
          const double passes =
              0.5 * (1 + std::erf((distance(x, y) - kRadius) / (0.9 * std::numbers::sqrt2)));
          return passes * FlatColour::of(colour.before, x, y);
        },
        &sharpener,
        [&](const SilverRows& rows) {
          double most = -1, least = 1;
          for (int y = 70; y < 130; ++y) {
            for (int x = 70; x < 130; ++x) {
              if (distance(x, y) < kRadius + 6) continue;
              const double off =
                  static_cast<double>(*rows.at(x, y)) - FlatColour::of(colour.after, x, y);
              most = std::max(most, off);
              least = std::min(least, off);
            }
          }
          EXPECT_LT(most, 0.03) << deconvolution_name(method);
          EXPECT_GT(least, -0.03) << deconvolution_name(method);
          // The speck itself is no brighter than it was.
          EXPECT_LT(*rows.at(100, 100), 0.01F);
          EXPECT_GE(*rows.at(100, 100), 0.0F);
        });
  }
}

}  // namespace
}  // namespace reseau
