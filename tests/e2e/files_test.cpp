// Verbs on files: reconstruct, register, compare, simulate; good input and every kind of bad one.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "capture/image/exr_file.h"
#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"

namespace reseau::testing {
namespace {

using ::testing::HasSubstr;

// One film for all tests of this file.
class FilesE2e : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempDir;
    ASSERT_EQ(reseau({"simulate", "width_px=420", "height_px=400", "scene=natural", "-o", film(),
                      "--truth", truth()})
                  .exit_code,
              0);
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }
  static std::string film() { return *shared_ / "film.tif"; }
  static std::string truth() { return *shared_ / "truth.exr"; }

  static TempDir* shared_;
  TempDir dir;
};
TempDir* FilesE2e::shared_ = nullptr;

TEST_F(FilesE2e, SimulateIsTheSameForTheSameSeed) {
  for (const char* name : {"a.tif", "b.tif"}) {
    ASSERT_EQ(reseau({"simulate", "width_px=100", "height_px=90", "--seed", "7", "-o", dir / name})
                  .exit_code,
              0);
  }
  ASSERT_EQ(reseau({"simulate", "width_px=100", "height_px=90", "--seed", "8", "-o", dir / "c.tif"})
                .exit_code,
            0);
  EXPECT_TRUE(file_bytes(dir / "a.tif") == file_bytes(dir / "b.tif"));
  EXPECT_FALSE(file_bytes(dir / "a.tif") == file_bytes(dir / "c.tif"));
}

