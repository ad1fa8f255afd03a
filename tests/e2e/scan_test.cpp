#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/exr_file.h"
#include "capture/image/scan_reader.h"
#include "capture/store/sha256.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

TEST(ScanE2e, DoesEverythingWithoutFurtherOptions) {
  const TempDir dir;
  const ProcessResult result = reseau(small_scan(kDevice, dir.path()));
  ASSERT_EQ(result.exit_code, 0) << result.err;

  const auto master = only_file(dir.path(), "_01.tif");
  const auto exr = only_file(dir.path(), "_01.exr");
  const auto png = only_file(dir.path(), "_01.png");
  only_file(dir.path(), "_01_view.tif");
  const auto receipt_path = only_file(dir.path(), "_01.json");
  EXPECT_EQ(names_in(dir.path()).size(), 5U) << "something was left behind";
  EXPECT_EQ(result.out, exr.string() + "\n");

  const Scan scan = read_scan(master);
  const LineFormat& format = scan.source->format();
  // 3 mm and 2 mm at 4000 dpi; the unit may round to its own steps.
  EXPECT_NEAR(format.width_px, 472, 8);
  EXPECT_NEAR(format.n_lines, 315, 8);
  EXPECT_EQ(format.n_channels(), 4);
  EXPECT_EQ(file_bytes(png).substr(1, 3), "PNG");
  const ExrReader picture(exr);
  EXPECT_EQ(picture.width_px(), format.width_px);
  EXPECT_EQ(picture.height_px(), format.n_lines);

  const auto receipt = nlohmann::json::parse(file_bytes(receipt_path));
  EXPECT_EQ(receipt["schema"], "reseau-receipt/1");
  EXPECT_EQ(receipt["scan"]["end"], "complete");
  EXPECT_EQ(receipt["scan"]["lines"], format.n_lines);
  EXPECT_EQ(receipt["registration"]["screen"], "dufaycolor");
  EXPECT_EQ(receipt["files"][0]["role"], "master");
  EXPECT_EQ(receipt["files"][0]["sha256"], sha256_of_file(master));
  EXPECT_EQ(receipt["files"][0]["bytes"], std::filesystem::file_size(master));
  EXPECT_TRUE(receipt["device"]["exposure_us"]["infrared"].is_number());
}

TEST(ScanE2e, SaysBeforeDoingAndDoesNothingWithDontScan) {
  const TempDir dir;
  auto arguments = small_scan(kDevice, dir / "new");
  arguments.push_back("-n");
  const ProcessResult result = reseau(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("1 frame · 4000 dpi · RGB+IR · "), HasSubstr(" MB")));
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST(ScanE2e, RunningTwiceNeverOverwrites) {
  const TempDir dir;
  ASSERT_EQ(reseau(small_scan(kDevice, dir.path())).exit_code, 0);
  const auto first = only_file(dir.path(), "_01.tif");
  const std::string bytes = file_bytes(first);
  ASSERT_EQ(reseau(small_scan(kDevice, dir.path())).exit_code, 0);
  EXPECT_EQ(file_bytes(first), bytes);
  only_file(dir.path(), "_02.tif");
  only_file(dir.path(), "_02.exr");
  EXPECT_EQ(names_in(dir.path()).size(), 10U);
}

TEST(ScanE2e, AnExactNameThatIsTakenIsRefused) {
  const TempDir dir;
  ASSERT_EQ(reseau(small_scan(kDevice, dir / "box3_07.tif")).exit_code, 0);
  const auto before = names_in(dir.path());
  EXPECT_THAT(before, Contains("box3_07.exr"));
  const ProcessResult again = reseau(small_scan(kDevice, dir / "box3_07.tif"));
  EXPECT_EQ(again.exit_code, 74);
  EXPECT_THAT(again.err, HasSubstr("box3_07"));
  EXPECT_EQ(names_in(dir.path()), before);
}

TEST(ScanE2e, AFilmWithoutReseauGivesItsMasterAndANote) {
  const TempDir dir;
  const ProcessResult result = reseau(small_scan("sim:ls5000?film=none", dir.path()));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const auto master = only_file(dir.path(), ".tif");
  EXPECT_EQ(result.out, master.string() + "\n");
  EXPECT_THAT(result.err, HasSubstr("The master is kept"));
  const auto receipt = nlohmann::json::parse(file_bytes(only_file(dir.path(), ".json")));
  EXPECT_FALSE(receipt["registration"]["found"].get<bool>());
  EXPECT_TRUE(receipt["reconstruction"].is_null());
  EXPECT_EQ(names_in(dir.path()).size(), 2U);
}

TEST(ScanE2e, NoFilmIsSevenAndLeavesNothing) {
  const TempDir dir;
  const ProcessResult result = reseau(small_scan("sim:ls5000?film=empty", dir.path()));
  EXPECT_EQ(result.exit_code, 7) << result.err;
  EXPECT_TRUE(names_in(dir.path()).empty());
}

