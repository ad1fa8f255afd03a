// Characteristic curve, spread, grain, dyes and printing errors of the simulated film.
#include <algorithm>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/film/printing_noise.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(HdCurve, FallsMonotonicallyBetweenItsDensities) {
  const HdCurve curve({.gamma = 1.6, .d_min = 0.08, .d_max = 2.4, .toe = 0.15, .log_speed = -0.1});
  double last = 0;
  for (double e = 1e-6; e < 20; e *= 1.01) {
    const double t = curve.transmittance(e);
    ASSERT_GE(t, last * (1 - 1e-12));
    last = t;
  }
  EXPECT_NEAR(-std::log10(curve.transmittance(0)), 2.4, 1e-12);
  EXPECT_NEAR(-std::log10(curve.transmittance(1e-6)), 2.4, 1e-4);
  EXPECT_NEAR(-std::log10(curve.transmittance(1e4)), 0.08, 1e-4);
  // The slope of the straight line, far from both ends.
  const double slope =
      -std::log10(curve.transmittance(0.11) / curve.transmittance(0.1)) / std::log10(1.1);
  EXPECT_NEAR(-slope, 1.6, 0.01);
}

TEST(HdCurve, TheTableFollowsTheFormula) {
  const HdCurve curve({.gamma = 1.4, .d_min = 0.05, .d_max = 2.6, .toe = 0.1, .log_speed = 0});
  double worst = 0;
  for (double e = 1e-4; e < 4; e *= 1.0007) {
    std::array<float, 1> value{static_cast<float>(e)};
    curve.apply(value);
    worst = std::max(worst, std::abs(static_cast<double>(value[0]) - curve.transmittance(e)));
  }
  std::cout << "table against formula: " << worst << "\n";
  EXPECT_LT(worst, 2e-5);
}

TEST(HdCurve, TendsToTheIdentityAndIsItAtGammaZero) {
  const HdCurve straight({.gamma = 1, .d_min = 0, .d_max = 5, .toe = 0.01, .log_speed = 0});
  for (const double e : {0.002, 0.03, 0.3, 0.9}) {
    EXPECT_NEAR(straight.transmittance(e), e, 3e-4 * e + 1e-5);
  }
  const std::string plain = "ls5000?width_px=160&height_px=120&scene=natural";
  const SimulatedScan a = simulate_frame(parse_sim_spec(plain));
  const SimulatedScan b =
      simulate_frame(parse_sim_spec(plain + "&hd_gamma=0&hd_dmax=2&hd_dmin=0.3&hd_toe=0.5"));
  EXPECT_EQ(a.samples, b.samples);
}

TEST(HdCurve, IsTheTruthOfAPatch) {
  const SimSpec spec = parse_sim_spec(
      "ls5000?width_px=600&height_px=500&noise=0&hd_gamma=1.5&taking=dufay&ir_blur_px=0.3");
  const FilmTruth truth(spec.film, {.width_px = 600, .n_lines = 500});
  for (const Patch& patch : truth.patches()) {
    const auto rgb = truth.process_rgb((patch.x0 + patch.x1) / 2, (patch.y0 + patch.y1) / 2);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(rgb[k], patch.rgb[k], 3e-5);
  }
}

TEST(Emulsion, SpreadIsTheGaussianOfItsWidth) {
  // Red lines on a film that only red exposed: the fundamental of the silver falls by the transfer
  // function of the Gaussian, whichever of the two spreads it is.
  auto raster = std::make_shared<SceneRaster>();
  raster->width_px = raster->height_px = 1;
  raster->rgb = {0.8F, 0.0F, 0.0F};
  const auto fundamental = [&](const std::string& settings) {
    FilmSpec spec =
        parse_sim_spec("ls5000?width_px=400&height_px=400&border_px=0&scene=image&" + settings)
            .film;
    spec.raster = raster;
    const FilmStrip strip(spec);
    const ElementPainter painter(spec);
    const SilverLayer silver(spec, strip, &painter);
    PlaneRow row;
    std::complex<double> sum = 0;
    for (int j = 0; j < 4 * 96; ++j) {
      const double y = 96 + cell_offset_px(j, 4);
      silver.field(y, {96, 96, 4}, row);
      const double wy = 0.5 - 0.5 * std::cos(2 * kPi * (j + 0.5) / 384);
      for (int s = 0; s < 4; ++s) {
        for (int i = 0; i < 96; ++i) {
          const double w = wy * (0.5 - 0.5 * std::cos(2 * kPi * (i + (s + 0.5) / 4) / 96));
          const double v = painter.screen().screen_from_scan(96 + i + cell_offset_px(s, 4), y).v;
          sum += w * static_cast<double>(row.phase(0, s)[i]) * std::polar(1.0, -2 * kPi * v);
        }
      }
    }
    return std::abs(sum);
  };
  const double narrow = fundamental("spread_um=2");
  const double cy_per_um = 1 / (49.9 * std::sin(89.4 * kPi / 180));
  const auto otf = [&](double sigma_um) {
    return std::exp(-2 * kPi * kPi * sigma_um * sigma_um * cy_per_um * cy_per_um);
  };
  EXPECT_NEAR(fundamental("spread_um=5") / narrow, otf(5) / otf(2), 2e-3);
  EXPECT_NEAR(fundamental("silver_spread_um=5") / narrow, otf(5) / otf(2), 2e-3);
  EXPECT_NEAR(fundamental("spread_um=3&silver_spread_um=4") / narrow, otf(5) / otf(2), 2e-3);
}