TEST_F(FilesE2e, ReconstructWritesPictureAndReceiptAndIsNearTheTruth) {
  const ProcessResult result =
      reseau({"reconstruct", film(), "-o", dir / "out", "--geometry", "scan", "--space", "process",
              "--balance", "neutral", "--quality", "standard", "--threads", "2", "--white", "0.9"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, (dir / "out/film.exr").string() + "\n");
  EXPECT_EQ(names_in(dir / "out"),
            (std::vector<std::string>{"film.exr", "film.json", "film.png", "film_view.tif"}));
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "out/film.json"));
  EXPECT_EQ(receipt["schema"], "reseau-receipt/1");
  EXPECT_EQ(receipt["settings"]["space"], "process");
  EXPECT_TRUE(receipt["registration"]["found"].get<bool>());
  const ProcessResult compared = reseau({"compare", truth(), dir / "out/film.exr", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const auto figures = nlohmann::json::parse(compared.out);
  EXPECT_EQ(figures["schema"], "reseau-compare/1");
  // The truth is finer than a réseau can record, so this only shows that the colours are right.
  EXPECT_LT(figures["delta_e_2000"]["median"].get<double>(), 6.0);
  EXPECT_GT(figures["delta_e_2000"]["max"].get<double>(), 0.0);
}

TEST_F(FilesE2e, ThreadsDoNotChangeAByte) {
  for (const char* threads : {"1", "2"}) {
    ASSERT_EQ(
        reseau({"reconstruct", film(), "-o", dir / threads, "--threads", threads, "--no-view"})
            .exit_code,
        0);
  }
  EXPECT_TRUE(file_bytes(dir / "1/film.exr") == file_bytes(dir / "2/film.exr"));
  const auto same = nlohmann::json::parse(
      reseau({"compare", dir / "1/film.exr", dir / "2/film.exr", "--json"}).out);
  EXPECT_TRUE(same["identical"].get<bool>());
  EXPECT_EQ(same["delta_e_2000"]["max"], 0.0);
}

TEST_F(FilesE2e, ReconstructRefusesWhatExistsBeforeItWorks) {
  std::filesystem::create_directory(dir / "out");
  for (const char* taken : {"film.exr", "film.json", "film.png"}) {
    write_bytes(dir / "out" / taken, "mine");
    const ProcessResult result = reseau({"reconstruct", film(), "-o", dir / "out"});
    EXPECT_EQ(result.exit_code, 74);
    EXPECT_THAT(result.err, HasSubstr(taken));
    EXPECT_EQ(result.err.find("register"), std::string::npos) << "it worked first";
    EXPECT_EQ(file_bytes(dir / "out" / taken), "mine");
    std::filesystem::remove(dir / "out" / taken);
  }
}

TEST_F(FilesE2e, RegisterGivesTheFiguresAndTheMap) {
  const ProcessResult result = reseau({"register", film(), "--map", dir / "map.exr", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["schema"], "reseau-registration/1");
  EXPECT_EQ(json["screen"], "dufaycolor");
  for (const char* key :
       {"lattice_cy_per_px", "residual_px", "angle_deg", "period_um", "mirrored", "confidence"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["lattice_cy_per_px"].size(), 2U);
  // The pattern repeats and looks the same upside down, so the map may differ from the truth by
  // whole periods and by the sign of both coordinates.
  const FloatImage map = read_exr(dir / "map.exr", {"u", "v"});
  const FloatImage exact = read_exr(truth(), {"u", "v"});
  ASSERT_EQ(map.samples.size(), exact.samples.size());
  double worst = 1;
  for (const double sign : {1.0, -1.0}) {
    double worst_so = 0;
    for (std::size_t i = 0; i < map.samples.size(); ++i) {
      const double d = double{map.samples[i]} - sign * double{exact.samples[i]};
      worst_so = std::max(worst_so, std::abs(d - std::round(d)));
    }
    worst = std::min(worst, worst_so);
  }
  EXPECT_LT(worst, 0.05) << "periods";
}

TEST_F(FilesE2e, RegisterDrawsWhatItFound) {
  const ProcessResult result = reseau(
      {"register", film(), "--overlay", dir / "dots.png", "--plot", dir / "film.svg", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  for (const char* key : {"none_probability", "probability", "runner_up", "left_out_px",
                          "uncertainty_px", "angle_sd_deg", "period_sd_px", "lines_per_mm"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_LT(json["none_probability"].get<double>(), 0.1);
  EXPECT_THAT(file_bytes(dir / "film.svg"), HasSubstr("</svg>"));
  const std::string png = file_bytes(dir / "dots.png");
  EXPECT_EQ(png.substr(1, 3), "PNG");
  // Neither is overwritten.
  EXPECT_EQ(reseau({"register", film(), "--overlay", dir / "dots.png"}).exit_code, 74);
  EXPECT_EQ(file_bytes(dir / "dots.png"), png);
}

TEST_F(FilesE2e, ThreeChannelsAndEightBitsAreScansToo) {
  const Pixels pixels = read_pixels(film());
  write_tiff(dir / "rgb16.tif", first_channels(pixels, 3), 16);
  write_tiff(dir / "rgbi8.tif", pixels, 8);
  write_tiff(dir / "rgb8.tif", first_channels(pixels, 3), 8);
  for (const char* name : {"rgb16.tif", "rgbi8.tif", "rgb8.tif"}) {
    const ProcessResult result = reseau({"register", dir / name});
    EXPECT_EQ(result.exit_code, 0) << name << "\n" << result.err;
  }
}

TEST_F(FilesE2e, BadInputsAreSixtyFiveWithASentenceAndLeaveNothing) {
  const Pixels pixels = read_pixels(film());
  const std::string bytes = file_bytes(film());
  write_bytes(dir / "truncated.tif", bytes.substr(0, bytes.size() / 2));
  write_bytes(dir / "head-only.tif", bytes.substr(0, 100));
  write_bytes(dir / "empty.tif", "");
  write_bytes(dir / "words.tif", "This is no picture.");
  std::filesystem::create_directory(dir / "folder.tif");
  write_tiff(dir / "grey.tif", first_channels(pixels, 1), 16);
  Pixels flat = pixels;
  std::fill(flat.samples.begin(), flat.samples.end(), std::uint16_t{30000});
  write_tiff(dir / "flat.tif", flat, 16);
  write_tiff(dir / "one-pixel.tif", {1, 1, 3, {1, 2, 3}}, 16);
  for (const char* name : {"truncated.tif", "head-only.tif", "empty.tif", "words.tif", "folder.tif",
                           "grey.tif", "flat.tif", "one-pixel.tif", "missing.tif"}) {
    for (const char* verb : {"reconstruct", "register"}) {
      std::vector<std::string> arguments{verb, dir / name};
      if (verb == std::string("reconstruct")) arguments.insert(arguments.end(), {"-o", dir / "o"});
      const ProcessResult result = reseau(arguments);
      EXPECT_EQ(result.exit_code, 65) << verb << " " << name << "\n" << result.err;
      EXPECT_THAT(result.err, HasSubstr(name)) << verb;
      EXPECT_EQ(result.out, "") << name;
    }
    if (std::filesystem::exists(dir / "o")) {
      EXPECT_TRUE(names_in(dir / "o").empty()) << name;
    }
  }
}

TEST_F(FilesE2e, BadInputIsAlsoAnErrorInJson) {
  const ProcessResult result = reseau({"register", dir / "missing.tif", "--json"});
  EXPECT_EQ(result.exit_code, 65);
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["schema"], "reseau-error/1");
  EXPECT_EQ(json["code"], "input");
}

TEST_F(FilesE2e, AnUnreadableFileIsSixtyFive) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
  write_bytes(dir / "secret.tif", file_bytes(film()));
  std::filesystem::permissions(dir / "secret.tif", std::filesystem::perms::none);
  EXPECT_EQ(reseau({"register", dir / "secret.tif"}).exit_code, 65);
}

TEST_F(FilesE2e, AnOutputFolderThatCannotBeIsSeventyFour) {
  write_bytes(dir / "file", "x");
  const ProcessResult result = reseau({"reconstruct", film(), "-o", dir / "file/below"});
  EXPECT_EQ(result.exit_code, 74);
  EXPECT_THAT(result.err, HasSubstr("reseau: "));
  EXPECT_EQ(reseau({"scan", "-d", "sim:ls5000", "-o", dir / "file/below"}).exit_code, 74);
  if (::geteuid() == 0) return;  // root may write everywhere
  std::filesystem::create_directory(dir / "locked");
  std::filesystem::permissions(dir / "locked", std::filesystem::perms::owner_read);
  EXPECT_EQ(reseau({"reconstruct", film(), "-o", dir / "locked"}).exit_code, 74);
}

TEST_F(FilesE2e, AFullDiskIsSeventyFourAndLeavesNoHalfPicture) {
  ProcessOptions small;
  small.file_size_limit_blocks = 400;  // 200 kB; the picture takes more
  const ProcessResult result = reseau({"reconstruct", film(), "-o", dir / "out"}, small);
  EXPECT_EQ(result.exit_code, 74) << result.err;
  EXPECT_THAT(result.err, HasSubstr("reseau: "));
  EXPECT_TRUE(names_in(dir / "out").empty());
}

TEST_F(FilesE2e, AFullDiskDuringAScanIsSeventyFour) {
  ProcessOptions small;
  small.file_size_limit_blocks = 400;
  auto arguments = small_scan(kDevice, dir / "a.tif");
  const ProcessResult result = reseau(arguments, small);
  EXPECT_EQ(result.exit_code, 74) << result.err;
  EXPECT_FALSE(std::filesystem::exists(dir / "a.tif"));
}

TEST_F(FilesE2e, CompareRefusesWhatCannotBeCompared) {
  ASSERT_EQ(reseau({"simulate", "width_px=50", "height_px=40", "-o", dir / "s.tif", "--truth",
                    dir / "small.exr"})
                .exit_code,
            0);
  const ProcessResult sizes = reseau({"compare", truth(), dir / "small.exr"});
  EXPECT_EQ(sizes.exit_code, 65);
  EXPECT_THAT(sizes.err, HasSubstr("same size"));
  write_bytes(dir / "words.exr", "This is no picture.");
  EXPECT_EQ(reseau({"compare", truth(), dir / "words.exr"}).exit_code, 65);
  EXPECT_EQ(reseau({"compare", truth(), dir / "missing.exr"}).exit_code, 65);
}

}  // namespace
}  // namespace reseau::testing
