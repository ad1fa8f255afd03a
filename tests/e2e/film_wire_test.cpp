// Films in simulated units, scanned by the real driver, against the same films written straight to
// a file: sample by sample the same light, whatever the unit.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"

namespace reseau::testing {
namespace {

constexpr int kHeight = 110;

struct UnitCase {
  const char *name, *model, *sensor_lines, *width_mm, *height_mm;
  int width_px;   // of the film
  int begins_px;  // where the unit's frame begins on its sensor
  int step;       // of a sample, 16 bits: what the converter has left out
};

void PrintTo(const UnitCase& c, std::ostream* to) { *to << c.name; }

struct Fit {
  double factor = 0, largest = 0;
  long long n = 0;
};

// Both have the level of their own exposure: the best factor, and what it leaves.
Fit fit(const Pixels& wire, const Pixels& file, int begins_px, int channel) {
  double xy = 0, xx = 0;
  Fit result;
  const auto each = [&](const auto& use) {
    for (int y = 0; y < wire.height_px; ++y) {
      for (int x = 0; x < wire.width_px; ++x) {
        const double a =
            wire.samples[static_cast<std::size_t>((y * wire.width_px + x) * 4 + channel)];
        const double b = file.samples[static_cast<std::size_t>(
            (y * file.width_px + x + begins_px) * 4 + channel)];
        if (a < 65000 && b < 65000) use(b, a);
      }
    }
  };
  each([&](double b, double a) {
    xy += a * b;
    xx += b * b;
    ++result.n;
  });
  result.factor = xy / std::max(xx, 1.0);
  each([&](double b, double a) {
    result.largest = std::max(result.largest, std::abs(a - result.factor * b));
  });
  return result;
}

class FilmWireE2e : public ::testing::TestWithParam<UnitCase> {
 protected:
  // The largest difference between wire and file, in steps of the unit's samples.
  static double largest_difference(const std::string& film) {
    const UnitCase& unit = GetParam();
    const TempDir dir;
    const std::string device =
        std::string("sim:") + unit.model + "?width_px=" + std::to_string(unit.width_px) +
        "&height_px=" + std::to_string(kHeight) + "&noise=0&read_noise=0&seed=5&" + film;
    EXPECT_EQ(reseau({"scan", "-d", device, "-o", dir / "wire.tif", "--no-reconstruct", "-x",
                      unit.width_mm, "-y", unit.height_mm, "--sensor-lines", unit.sensor_lines})
                  .exit_code,
              0);
    EXPECT_EQ(reseau({"simulate", device, "-o", dir / "file.tif"}).exit_code, 0);
    const Pixels wire = read_pixels(dir / "wire.tif"), file = read_pixels(dir / "file.tif");
    EXPECT_GT(wire.width_px, 70);
    EXPECT_GT(wire.height_px, 50);
    EXPECT_LE(wire.width_px + unit.begins_px, file.width_px);
    EXPECT_LE(wire.height_px, file.height_px);
    if (HasFailure()) return INFINITY;
    double largest = 0;
    for (int channel = 0; channel < 4; ++channel) {
      const Fit found = fit(wire, file, unit.begins_px, channel);
      EXPECT_GT(found.n, wire.width_px * wire.height_px / 2);
      EXPECT_GT(found.factor, 0.5);
      largest = std::max(largest, found.largest / unit.step);
    }
    return largest;
  }
};

// Roundings of both sides, and of places where windows begin elsewhere (1e-5); the responses of
// several lines of sensors are undone to a few steps.
constexpr double kRoundings = 2.3, kResponses = 8;

TEST_P(FilmWireE2e, EveryScreenIsWhatItsFileIs) {
  const bool several = std::string(GetParam().sensor_lines) == "all";
  for (const std::string screen : {"dufay", "paget", "thames", "joly", "improved_dioptichrome"}) {
    EXPECT_LT(largest_difference("film=" + screen + "&scene=natural&angle=31"),
              several ? kResponses : kRoundings)
        << screen;
  }
}

TEST_P(FilmWireE2e, AFilmThatSufferedIsWhatItsFileIs) {
  const std::string film =
      "film=dufay&grain=0.08&dust=300&scratches=20&warp_px=2&warp_length_px=120&overlap_um=1.5"
      "&position_noise_um=1&fade=0.3&hd_gamma=1.2&mirrored=1&spread_um=4&perspective_x=0.01";
  const bool several = std::string(GetParam().sensor_lines) == "all";
  EXPECT_LT(largest_difference(film), several ? kResponses : kRoundings);
}

// Lines exposed together share the stage's error, and those of a file are exposed singly.
class FilmWireLineByLineE2e : public FilmWireE2e {};

TEST_P(FilmWireLineByLineE2e, ALensAndItsStageAreWhatTheirFileIs) {
  EXPECT_LT(largest_difference("optics=coolscan&film=dufay&jitter_px=0.1&red_shift_px=0.2"),
            kRoundings);
}

constexpr UnitCase kLs40{"LS40", "ls40", "auto", "1.0mm", "0.7mm", 160, 0, 16};
constexpr UnitCase kLs50{"LS50", "ls50", "auto", "0.7mm", "0.5mm", 160, 0, 4};
constexpr UnitCase kLs5000{"LS5000OneLine", "ls5000", "one", "0.7mm", "0.5mm", 160, 0, 1};
constexpr UnitCase kLs5000Two{"LS5000TwoLines", "ls5000", "all", "0.7mm", "0.5mm", 160, 0, 1};
constexpr UnitCase kLs9000{"LS9000OneLine", "ls9000", "one", "0.7mm", "0.5mm", 700, 518, 1};
constexpr UnitCase kLs9000Three{"LS9000ThreeLines", "ls9000", "all", "0.7mm", "0.5mm", 700, 518, 1};

std::string name_of(const ::testing::TestParamInfo<UnitCase>& each) { return each.param.name; }

INSTANTIATE_TEST_SUITE_P(Units, FilmWireE2e,
                         ::testing::Values(kLs40, kLs50, kLs5000, kLs5000Two, kLs9000,
                                           kLs9000Three),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Units, FilmWireLineByLineE2e,
                         ::testing::Values(kLs40, kLs50, kLs5000, kLs9000), name_of);

}  // namespace
}  // namespace reseau::testing
