// One model for many edges, against pictures whose optics are known (tests/support/edge_renderer).
#include "calibration/psf/psf_fit.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/edge/measure_edge.h"
#include "tests/support/edge_renderer.h"

namespace reseau {
namespace {

struct Wanted {
  int channel = 1;
  double normal_deg = 5;
  std::optional<double> focus;
  test::Transfer2D transfer;
};

PsfEdge edge_of(const Wanted& wanted, std::uint32_t seed) {
  test::EdgePicture picture;
  picture.normal_deg = wanted.normal_deg;
  picture.noise = 0.003;
  picture.seed = seed;
  test::set_usual_region(picture, 80);
  const std::vector<float> samples = render(picture, wanted.transfer);
  const EdgeMeasurement m =
      measure_edge({samples.data(), picture.width_px, picture.height_px}, {.with_profile = true});
  EXPECT_NE(m.status, EdgeStatus::kRefused);
  PsfEdge out;
  out.channel = wanted.channel;
  out.focus = wanted.focus;
  const double a = m.line.normal_rad;
  out.normal = {std::abs(std::cos(a)), std::abs(std::sin(a))};
  out.reach_px = m.reach_px;
  out.noise = m.noise * m.mtf.inflation;
  out.bins = m.bins;
  out.optics = m.optics;
  out.mtf50_cy_per_px = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
  return out;
}

std::vector<PsfEdge> edges_of(const std::vector<Wanted>& wanted) {
  std::vector<PsfEdge> out;
  std::uint32_t seed = 1;
  for (const Wanted& w : wanted) out.push_back(edge_of(w, seed++));
  return out;
}

double value(const PsfFit& fit, const std::string& name) {
  const PsfParameter* p = fit.find(name);
  EXPECT_NE(p, nullptr) << name;
  return p == nullptr ? NAN : p->value;
}

void expect_within_its_error(const PsfFit& fit, const std::string& name, double truth,
                             double most_sd) {
  const PsfParameter* p = fit.find(name);
  ASSERT_NE(p, nullptr) << name;
  EXPECT_TRUE(p->determined) << name;
  EXPECT_LT(p->sd, most_sd) << name;
  EXPECT_LT(std::abs(p->value - truth), 4 * p->sd + 1e-4)
      << name << " " << p->value << " +- " << p->sd << ", truth " << truth;
}

// A lens f/8 at 0.55 um on pixels of 4.73 um.
constexpr double kCutOff = 0.55 * 8 / 4.73;

TEST(PsfFit, LensAndApertureOfEdgesInBothDirections) {
  const test::Transfer2D optics = test::airy_box_transfer(8);
  const PsfFit fit =
      fit_psf(edges_of({{1, 5, {}, optics}, {1, 95, {}, optics}, {1, 22, {}, optics}}));
  ASSERT_TRUE(fit.ok) << fit.why;
  EXPECT_NEAR(value(fit, "aperture_x_px"), 1, 0.05);
  EXPECT_NEAR(value(fit, "aperture_y_px"), 1, 0.05);
  EXPECT_NEAR(value(fit, "green.diffraction_px"), kCutOff, 0.1);
  EXPECT_NEAR(fit.chi2_per_freedom, 1, 0.15);
  EXPECT_FALSE(fit.has_halo);
  for (const double rms : fit.misfit) EXPECT_LT(rms, 0.004);
}

TEST(PsfFit, EachSideOfAnApertureThatIsNotSquare) {
  // 2 px along y: what a smear of sqrt(3) px on a box of 1 px looks like at low frequencies.
  const test::Transfer2D lens = test::airy_box_transfer(5.6);
  const auto oblong = [&](double fx, double fy) {
    const double y = std::numbers::pi * fy, two = 2 * y;
    const double was = std::abs(y) < 1e-9 ? 1 : std::sin(y) / y;
    const double is = std::abs(two) < 1e-9 ? 1 : std::sin(two) / two;
    return std::abs(was) < 1e-9 ? 0.0 : lens(fx, fy) * is / was;
  };
  const PsfFit fit = fit_psf(edges_of({{1, 5, {}, oblong}, {1, 95, {}, oblong}}));
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(value(fit, "aperture_y_px") / value(fit, "aperture_x_px"), 2, 0.12);
}

TEST(PsfFit, ASharedHaloIsFoundAndOnlyWhereItIs) {
  const test::Transfer2D optics = test::with_halo(test::airy_box_transfer(8), 0.1, 6);
  const PsfFit fit = fit_psf(edges_of({{0, 5, {}, optics}, {1, 5, {}, optics}}));
  ASSERT_TRUE(fit.ok);
  ASSERT_TRUE(fit.has_halo);
  EXPECT_NEAR(value(fit, "halo_share"), 0.1, 0.01);
  EXPECT_NEAR(value(fit, "halo_sigma_px"), 6, 0.6);
}

// A step moves the film by the same length in every light: 0.01 waves in green, fewer in infrared,
// whose best focus lies beside the settings' middle.
TEST(PsfFit, BestFocusOfEachChannelAndTheLengthOfAStep) {
  std::vector<Wanted> wanted;
  constexpr double kGreen = 0.53, kInfrared = 0.87;
  for (const double focus : {120.0, 160.0, 200.0, 240.0, 280.0}) {
    wanted.push_back({1, 5, focus, test::airy_box_transfer(8, 0.01 * (focus - 200))});
    wanted.push_back(
        {3, 5, focus, test::airy_box_transfer(11, 0.01 * kGreen / kInfrared * (focus - 265))});
  }
  const PsfFit fit = fit_psf(edges_of(wanted));
  ASSERT_TRUE(fit.ok);
  ASSERT_TRUE(fit.has_focus);
  expect_within_its_error(fit, "green.best_focus", 200, 3);
  expect_within_its_error(fit, "infrared.best_focus", 265, 5);
  expect_within_its_error(fit, "defocus_path_um_per_step", 0.01 * kGreen, 5e-4);
  expect_within_its_error(fit, "infrared.defocus_waves_per_step", 0.01 * kGreen / kInfrared, 1e-3);
  EXPECT_NEAR(fit.chi2_per_freedom, 1, 0.15);
  for (const PsfParameter& p : fit.parameters) {
    if (p.name.find("best_focus") != std::string::npos) {
      std::printf("%s %.3f +- %.3f\n", p.name.c_str(), p.value, p.sd);
    }
  }
}

TEST(PsfFit, WhatOneEdgeCannotTellIsSaid) {
  const PsfFit fit = fit_psf(edges_of({{1, 5, {}, test::gaussian_transfer(0.12)}}));
  ASSERT_TRUE(fit.ok);
  // Lens, aperture and Gaussian of one blurred edge trade for one another.
  EXPECT_TRUE(!fit.correlated.empty() || fit.rank < 4);
  EXPECT_THAT(fit.remarks,
              ::testing::Contains(::testing::HasSubstr("aperture is taken as square")));
  EXPECT_THAT(fit.remarks, ::testing::Contains(::testing::HasSubstr("best focus cannot be told")));
  for (const PsfParameter& p : fit.parameters) {
    EXPECT_TRUE(std::isfinite(p.value)) << p.name;
    EXPECT_TRUE(std::isfinite(p.sd) || !p.determined) << p.name;
  }
}

TEST(PsfFit, EndsWhenItIsToldTo) {
  const std::vector<PsfEdge> edges = edges_of({{1, 5, {}, test::airy_box_transfer(8)}});
  int asked = 0;
  const PsfFit fit = fit_psf(edges, [&] { return ++asked > 3; });
  EXPECT_FALSE(fit.ok);
  EXPECT_NE(fit.why.find("Stopped"), std::string::npos) << fit.why;
  EXPECT_LT(asked, 12);
}

TEST(PsfFit, NothingComesOfNothing) {
  const PsfFit fit = fit_psf({});
  EXPECT_FALSE(fit.ok);
  EXPECT_FALSE(fit.why.empty());
}

}  // namespace
}  // namespace reseau
