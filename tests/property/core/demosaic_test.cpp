// Every demosaic on films of two kinds of screen: what costs more is truer.
#include "core/reconstruct/demosaic.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"
#include "tests/support/picture.h"

namespace reseau {
namespace {

constexpr int kPictureSide = 400, kPictureBorder = 16;

class Demosaics : public testing::TestWithParam<std::string> {
 protected:
  Demosaics()
      : spec_(sim::parse_sim_spec(
            fmt::format("ls5000?width_px={0}&height_px={0}&scene=natural&noise=0.002&{1}",
                        kPictureSide, GetParam()))),
        scan_(sim::simulate_frame(spec_)),
        source_(scan_.format, scan_.samples),
        registration_(register_screen(source_, {}, {}, {})) {}

  [[nodiscard]] ReconstructOptions options() const {
    ReconstructOptions options;
    options.white_level = spec_.sensor.clear_level;
    return options;
  }
  [[nodiscard]] std::vector<float> picture(const ReconstructOptions& options) const {
    test::MemorySink sink;
    (void)reconstruct(source_, registration_, options, sink, {}, {});
    return sink.rgb;
  }
  // rms of the difference from the scene, of the whole but a border.
  [[nodiscard]] double error(const std::vector<float>& rgb) const {
    double squares = 0;
    int n = 0;
    for (int y = kPictureBorder; y < kPictureSide - kPictureBorder; ++y) {
      for (int x = kPictureBorder; x < kPictureSide - kPictureBorder; ++x) {
        const auto truth = scan_.truth.process_rgb(x, y);
        for (std::size_t c = 0; c < 3; ++c, ++n) {
          const auto at = static_cast<std::size_t>(y * kPictureSide + x) * 3 + c;
          squares += std::pow(static_cast<double>(rgb[at]) - static_cast<double>(truth[c]), 2);
        }
      }
    }
    return std::sqrt(squares / n);
  }

  sim::SimSpec spec_;
  sim::SimulatedScan scan_;
  MemoryLineSource source_;
  Registration registration_;
};

TEST_P(Demosaics, AreTheTruerTheMoreTheyUse) {
  ASSERT_TRUE(registration_.found) << registration_.reason;
  std::map<Demosaic, double> errors;
  std::map<Demosaic, std::vector<float>> pictures;
  for (const Demosaic demosaic : kDemosaics) {
    ReconstructOptions chosen = options();
    chosen.demosaic = demosaic;
    pictures[demosaic] = picture(chosen);
    errors[demosaic] = error(pictures[demosaic]);
    fmt::print("{}: {:.2f} dB\n", demosaic_name(demosaic), -20 * std::log10(errors[demosaic]));
  }
  EXPECT_LT(errors[Demosaic::kBilinear], 0.8 * errors[Demosaic::kNearest]);
  EXPECT_LT(errors[Demosaic::kBicubic], errors[Demosaic::kBilinear]);
  EXPECT_LT(errors[Demosaic::kRatio], 0.93 * errors[Demosaic::kBicubic]);
  EXPECT_LT(errors[Demosaic::kJoint], 0.9 * errors[Demosaic::kRatio]);
  for (const auto& [quality, demosaic] : {std::pair{Quality::kDraft, Demosaic::kBilinear},
                                          std::pair{Quality::kStandard, Demosaic::kBicubic},
                                          std::pair{Quality::kBest, Demosaic::kJoint}}) {
    ReconstructOptions chosen = options();
    chosen.quality = quality;
    EXPECT_EQ(picture(chosen), pictures[demosaic]) << demosaic_name(demosaic);
  }
}

TEST_P(Demosaics, GoWithTheAxesOfTheScreenAndAnyThreads) {
  ASSERT_TRUE(registration_.found) << registration_.reason;
  std::map<Demosaic, std::vector<float>> pictures;
  for (const Demosaic demosaic : kDemosaics) {
    ReconstructOptions chosen = options();
    chosen.demosaic = demosaic;
    chosen.frame.geometry = Geometry::kScreen;
    chosen.n_threads = 1;
    pictures[demosaic] = picture(chosen);
    chosen.n_threads = 3;
    EXPECT_EQ(picture(chosen), pictures[demosaic]) << demosaic_name(demosaic);
    for (const float value : pictures[demosaic]) ASSERT_TRUE(std::isfinite(value));
  }
  EXPECT_NE(pictures[Demosaic::kNearest], pictures[Demosaic::kBilinear]);
  EXPECT_NE(pictures[Demosaic::kRatio], pictures[Demosaic::kBicubic]);
}

INSTANTIATE_TEST_SUITE_P(Screens, Demosaics,
                         testing::Values("blur_px=0.7&ir_blur_px=0.7", "screen=finlay&angle=20"));

}  // namespace
}  // namespace reseau