TEST(Grain, HasItsSizeAtDensityOneAndKeepsTheMean) {
  constexpr double kAmount = 0.10;
  const Grain grain(kAmount, 2.5 / 6.35, 7);
  for (const double density : {1.0, 0.25}) {
    constexpr int kPixels = 128, kPer = 4;
    const auto t = static_cast<float>(std::pow(10.0, -density));
    std::vector<float> silver(static_cast<std::size_t>(kPixels * kPer), t), factor(silver.size()),
        depth(silver.size());
    grain.depths(silver, depth);
    double sum = 0, squares = 0;
    for (int row = 0; row < kPixels; ++row) {
      std::vector<double> pixel(kPixels, 0.0);
      for (int k = 0; k < kPer; ++k) {
        grain.texture(row + cell_offset_px(k, kPer), 0, 1.0 / kPer, factor);
        for (std::size_t i = 0; i < factor.size(); ++i) {
          ASSERT_GT(factor[i], -1) << "silver stays positive";
          factor[i] = 1 + depth[i] / t * factor[i];
        }
        for (std::size_t i = 0; i < factor.size(); ++i) {
          pixel[i / kPer] += static_cast<double>(factor[i]) / (kPer * kPer);
        }
      }
      for (const double v : pixel) {
        sum += v;
        squares += v * v;
      }
    }
    constexpr double kN = kPixels * kPixels;
    const double mean = sum / kN, rms = std::sqrt(squares / kN - mean * mean);
    std::cout << "grain at density " << density << ": mean " << mean << ", relative rms " << rms
              << "\n";
    RecordProperty("relative_rms_at_" + std::to_string(density), std::to_string(rms));
    EXPECT_NEAR(mean, 1, 4e-3);
    EXPECT_NEAR(rms, kAmount * std::sqrt(density), 0.05 * kAmount);
  }
  std::vector<float> clear(64, 1.0F), depth(64);
  grain.depths(clear, depth);
  for (const float d : depth) EXPECT_NEAR(d, 0, 1e-5);  // no silver, no grain
}

TEST(Grain, IsCorrelatedOverItsSizeAndNotBeyond) {
  constexpr double kKnot = 0.5;  // px
  const Grain grain(0.1, kKnot, 3);
  constexpr int kN = 512, kPerKnot = 4;
  std::vector<float> row(kN * kPerKnot);
  std::array<double, 6> product{};  // at lags of whole knots
  for (int y = 0; y < 64; ++y) {
    grain.field(y * 5.13, 0, kKnot / kPerKnot, row);
    for (std::size_t lag = 0; lag < 6; ++lag) {
      for (std::size_t i = 0; i + lag * kPerKnot < row.size(); ++i) {
        product[lag] += static_cast<double>(row[i] * row[i + lag * kPerKnot]);
      }
    }
  }
  EXPECT_NEAR(product[0] / (64.0 * kN * kPerKnot), 1, 0.05);
  // The B-spline of degree 7 at 1, 2, 3 over its value at 0: 1191, 120, 1 of 2416.
  EXPECT_NEAR(product[1] / product[0], 1191.0 / 2416, 0.02);
  EXPECT_NEAR(product[2] / product[0], 120.0 / 2416, 0.02);
  EXPECT_NEAR(product[3] / product[0], 1.0 / 2416, 0.02);
  EXPECT_NEAR(product[5] / product[0], 0, 0.02);
}