TEST(ScanE2e, EventsTellTheWholeStory) {
  const TempDir dir;
  auto arguments = small_scan(kDevice, dir.path());
  arguments.push_back("--json");
  const ProcessResult result = reseau(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = json_lines(result.out);
  ASSERT_GT(lines.size(), 5U);
  EXPECT_EQ(lines[0]["schema"], "reseau-events/1");
  for (std::size_t i = 1; i < lines.size(); ++i) {
    EXPECT_TRUE(lines[i].contains("t") && lines[i].contains("event")) << lines[i];
  }
  EXPECT_EQ(events_of(lines, "plan").size(), 1U);
  std::vector<std::string> phases;
  for (const auto& event : events_of(lines, "phase")) phases.push_back(event["phase"]);
  for (const char* phase : {"focus", "meter", "scan", "register", "reconstruct"}) {
    EXPECT_THAT(phases, Contains(phase));
  }
  const auto progress = events_of(lines, "progress");
  const auto last_scan = std::find_if(progress.rbegin(), progress.rend(),
                                      [](const auto& e) { return e["phase"] == "scan"; });
  ASSERT_NE(last_scan, progress.rend());
  EXPECT_TRUE((*last_scan)["rows_done"].is_number());
  std::vector<std::string> roles;
  for (const auto& event : events_of(lines, "file")) roles.push_back(event["role"]);
  EXPECT_THAT(roles, ::testing::UnorderedElementsAre("master", "reconstruction", "view", "view16",
                                                     "receipt"));
  EXPECT_EQ(lines.back()["event"], "end");
  EXPECT_EQ(lines.back()["exit"], 0);
}

TEST(ScanE2e, AReplayGivesTheSameMasterByteForByte) {
  const TempDir dir;
  auto arguments = small_scan(kDevice, dir / "one/a.tif");
  arguments.insert(arguments.end(),
                   {"--record", dir / "session.pcapng", "--resolution", "2000dpi"});
  ASSERT_EQ(reseau(arguments).exit_code, 0);
  const ProcessResult replay = reseau({"replay", dir / "session.pcapng", "-o", dir / "two/a.tif"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_TRUE(file_bytes(dir / "one/a.tif") == file_bytes(dir / "two/a.tif"));
  EXPECT_TRUE(file_bytes(dir / "one/a.exr") == file_bytes(dir / "two/a.exr"));
  const ProcessResult as_device =
      reseau({"scan", "-d", "replay:" + (dir / "session.pcapng").string(), "-o",
              dir / "three/a.tif", "--no-reconstruct"});
  ASSERT_EQ(as_device.exit_code, 0) << as_device.err;
  EXPECT_TRUE(file_bytes(dir / "one/a.tif") == file_bytes(dir / "three/a.tif"));
}

TEST(ScanE2e, ARecordingIsNeverOverwritten) {
  const TempDir dir;
  auto arguments = small_scan(kDevice, dir.path());
  arguments.insert(arguments.end(), {"--record", dir / "s.pcapng", "--no-reconstruct"});
  ASSERT_EQ(reseau(arguments).exit_code, 0);
  const std::string bytes = file_bytes(dir / "s.pcapng");
  EXPECT_EQ(reseau(arguments).exit_code, 74);
  EXPECT_EQ(file_bytes(dir / "s.pcapng"), bytes);
}

TEST(ScanE2e, TheDeviceMayComeFromTheEnvironment) {
  const TempDir dir;
  const std::vector<std::string> arguments{"scan", "-x", "1mm", "-y",
                                           "1mm",  "-n", "-o",  dir.path()};
  ProcessOptions ours;
  ours.environment = {"RESEAU_DEVICE=sim:ls5000"};
  EXPECT_EQ(reseau(arguments, ours).exit_code, 0);
  ProcessOptions sane;
  sane.environment = {"SANE_DEFAULT_DEVICE=sim:ls5000"};
  EXPECT_EQ(reseau(arguments, sane).exit_code, 0);
}

TEST(ScanE2e, InfraredAndExposureAndFocusAreObeyed) {
  const TempDir dir;
  auto arguments = small_scan(kDevice, dir / "a.tif");
  arguments.insert(arguments.end(),
                   {"--infrared=no", "--focus", "210", "--red-exposure", "900us",
                    "--green-exposure", "800", "--blue-exposure", "1.1ms", "--no-reconstruct"});
  const ProcessResult result = reseau(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_scan(dir / "a.tif").source->format().n_channels(), 3);
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "a.json"));
  EXPECT_EQ(receipt["device"]["focus_position"], 210);
  EXPECT_NEAR(receipt["device"]["exposure_us"]["red"].get<double>(), 900, 1);
  EXPECT_NEAR(receipt["device"]["exposure_us"]["green"].get<double>(), 800, 1);
  EXPECT_NEAR(receipt["device"]["exposure_us"]["blue"].get<double>(), 1100, 1);
}

}  // namespace
}  // namespace reseau::testing
