// `simulate`: screens, pictures, truth files, and what it refuses.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/exr_file.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

class SimulateE2e : public ::testing::Test {
 protected:
  ProcessResult simulate(const std::string& name, std::vector<std::string> more,
                         const ProcessOptions& options = {}) const {
    std::vector<std::string> arguments{"simulate",
                                       "--width",
                                       "90",
                                       "--height",
                                       "70",
                                       "-o",
                                       dir / (name + ".tif"),
                                       "--truth",
                                       dir / (name + ".exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return reseau(arguments, options);
  }
  [[nodiscard]] nlohmann::json parameters(const std::string& name) const {
    return nlohmann::json::parse(file_bytes(dir / (name + ".json")));
  }
  TempDir dir;
};

TEST_F(SimulateE2e, EveryScreenHasItsName) {
  for (const auto& [word, screen] : {std::pair{"paget", "paget"},
                                     {"joly", "joly"},
                                     {"dufaycolor-gawain", "dufaycolor-gawain"},
                                     {"spicer_dufay_blue", "spicer-dufay-blue"}}) {
    ASSERT_EQ(simulate(word, {"--film", word}).exit_code, 0) << word;
    EXPECT_EQ(parameters(word)["screen"]["name"], screen);
    EXPECT_EQ(parameters(word)["film"]["screen"], screen);
  }
  ASSERT_EQ(simulate("thames", {"--screen", "thames"}).exit_code, 0);
  EXPECT_EQ(parameters("thames")["screen"]["name"], "thames");
}

TEST_F(SimulateE2e, TheUnitOfADeviceNameIsTheOneWhoseScanItIs) {
  ASSERT_EQ(simulate("ls40", {"sim:ls40?angle=5"}).exit_code, 0);
  EXPECT_NEAR(parameters("ls40")["film"]["pixel_um"], 25400.0 / 2900, 1e-9);
  ASSERT_EQ(simulate("ls50", {"sim:ls40?angle=5", "--model", "ls50"}).exit_code, 0);
  EXPECT_NEAR(parameters("ls50")["film"]["pixel_um"], 6.35, 1e-9);
  const ProcessResult unknown = simulate("ls41", {"sim:ls41?angle=5"});
  EXPECT_EQ(unknown.exit_code, 64);
  EXPECT_THAT(unknown.err, HasSubstr("no simulated model named \"ls41\""));
  EXPECT_FALSE(std::filesystem::exists(dir / "ls41.tif"));
}

TEST_F(SimulateE2e, TheTruthHoldsWhatTheFilmHas) {
  ASSERT_EQ(simulate("plain", {}).exit_code, 0);
  const auto plain = read_exr_header(dir / "plain.exr").channels;
  EXPECT_THAT(plain, Contains("IR"));
  EXPECT_THAT(plain, Not(Contains("harm")));
  EXPECT_THAT(plain, Not(Contains("scene.R")));
  const auto json = parameters("plain");
  EXPECT_GE(json["integration"]["cells_per_px"], 4);
  EXPECT_LT(json["integration"]["estimated_rms_error"], 1e-4);
  ASSERT_EQ(simulate("rich", {"--set", "dust=900", "--set", "hd_gamma=1.5"}).exit_code, 0);
  const auto rich = read_exr_header(dir / "rich.exr").channels;
  EXPECT_THAT(rich, Contains("harm"));
  EXPECT_THAT(rich, Contains("scene.G"));
  // The light of a scene is that of the same film without a curve.
  const FloatImage light = read_exr(dir / "rich.exr", {"scene.R", "scene.G", "scene.B"});
  const FloatImage straight = read_exr(dir / "plain.exr", {"R", "G", "B"});
  ASSERT_EQ(light.samples.size(), straight.samples.size());
  double inside = 0;
  for (int y = 20; y < 50; ++y) {
    for (int i = 3 * 20; i < 3 * 70; ++i) {
      const auto at = static_cast<std::size_t>(y * 3 * 90 + i);
      inside = std::max<double>(inside, std::abs(light.samples[at] - straight.samples[at]));
    }
  }
  EXPECT_LT(inside, 1e-6);
}

TEST_F(SimulateE2e, AnImageFileIsAScene) {
  std::ofstream picture(dir / "sky.ppm", std::ios::binary);
  picture << "P6\n2 1\n255\n" << std::string("\x20\x60\xc0\x20\x60\xc0", 6);
  picture.close();
  const ProcessResult result = simulate("sky", {"--scene", dir / "sky.ppm"});
  if (result.exit_code != 0 && result.err.find("OpenImageIO") != std::string::npos) {
    GTEST_SKIP() << result.err;
  }
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(parameters("sky")["film"]["scene"], "image");
  const FloatImage truth = read_exr(dir / "sky.exr", {"R", "G", "B"});
  const float* const middle =
      truth.samples.data() + static_cast<std::ptrdiff_t>(3) * (35 * 90 + 45);
  EXPECT_LT(middle[0], middle[1]);
  EXPECT_LT(middle[1], middle[2]);
  // A path of a picture that is not there is bad input, with its name.
  const ProcessResult missing = simulate("no", {"--image", dir / "no.jpg"});
  EXPECT_EQ(missing.exit_code, 65);
  EXPECT_THAT(missing.err, HasSubstr("no.jpg"));
  EXPECT_FALSE(std::filesystem::exists(dir / "no.tif"));
}

TEST_F(SimulateE2e, AFullDiskIsSeventyFourAndLeavesNothing) {
  ProcessOptions small;
  small.file_size_limit_blocks = 40;  // 20 kB; the scan takes 50
  const ProcessResult result = simulate("full", {}, small);
  EXPECT_EQ(result.exit_code, 74) << result.err;
  EXPECT_THAT(result.err, HasSubstr("reseau: "));
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST_F(SimulateE2e, StoppedItLeavesNothing) {
  Process process(command(
      {"simulate", "--width", "2000", "--height", "4000", "-o", dir / "long.tif", "--json"}));
  ASSERT_TRUE(process.wait_for_line(
      [](const std::string& line) { return line.find("\"render\"") != std::string::npos; },
      std::chrono::seconds(60)));
  process.send(SIGINT);
  const ProcessResult result = process.wait(std::chrono::seconds(120));
  ASSERT_FALSE(result.timed_out);
  if (result.exit_code == 0) GTEST_SKIP() << "finished before it could be stopped";
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST_F(SimulateE2e, ExistingFilesAreLeftAlone) {
  write_bytes(dir / "mine.exr", "mine");
  const ProcessResult result = simulate("mine", {});
  EXPECT_EQ(result.exit_code, 74);
  EXPECT_EQ(file_bytes(dir / "mine.exr"), "mine");
  EXPECT_FALSE(std::filesystem::exists(dir / "mine.tif"));
}

}  // namespace
}  // namespace reseau::testing
