// An unmodified scanimage, with SANE's coolscan3, scans with the exported unit: every sample is the
// film's.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "drivers/sim/simulate.h"
#include "drivers/sim/unit_model.h"
#include "tests/e2e/usb/exported_unit.h"

namespace reseau::testing {
namespace {

constexpr const char* kSaneName = "coolscan3:usb:libusb:001:002";
// Without noise a pass is known to the last bit; SANE waits a second after each poll in vain.
const std::vector<std::string> kFilm{"scene=natural", "noise=0",      "cells=1",
                                     "seed=3",        "busy_polls=0", "frames=3"};
constexpr int kBestFocus = 209;

struct Pnm {
  int width = 0, height = 0, max = 0;
  std::vector<int> samples;  // R G B of each pixel
};

Pnm read_pnm(const std::string& path) {
  const std::string bytes = test::file_bytes(path);
  std::istringstream in(bytes);
  Pnm picture;
  std::string word;
  in >> word;
  EXPECT_EQ(word, "P6");
  in >> std::ws;
  while (in.peek() == '#') std::getline(in, word);
  in >> picture.width >> picture.height >> picture.max;
  in.get();
  const std::size_t width = picture.max > 255 ? 2 : 1;
  for (auto at = static_cast<std::size_t>(in.tellg()); at + width <= bytes.size(); at += width) {
    int value = 0;
    for (std::size_t i = 0; i < width; ++i) {
      value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    }
    picture.samples.push_back(value);
  }
  return picture;
}

struct Job {
  std::string model;
  int resolution_dpi, depth_bits;
  int left_px, top_px, width_px, height_px;  // optical pixels
};

// What the unit's converter gives for a colour at an exposure, in its own bits.
std::vector<int> film_samples(const Job& job, int colour, double exposure_10ns,
                              const sim::ScanWindow& window) {
  const sim::UnitModel& unit = sim::unit_model(job.model);
  sim::SimSpec spec =
      sim::parse_sim_spec(fmt::format("sim:{}?{}", job.model, fmt::join(kFilm, "&")));
  spec.sensor.adc_bits = unit.adc_bits;
  spec.sensor.clear_level *=
      exposure_10ns / unit.white_balance_exposure[static_cast<std::size_t>(colour)];
  const sim::SimulatedScan scan = sim::simulate_window(spec, window);
  const double full = (1 << unit.adc_bits) - 1;
  std::vector<int> samples;
  for (int y = 0; y < window.n_lines; ++y) {
    const auto line =
        static_cast<std::size_t>(y * 4 + colour) * static_cast<std::size_t>(window.width_px);
    for (int x = 0; x < window.width_px; ++x) {
      // The sensor is read out mirrored, and SANE leaves it so.
      const auto at = line + static_cast<std::size_t>(window.width_px - 1 - x);
      samples.push_back(static_cast<int>(std::lround(scan.samples[at] * full / 65535)));
    }
  }
  return samples;
}

constexpr int kExposure_us[] = {500, 400, 300};
// SANE's distance between frames: 1.5 times the resolution, and one.
constexpr int kSaneFrame_px = 6001;

std::vector<std::string> arguments_for(const Job& job) {
  const auto text = [](int value) { return std::to_string(value); };
  return {"-d",
          kSaneName,
          "--depth",
          text(job.depth_bits),
          "--resolution",
          text(job.resolution_dpi),
          "--focus",
          text(kBestFocus),
          "-l",
          text(job.left_px),
          "-t",
          text(job.top_px),
          "-x",
          text(job.width_px),
          "-y",
          text(job.height_px),
          "--red-exposure",
          text(kExposure_us[0]),
          "--green-exposure",
          text(kExposure_us[1]),
          "--blue-exposure",
          text(kExposure_us[2]),
          "--format=pnm"};
}

// Every sample of the picture is that of the film in a frame, from 1.
void expect_picture(const std::string& path, const Job& job, int frame = 1) {
  const Pnm picture = read_pnm(path);
  const int pitch = sim::unit_model(job.model).optical_dpi / job.resolution_dpi;
  // SANE counts the last pixel in.
  sim::ScanWindow window;
  window.pitch = pitch;
  window.x_px = job.left_px;
  window.y_px = job.top_px + (frame - 1) * kSaneFrame_px;
  window.width_px = picture.width;
  window.n_lines = picture.height;
  ASSERT_NEAR(picture.width, job.width_px / pitch, 1);
  ASSERT_NEAR(picture.height, job.height_px / pitch, 1);
  ASSERT_EQ(picture.samples.size(), static_cast<std::size_t>(3 * picture.width * picture.height));
  const int drop = job.depth_bits == 8 ? sim::unit_model(job.model).adc_bits - 8 : 0;
  // SANE moves what has fewer than 16 bits to the top.
  const int lift = job.depth_bits > 8 ? 16 - job.depth_bits : 0;
  for (int colour = 0; colour < 3; ++colour) {
    const std::vector<int> film = film_samples(job, colour, kExposure_us[colour] * 100.0, window);
    int n_wrong = 0, first_wrong = -1;
    for (std::size_t i = 0; i < film.size(); ++i) {
      const int got = picture.samples[3 * i + static_cast<std::size_t>(colour)];
      if (got == (film[i] >> drop) << lift) continue;
      if (n_wrong++ == 0) first_wrong = static_cast<int>(i);
    }
    EXPECT_EQ(n_wrong, 0) << "colour " << colour << ", first in line "
                          << first_wrong / picture.width << ", pixel "
                          << first_wrong % picture.width;
    const auto [low, high] = std::minmax_element(film.begin(), film.end());
    EXPECT_GT(*high - *low, 1000) << "a flat film would show nothing";
  }
}

void expect_the_film(const ExportedUnit& unit, const Job& job,
                     const std::vector<std::string>& more = {}) {
  SCOPED_TRACE(fmt::format("{} {} dpi {} bit", job.model, job.resolution_dpi, job.depth_bits));
  const std::string path = unit.file("scan.pnm");
  std::vector<std::string> arguments = arguments_for(job);
  arguments.insert(arguments.end(), more.begin(), more.end());
  arguments.insert(arguments.end(), {"-o", path});
  const ProcessResult result = unit.scanimage(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_picture(path, job);
}

TEST(Scanimage, FindsEachModel) {
  for (const std::string model : {"ls50", "ls5000"}) {
    const ExportedUnit unit(model, kFilm);
    const ProcessResult list = unit.scanimage({"-L"});
    EXPECT_EQ(list.exit_code, 0) << list.err;
    EXPECT_NE(list.out.find(std::string("`") + kSaneName + "' is a Nikon " +
                            std::string(sim::unit_model(model).product)),
              std::string::npos)
        << list.out;
  }
}

TEST(Scanimage, ScansTheFilmOfAnLs5000LineByLine) {
  ExportedUnit unit("ls5000", kFilm);
  expect_the_film(unit, {"ls5000", 400, 8, 0, 3000, 3945, 299});
  expect_the_film(unit, {"ls5000", 1000, 16, 0, 0, 3945, 99});
  expect_the_film(unit, {"ls5000", 400, 8, 0, 3000, 3945, 299});
  const ProcessResult end = unit.stop();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  EXPECT_FALSE(std::filesystem::exists(unit.file("scanner.sock")));
}

TEST(Scanimage, ScansTheFilmOfAnLs50LineByLine) {
  const ExportedUnit unit("ls50", kFilm);
  expect_the_film(unit, {"ls50", 4000, 14, 0, 500, 80, 39});
  expect_the_film(unit, {"ls50", 1333, 14, 300, 0, 600, 119});
  expect_the_film(unit, {"ls50", 800, 8, 0, 0, 3945, 99});
}

TEST(Scanimage, AutofocusGoesToTheFilm) {
  const ExportedUnit unit("ls5000", kFilm);
  // SANE sets its own focus again after an autofocus, so it has to be the same.
  expect_the_film(unit, {"ls5000", 500, 16, 800, 400, 799, 159},
                  {"--autofocus=yes", "--focus-on-centre=no", "--focusx", "100", "--focusy", "50"});
}

TEST(Scanimage, ABatchScansFrameAfterFrameAndEjects) {
  const ExportedUnit unit("ls50", kFilm);
  const Job job{"ls50", 1000, 14, 400, 1000, 1999, 199};
  std::vector<std::string> arguments = arguments_for(job);
  arguments.insert(arguments.end(), {"--batch=" + unit.file("frame%d.pnm"), "--batch-count=2",
                                     "--frame-count", "2"});
  const ProcessResult batch = unit.scanimage(arguments);
  ASSERT_EQ(batch.exit_code, 0) << batch.err;
  expect_picture(unit.file("frame1.pnm"), job, 1);
  expect_picture(unit.file("frame2.pnm"), job, 2);
  EXPECT_EQ(unit.scanimage({"-d", kSaneName, "--eject", "-n"}).exit_code, 0);
  const ProcessResult empty = unit.scanimage(arguments_for(job));
  EXPECT_EQ(empty.exit_code, 7) << "no film";
}

// Where coolscan3 itself gives up (drivers/README.md): what the unit answered is what the recorded
// unit answers, or what its pages say, and the next scan is not harmed.
TEST(Scanimage, WhatItDoesNotUnderstandOfAnLs5000HarmsNothing) {
  const ExportedUnit unit("ls5000", kFilm);
  const auto answer = [&](const std::vector<std::string>& more, const std::string& resolution) {
    std::vector<std::string> arguments{"-d",           kSaneName,  "--depth", "16",
                                       "--resolution", resolution, "-y",      "199"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = unit.scanimage(arguments, {"SANE_DEBUG_COOLSCAN3=14"});
    EXPECT_EQ(result.exit_code, 9);
    return result.err;
  };
  // "Average the readings yourself", as recorded; it knows no request but padding.
  EXPECT_NE(answer({"--samples-per-scan", "4"}, "400").find("09-80-02-01"), std::string::npos);
  // Page D1 offers no exposure scan.
  EXPECT_NE(answer({"--ae"}, "400").find("05-26-00-00"), std::string::npos);
  // Page C1 offers pitch 1 and even ones; "rounded" is no failure, but it takes it for one.
  EXPECT_NE(answer({}, "1333").find("01-37-00-00"), std::string::npos);
  EXPECT_NE(answer({}, "97").find("01-37-00-00"), std::string::npos);
  expect_the_film(unit, {"ls5000", 400, 8, 0, 3000, 3945, 99});
}

}  // namespace
}  // namespace reseau::testing
