// Registration errors whose size is known: shifts, half periods, other labels, mistakes.
#include "capture/compare/map_error.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace reseau::compare {
namespace {

constexpr int kWidth = 150, kHeight = 130;

struct Uv {
  double u, v;
};
using Map = std::function<Uv(double x, double y)>;

// Dufaycolor at 23 degrees and 4000 dpi: periods of some 7.8 px.
Uv lattice(double x, double y) {
  return {0.118 * x + 0.050 * y + 3.3, -0.051 * x + 0.117 * y + 7.1};
}

MapRows rows(const Map& map) {
  return [map](int first, int n, std::span<float> out) {
    std::size_t i = 0;
    for (int y = first; y < first + n; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Uv uv = map(x, y);
        out[i++] = static_cast<float>(uv.u);
        out[i++] = static_cast<float>(uv.v);
      }
    }
  };
}

MapError compare(const Map& b, const Map& a = lattice) {
  return compare_maps(kWidth, kHeight, 0, rows(a), rows(b));
}

TEST(MapError, OfEqualMapsIsNothing) {
  const MapError error = compare(lattice);
  EXPECT_EQ(error.n, kWidth * kHeight);
  EXPECT_LT(error.max_px, 1e-6);
  EXPECT_EQ(error.n_slipped, 0);
  EXPECT_NEAR(error.period_u_px, std::hypot(0.117, 0.051) / (0.118 * 0.117 + 0.051 * 0.050), 1e-3);
}

TEST(MapError, AShiftIsSeenInPixelsWithItsDirection) {
  // B says at p what A says at p + (0.5, -0.25).
  const MapError error = compare([](double x, double y) { return lattice(x + 0.5, y - 0.25); });
  EXPECT_NEAR(error.mean_x_px, 0.5, 1e-4);
  EXPECT_NEAR(error.mean_y_px, -0.25, 1e-4);
  EXPECT_NEAR(error.rms_px, std::hypot(0.5, 0.25), 1e-4);
  EXPECT_NEAR(error.max_px, error.rms_px, 1e-3);
  EXPECT_LT(error.rms_without_mean_px, 1e-3);
}

TEST(MapError, OtherOriginsAndDirectionsAreTheSameLattice) {
  for (const double su : {1.0, -1.0}) {
    for (const double sv : {1.0, -1.0}) {
      const MapError error = compare([su, sv](double x, double y) {
        const Uv uv = lattice(x, y);
        return Uv{su * (uv.u + 17), sv * (uv.v - 4)};
      });
      EXPECT_LT(error.max_px, 1e-3) << su << " " << sv;
      EXPECT_EQ(error.equivalence.sign_u, su);
      EXPECT_EQ(error.equivalence.sign_v, sv);
      EXPECT_FALSE(error.equivalence.swapped);
      EXPECT_EQ(error.n_slipped, 0);
    }
  }
}

TEST(MapError, HalfAPeriodShowsInEveryLabelling) {
  // Green and blue exchanged.
  for (const double sign : {1.0, -1.0}) {
    const MapError error = compare([sign](double x, double y) {
      const Uv uv = lattice(x, y);
      return Uv{sign * (uv.u + 0.5), uv.v};
    });
    EXPECT_NEAR(error.rms_px, error.period_u_px / 2, 1e-3) << sign;
    EXPECT_EQ(error.n_slipped, 0);
  }
}

TEST(MapError, ExchangedAxesAreUndoneAndSaid) {
  const MapError error = compare([](double x, double y) {
    const Uv uv = lattice(x, y);
    return Uv{uv.v, uv.u};
  });
  EXPECT_TRUE(error.equivalence.swapped);
  EXPECT_LT(error.max_px, 1e-3);
}

TEST(MapError, ATransposedMapIsAnotherLattice) {
  const MapError error = compare([](double x, double y) { return lattice(y, x); });
  EXPECT_GT(error.equivalence.gradient_mismatch, 0.3);
  EXPECT_GT(error.rms_px, 1.0);
}

TEST(MapError, OnePercentOfScaleIsALinearField) {
  const MapError error = compare([](double x, double y) { return lattice(1.01 * x, y); });
  EXPECT_NEAR(error.equivalence.gradient_mismatch, 0.01 / std::sqrt(2.0), 1e-3);
  EXPECT_NEAR(error.max_px, 0.01 * (kWidth - 1), 2e-3);
  ASSERT_EQ(error.field.size(), 144U);
  for (const FieldCell& cell : error.field) {
    EXPECT_NEAR(cell.dx_px, 0.01 * cell.x_px, 0.01);
    EXPECT_NEAR(cell.dy_px, 0, 1e-3);
  }
}

TEST(MapError, ALostPeriodIsCountedNotMeasured) {
  const MapError error = compare([](double x, double y) {
    const Uv uv = lattice(x, y);
    return Uv{uv.u + (x < 30 ? 1 : 0), uv.v};
  });
  EXPECT_EQ(error.n_slipped, 30 * kHeight);
  EXPECT_LT(error.max_px, 1e-3);
}

TEST(MapError, LeavesOutWhatIsNotFinite) {
  const MapError error = compare([](double x, double y) {
    return x == 10 ? Uv{NAN, 0} : lattice(x, y);
  });
  EXPECT_EQ(error.n_not_finite, kHeight);
  EXPECT_EQ(error.n, (kWidth - 1) * kHeight);
  EXPECT_LT(error.max_px, 1e-3);
  EXPECT_EQ(compare([](double, double) { return Uv{NAN, NAN}; }).n, 0);
  // A map without direction has no pixels.
  EXPECT_EQ(compare(lattice, [](double, double) { return Uv{1, 1}; }).n, 0);
}

TEST(MapError, TheBorderIsLeftOut) {
  const auto b = [](double x, double y) {
    const Uv uv = lattice(x, y);
    return Uv{x < 5 ? uv.u + 0.3 : uv.u, uv.v};
  };
  EXPECT_GT(compare(b).max_px, 1);
  EXPECT_LT(compare_maps(kWidth, kHeight, 5, rows(lattice), rows(b)).max_px, 1e-3);
  EXPECT_EQ(compare_maps(kWidth, kHeight, 65, rows(lattice), rows(b)).n, 0);
}

TEST(MapError, OfOnePixelIsNothing) {
  const MapRows one = [](int, int, std::span<float> out) { out[0] = out[1] = 1; };
  EXPECT_EQ(compare_maps(1, 1, 0, one, one).n, 0);
}

}  // namespace
}  // namespace reseau::compare