TEST(Grain, BelongsToTheFilmNotToTheScan) {
  const Grain grain(0.1, 0.4, 9);
  std::vector<float> forward(200), part(50), backward(200);
  grain.field(12.3, 5, 0.25, forward);
  grain.field(12.3, 5 + 100 * 0.25, 0.25, part);
  grain.field(12.3, 5 + 199 * 0.25, -0.25, backward);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_NEAR(part[i], forward[100 + i], 1e-5);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_NEAR(backward[i], forward[199 - i], 1e-5);
}

TEST(Dyes, SpectraFadeToNothingAndMeasuredOnesToGrey) {
  const DyeSetResponse fresh = dye_set_response({DyeSource::kHarrisonHorner, 0, 0});
  const DyeSetResponse faded = dye_set_response({DyeSource::kHarrisonHorner, 1, 0});
  for (std::size_t set = 0; set < 8; ++set) {
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(faded[set][c], 1, 1e-9);
  }
  // Each dye passes its own light best; two over each other pass less than either.
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& own = fresh[std::size_t{1} << k];
    for (std::size_t c = 0; c < 3; ++c) {
      if (c != k) {
        EXPECT_GT(own[k], 3 * own[c]);
      }
    }
  }
  EXPECT_LT(fresh[3][0], fresh[1][0]);
  EXPECT_LT(fresh[3][1], fresh[2][1]);
  const ElementResponse measured = element_response(0.3);
  const DyeSetResponse sets = dye_set_response({DyeSource::kMeasured, 0.3, 0});
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(sets[std::size_t{1} << k][c], measured[k][c]);
    }
    EXPECT_EQ(sets[std::size_t{1} << k][3], 1);
  }
}

TEST(Dyes, LeakIntoInfraredWithTheirDensityInRed) {
  const DyeSetResponse r = dye_set_response({DyeSource::kNeblette, 0, 0.1});
  for (const std::size_t set : {1U, 2U, 4U}) {
    EXPECT_NEAR(std::log10(r[set][3]), 0.1 * std::log10(r[set][0]), 1e-9);
  }
  EXPECT_EQ(r[0][3], 1);
}

TEST(Taking, KeepsNeutralNeutralAndMixesColours) {
  const Taking taking = make_taking(false);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& row = taking.matrix[k];
    EXPECT_NEAR(row[0] + row[1] + row[2], 1, 1e-12);
    EXPECT_GT(row[k], 0.5);
    EXPECT_LT(row[k], 1);
  }
  EXPECT_GT(taking.gain[0], 2);    // bare emulsion sees more than through a filter
  EXPECT_LT(taking.gain[3], 0.3);  // two filters pass little
}

TEST(PrintingNoise, HasUnitSpreadAlongEveryLine) {
  PrintSpec spec;
  spec.position_noise_um = 1;
  spec.missing = 0.1;
  PrintingNoise noise(spec, 5);
  double squares = 0, product = 0, far = 0;
  int missing = 0;
  constexpr int kLines = 400, kPlaces = 100;
  for (int line = 0; line < kLines; ++line) {
    missing += noise.is_missing(line - 200) ? 1 : 0;
    for (int i = 0; i < kPlaces; ++i) {
      const double place = 0.37 * i;
      const double here = static_cast<double>(noise.line(line - 200, place).across);
      squares += here * here;
      product += here * static_cast<double>(noise.line(line - 200, place + 0.25).across);
      far += here * static_cast<double>(noise.line(line - 200, place + 2.5).across);
    }
  }
  constexpr double kN = kLines * kPlaces;
  EXPECT_NEAR(std::sqrt(squares / kN), 1, 0.05);
  EXPECT_GT(product / squares, 0.7);
  EXPECT_NEAR(far / squares, 0, 0.05);
  EXPECT_NEAR(missing / double{kLines}, 0.1, 0.05);
}

TEST(PrintingNoise, MissingLinesShowWhatLiesBeneath) {
  const auto red_area = [](const std::string& settings) {
    const ElementPainter painter(parse_sim_spec("ls5000?" + settings).film);
    PlaneRow row;
    double sum = 0;
    for (int j = 0; j < 400; ++j) {
      painter.areas(j * 1.5, 0, 320, 1, row);
      const auto red = std::ranges::find(painter.sets(), 1) - painter.sets().begin();
      for (int i = 0; i < 320; ++i) {
        sum += static_cast<double>(row.phase(static_cast<int>(red), 0)[i]);
      }
    }
    return sum / (400 * 320);
  };
  EXPECT_NEAR(red_area(""), 0.4208, 0.01);
  EXPECT_NEAR(red_area("missing=0.3"), 0.7 * 0.4208, 0.05);
  EXPECT_NEAR(red_area("position_noise_um=1&width_noise_um=1"), 0.4208, 0.01);
}

}  // namespace
}  // namespace reseau::sim
