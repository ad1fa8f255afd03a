// Registration over what it must bear: periods, angles, mirrored film, deformation, noise, black
// areas, no infrared; against scans painted by tests/support.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/reconstruct/reconstruct.h"
#include "tests/support/picture.h"
#include "tests/support/synthetic_scan.h"

namespace reseau {
namespace {

std::array<double, 3> patches(double x, double y) {
  const auto i = static_cast<unsigned>(std::floor(x / 80) + 1000),
             j = static_cast<unsigned>(std::floor(y / 80) + 1000);
  const unsigned h = (i * 73856093U) ^ (j * 19349663U);
  const auto value = [&](unsigned shift) { return 0.05 + 0.9 * ((h >> shift) & 127U) / 127.0; };
  return {value(0), value(7), value(14)};
}

test::SyntheticScan base() {
  test::SyntheticScan scan;
  scan.width_px = 480;
  scan.height_px = 560;
  scan.scene = patches;
  return scan;
}

double error_px(const test::SyntheticScan& scan, const char* what) {
  const MemoryLineSource source = scan.render();
  const Registration found = register_screen(source, {}, {}, {});
  EXPECT_TRUE(found.found) << what << ": " << found.reason;
  if (!found.found) return 1e9;
  const double error = test::map_error_px(
      found.map, [&](double x, double y) { return scan.screen_from_scan(x, y); }, scan.width_px,
      scan.height_px);
  fmt::print("{}: {:.4f} px rms, residual {:.4f}\n", what, error, found.residual_px);
  return error;
}

TEST(Registration, PeriodsFromThreeToSixteenPixelsAtAnyAngle) {
  const std::array<double, 7> angles{0, 22.8, 45, 67, 90, -13, -78};
  std::size_t turn = 0;
  for (const double period : {3.0, 3.7, 5.2, 7.7, 10.5, 13.0, 16.0}) {
    test::SyntheticScan scan = base();
    scan.period_u_px = period * 1.012;
    scan.period_v_px = period;
    scan.angle_deg = angles[turn++ % angles.size()];
    scan.mirrored = turn % 2 == 0;
    EXPECT_LT(error_px(scan, fmt::format("period {} angle {}", period, scan.angle_deg).c_str()),
              0.05);
  }
}

TEST(Registration, SmoothDeformationOfSeveralPixels) {
  test::SyntheticScan scan = base();
  scan.displacement_px = [](double x, double y) {
    return std::array<double, 2>{4 * std::sin(y * std::numbers::pi / 600),
                                 3 * std::sin(x * std::numbers::pi / 500 + 1)};
  };
  EXPECT_LT(error_px(scan, "bend"), 0.06);
  scan.period_u_px = 3.2;
  scan.period_v_px = 3.1;
  EXPECT_LT(error_px(scan, "bend, period 3.1"), 0.06);
}

TEST(Registration, NoiseFadingBlackAndMissingInfrared) {
  test::SyntheticScan scan = base();
  scan.noise = 0.03;
  EXPECT_LT(error_px(scan, "noise 3 %"), 0.05);
  scan = base();
  scan.fade = 0.8;
  scan.noise = 0.006;
  EXPECT_LT(error_px(scan, "faded"), 0.05);
  scan = base();
  scan.scene = [](double x, double y) {
    return x < 190 ? std::array<double, 3>{0.002, 0.002, 0.002} : patches(x, y);
  };
  EXPECT_LT(error_px(scan, "40 % black"), 0.15);
  scan = base();
  scan.infrared = false;
  EXPECT_LT(error_px(scan, "no infrared"), 0.03);
}

TEST(Registration, SaysNoWhereThereIsNoScreen) {
  test::SyntheticScan scan = base();
  scan.fade = 1;
  const Registration found = register_screen(scan.render(), {}, {}, {});
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.screen, "none");
  EXPECT_FALSE(found.reason.empty());
}

TEST(Registration, TinyPicturesAndMissingChannelsAreAnswersNotCrashes) {
  for (const int size : {1, 3, 17, 63}) {
    test::SyntheticScan scan = base();
    scan.width_px = size;
    scan.height_px = size;
    const Registration found = register_screen(scan.render(), {}, {}, {});
    EXPECT_FALSE(found.found);
    EXPECT_FALSE(found.reason.empty());
  }
  LineFormat grey;
  grey.width_px = grey.n_lines = 100;
  grey.channels = {Channel::kInfrared};
  EXPECT_THROW(
      (void)register_screen(MemoryLineSource(grey, std::vector<std::uint16_t>(10000)), {}, {}, {}),
      InputError);
}

// A source whose lines become readable a few at a time, as a scanner gives them.
class DripSource final : public LineSource {
 public:
  DripSource(const LineSource& all, int step) : all_(all), step_(step) {}
  [[nodiscard]] const LineFormat& format() const override { return all_.format(); }
  [[nodiscard]] int committed() const override { return committed_; }
  int wait_committed(int n_lines, const std::stop_token& /*stop*/) const override {
    while (committed_ < std::min(n_lines, all_.format().n_lines)) {
      committed_ = std::min(committed_ + step_, all_.format().n_lines);
    }
    return committed_;
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override {
    ASSERT_LE(first + n, committed_) << "lines were read before they were committed";
    all_.read(first, n, out);
  }

 private:
  const LineSource& all_;
  int step_;
  mutable int committed_ = 0;
};

class ReconstructionBytes : public testing::TestWithParam<Quality> {};

TEST_P(ReconstructionBytes, AreTheSameForAnyThreadsAndAnyChunks) {
  test::SyntheticScan scan = base();
  scan.height_px = 700;
  scan.displacement_px = [](double x, double y) {
    return std::array<double, 2>{2 * std::sin(y / 250), 1.5 * std::sin(x / 200)};
  };
  const MemoryLineSource whole = scan.render();
  std::vector<float> reference;
  struct Case {
    int threads, step;
  };
  for (const Case& c : {Case{1, 700}, {2, 700}, {7, 1}, {3, 37}}) {
    const DripSource source(whole, c.step);
    RegisterOptions register_options;
    register_options.n_threads = c.threads;
    const Registration registration = register_screen(source, register_options, {}, {});
    ASSERT_TRUE(registration.found);
    ReconstructOptions options;
    options.n_threads = c.threads;
    options.quality = GetParam();
    test::MemorySink sink;
    (void)reconstruct(source, registration, options, sink, {}, {});
    if (reference.empty()) {
      reference = sink.rgb;
      continue;
    }
    EXPECT_TRUE(reference == sink.rgb) << c.threads << " threads, " << c.step << " lines at a time";
  }
}

INSTANTIATE_TEST_SUITE_P(Qualities, ReconstructionBytes,
                         testing::Values(Quality::kStandard, Quality::kBest));

// The factors on red, green and blue that bring `found` nearest to `truths`.
void balance(std::vector<std::array<double, 3>>& found,
             const std::vector<std::array<double, 3>>& truths) {
  for (std::size_t k = 0; k < 3; ++k) {
    double product = 0, square = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      product += found[i][k] * truths[i][k];
      square += found[i][k] * found[i][k];
    }
    for (auto& rgb : found) rgb[k] *= product / square;
  }
}

TEST(Reconstruction, PatchesComeBackAtSeveralBlursAndWithoutInfrared) {
  struct Case {
    double blur, ir_blur, bound;
    bool infrared;
  };
  for (const Case& c : {Case{0.6, 0.6, 0.3, true},
                        {0.6, 0.9, 0.3, true},
                        {1.0, 1.0, 0.4, true},
                        {1.5, 1.5, 1.0, true},
                        {0.6, 0.6, 0.5, false}}) {
    test::SyntheticScan scan = base();
    scan.blur_px = c.blur;
    scan.ir_blur_px = c.ir_blur;
    scan.infrared = c.infrared;
    const MemoryLineSource source = scan.render();
    const Registration registration = register_screen(source, {}, {}, {});
    ASSERT_TRUE(registration.found);
    ReconstructOptions options;
    options.white_level = scan.exposure;
    test::MemorySink sink;
    const ReconstructionReport report = reconstruct(source, registration, options, sink, {}, {});
    std::vector<std::array<double, 3>> found, truths;
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 6; ++i) {
        found.push_back(sink.mean(80 * i + 18, 80 * j + 18, 80 * i + 61, 80 * j + 61));
        truths.push_back(patches(80 * i + 40, 80 * j + 40));
      }
    }
    // Without infrared nothing in a picture of patches says how bright clear film is: after white
    // balance.
    if (!c.infrared) balance(found, truths);
    const auto n = static_cast<int>(found.size());
    double sum = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      sum += test::process_delta_e(found[i], truths[i]);
    const double truth = std::sqrt(c.blur * c.blur + 1.0 / 12);
    fmt::print("blur {} infrared {}: dE00 mean {:.3f}, sigma {:.3f} {:.3f} {:.3f} {:.3f}\n", c.blur,
               c.infrared ? c.ir_blur : 0, sum / n, report.sharpness.sigma_px[0],
               report.sharpness.sigma_px[1], report.sharpness.sigma_px[2],
               report.sharpness.sigma_px[3]);
    EXPECT_LT(sum / n, c.bound);
    EXPECT_NEAR(report.sharpness.sigma_px[1], truth, 0.02);
    if (c.infrared) {
      EXPECT_NEAR(report.sharpness.sigma_px[3], std::sqrt(c.ir_blur * c.ir_blur + 1.0 / 12), 0.04);
    }
  }
}

}  // namespace
}  // namespace reseau
