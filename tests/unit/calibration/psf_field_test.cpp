// The optics over a frame against pictures whose optics are known at every place
// (tests/support/edge_renderer).
#include "calibration/psf/psf_field.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/edge/measure_edge.h"
#include "calibration/psf/psf_fit.h"
#include "core/geometry/vec2.h"
#include "tests/support/edge_renderer.h"

namespace reseau {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

struct FieldEdges {
  std::vector<PsfEdge> edges;
  std::vector<Vec2> places;

  void add(int channel, Vec2 at, double normal_deg, std::optional<double> focus,
           const test::Transfer2D& transfer, std::uint32_t seed) {
    test::EdgePicture picture;
    picture.normal_deg = normal_deg;
    picture.noise = 0.003;
    picture.seed = seed;
    test::set_usual_region(picture, 64);
    const std::vector<float> samples = render(picture, transfer);
    const EdgeMeasurement m =
        measure_edge({samples.data(), picture.width_px, picture.height_px}, {.with_profile = true});
    ASSERT_NE(m.status, EdgeStatus::kRefused);
    PsfEdge out;
    out.channel = channel;
    out.focus = focus;
    const double a = m.line.normal_rad;
    out.normal = {std::abs(std::cos(a)), std::abs(std::sin(a))};
    out.reach_px = m.reach_px;
    out.noise = m.noise * m.mtf.inflation;
    out.bins = m.bins;
    out.optics = m.optics;
    out.mtf50_cy_per_px = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
    edges.push_back(std::move(out));
    places.push_back(at);
  }
};

constexpr std::array<double, 4> kAcross{-0.9, -0.3, 0.3, 0.9};
constexpr std::array<double, 3> kDown{-0.8, 0, 0.8};

// Gaussian variance of a channel over the frame, on top of a lens and a pixel.
double variance_at(int channel, Vec2 at) {
  return channel == 1 ? 0.08 + 0.04 * at.x - 0.02 * at.y + 0.06 * at.x * at.x : 0.12 + 0.03 * at.y;
}

test::Transfer2D optics_at(int channel, Vec2 at) {
  const test::Transfer2D lens = test::airy_box_transfer(8);
  const double variance = variance_at(channel, at);
  return [lens, variance](double fx, double fy) {
    return lens(fx, fy) *
           std::exp(-2 * std::numbers::pi * std::numbers::pi * variance * (fx * fx + fy * fy));
  };
}

// Errors over what is claimed, and as they are.
struct Score {
  double z = 0, squares = 0, claimed = 0;
  int n = 0;
  void add(const Measured& m, double truth) {
    z += std::pow((m.value - truth) / m.sd, 2);
    squares += std::pow(m.value - truth, 2);
    claimed += m.sd * m.sd;
    ++n;
  }
  [[nodiscard]] double z_rms() const { return std::sqrt(z / n); }
  void print(const char* what) const {
    std::printf("%s: rms error %.6f, claimed %.6f, z %.3f\n", what, std::sqrt(squares / n),
                std::sqrt(claimed / n), z_rms());
  }
};

FieldEdges frame_of_edges(std::uint32_t seed) {
  FieldEdges all;
  for (const double y : kDown) {
    for (const double x : kAcross) {
      for (const int channel : {0, 1}) {
        all.add(channel, {x, y}, seed % 4 < 2 ? 5 : 95, {}, optics_at(channel, {x, y}), seed);
        ++seed;
      }
    }
  }
  return all;
}

// A row of frames, so that the scatter of the errors can be held against what is claimed.
TEST(EdgeSweep, FieldIsKnownAsWellAsItSays) {
  Score variance, mtf50;
  for (std::uint32_t run = 0; run < 10; ++run) {
    const FieldEdges all = frame_of_edges(1000 * run + 1);
    const PsfFit shared = fit_psf(std::span(all.edges).first(8));
    ASSERT_TRUE(shared.ok);
    const auto field = fit_psf_field(all.edges, all.places, shared);
    ASSERT_TRUE(field);
    EXPECT_TRUE(field->known);
    for (const Vec2 at : {Vec2{-0.7, -0.5}, Vec2{0, 0.2}, Vec2{0.8, 0.6}}) {
      for (const int channel : {0, 1}) {
        const char* const name =
            channel == 0 ? "red.gaussian_variance_px2" : "green.gaussian_variance_px2";
        variance.add(*field->at(name, at.x, at.y), variance_at(channel, at));
        for (const double normal_deg : {0.0, 90.0}) {
          test::EdgePicture picture;
          picture.normal_deg = normal_deg;
          const double a = normal_deg * std::numbers::pi / 180;
          const auto found = field_mtf50(*field, channel, {std::cos(a), std::sin(a)}, at.x, at.y);
          ASSERT_TRUE(found);
          mtf50.add(*found, true_crossing(picture, optics_at(channel, at), 0.5));
        }
      }
    }
  }
  variance.print("Gaussian variance [px^2]");
  mtf50.print("MTF50 [cycles/px]");
  for (const Score* score : {&variance, &mtf50}) {
    EXPECT_GT(score->z_rms(), 0.85);
    EXPECT_LT(score->z_rms(), 1.2);
  }
}

// A field that is bent: the same settings of focus at nine places.
TEST(EdgeSweep, BestFocusBendsOverTheFrame) {
  const auto best_at = [](Vec2 at) { return 200 + 15 * at.x + 30 * at.x * at.x - 10 * at.y; };
  FieldEdges all;
  std::uint32_t seed = 1;
  for (const double y : kDown) {
    for (const double x : {-0.9, 0.0, 0.9}) {
      for (const double focus : {140.0, 200.0, 260.0}) {
        const double waves = 0.01 * (focus - best_at({x, y}));
        all.add(1, {x, y}, seed % 2 == 0 ? 5 : 95, focus, test::airy_box_transfer(8, waves), seed);
        ++seed;
      }
    }
  }
  const PsfFit shared = fit_psf(std::span(all.edges).first(6));
  ASSERT_TRUE(shared.ok);
  const auto field = fit_psf_field(all.edges, all.places, shared);
  ASSERT_TRUE(field);
  EXPECT_EQ(field->find("green.best_focus")->order, 2);
  Score score;
  for (const Vec2 at : {Vec2{0, 0}, Vec2{-0.8, 0.4}, Vec2{0.8, 0.4}, Vec2{0.5, -0.7}}) {
    const Measured best = *field->at("green.best_focus", at.x, at.y);
    EXPECT_LT(std::abs(best.value - best_at(at)), 4 * best.sd);
    EXPECT_LT(best.sd, 3);
    score.add(best, best_at(at));
  }
  score.print("best focus [steps]");
}

TEST(PsfField, EightEdgesTellAQuadraticSurface) {
  FieldEdges all;
  std::uint32_t seed = 1;
  for (const double y : {-0.8, 0.8}) {
    for (const double x : kAcross) {
      all.add(1, {x, y}, seed % 2 == 0 ? 5 : 95, {}, optics_at(1, {x, y}), seed);
      ++seed;
    }
  }
  const PsfFit shared = fit_psf(std::span(all.edges).first(4));
  ASSERT_TRUE(shared.ok);
  const auto field = fit_psf_field(all.edges, all.places, shared);
  ASSERT_TRUE(field);
  const PsfFieldRecord::Surface* surface = field->find("green.gaussian_variance_px2");
  ASSERT_NE(surface, nullptr);
  EXPECT_EQ(surface->order, 2);
  // Two rows do not tell what lies between them.
  EXPECT_FALSE(surface->determined);
  EXPECT_THAT(field->remarks, Contains(HasSubstr("cannot be told with these edges")));
  const NormalCosines normal{1, 0};
  for (const double x : {-0.6, 0.0, 0.6}) {
    const auto found = field_mtf50(*field, 1, normal, x, 0.8);
    ASSERT_TRUE(found);
    test::EdgePicture picture;
    picture.normal_deg = 0;
    const double truth = true_crossing(picture, optics_at(1, {x, 0.8}), 0.5);
    EXPECT_LT(std::abs(found->value - truth), 4 * found->sd);
    EXPECT_LT(found->sd, 0.002);
  }
}

TEST(PsfField, OneEdgeGivesConstantsAndSaysThatTheFieldIsUnknown) {
  FieldEdges one;
  one.add(1, {0.2, -0.1}, 5, {}, optics_at(1, {0, 0}), 1);
  const PsfFit shared = fit_psf(one.edges);
  ASSERT_TRUE(shared.ok);
  const auto field = fit_psf_field(one.edges, one.places, shared);
  ASSERT_TRUE(field);
  EXPECT_FALSE(field->known);
  EXPECT_THAT(field->remarks, Contains(HasSubstr("how sharpness changes over it is unknown")));
  for (const PsfFieldRecord::Surface& s : field->surfaces) EXPECT_EQ(s.order, 0) << s.name;
  const NormalCosines normal{1, 0};
  EXPECT_EQ(*field_mtf50(*field, 1, normal, -1, 1), *field_mtf50(*field, 1, normal, 1, -1));
  EXPECT_FALSE(field_mtf50(*field, 0, normal, 0, 0));
  EXPECT_TRUE(!field->correlated.empty() ||
              field->rank < static_cast<int>(field->coefficients.size()));
}

}  // namespace
}  // namespace reseau
