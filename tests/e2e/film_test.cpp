// Film as the adapters hold it, scanned whole with the program: where on the film each frame lies,
// frames that were moved, and folders that scans make.
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/unit_model.h"
#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using ::testing::HasSubstr;

// Without noise a pass is known to the last bit.
const std::string kUnit = "sim:ls5000?noise=0&cells=1&scene=natural&seed=3";
constexpr int kBestFocus = 209;
// The unit's own white balance, and with it that of the colours that are not given.
constexpr const char* kRedExposure = "579.8us";
constexpr double kOptical_dpi = 4000;

struct Raw {
  LineFormat format;
  std::vector<std::uint16_t> samples;

  [[nodiscard]] auto line(int n) const {
    return samples.begin() +
           static_cast<std::ptrdiff_t>(n) * static_cast<std::ptrdiff_t>(format.samples_per_line());
  }
};

Raw read_master(const std::filesystem::path& path) {
  const Scan scan = read_scan(path);
  Raw raw{scan.source->format(), {}};
  raw.samples.resize(static_cast<std::size_t>(raw.format.n_lines) * raw.format.samples_per_line());
  scan.source->read(0, raw.format.n_lines, raw.samples);
  return raw;
}

Raw scan(const TempDir& dir, const std::string& name, const std::string& device,
         const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"scan",
                                     "-d",
                                     device,
                                     "-o",
                                     dir / (name + ".tif"),
                                     "--no-reconstruct",
                                     "--focus",
                                     std::to_string(kBestFocus),
                                     "--red-exposure",
                                     kRedExposure};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = reseau(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return read_master(dir / (name + ".tif"));
}

// What the film shows there.
std::vector<std::uint16_t> film_samples(const std::string& device, const LineFormat& format,
                                        int y_px, int pitch) {
  sim::ScanWindow window;
  window.pitch = pitch;
  window.y_px = y_px;
  window.width_px = format.width_px;
  window.n_lines = format.n_lines;
  sim::SimSpec spec = sim::parse_sim_spec(device);
  spec.sensor.adc_bits = sim::unit_model("ls5000").adc_bits;
  return sim::simulate_window(spec, window).samples;
}

struct Adapter {
  const char* name;
  int frame;
  int frame_px, height_px, width_px;  // from frame to frame, and of a frame, optical
};

class EveryAdapter : public ::testing::TestWithParam<Adapter> {};

TEST_P(EveryAdapter, ScansTheWholeFrameOfItsFilm) {
  const Adapter& adapter = GetParam();
  constexpr int kPitch = 20;
  const TempDir dir;
  const std::string device =
      fmt::format("{}&adapter={}&frames={}", kUnit, adapter.name, std::max(adapter.frame, 2));
  std::vector<std::string> more{"--resolution", "200dpi", "--frame", std::to_string(adapter.frame)};
  if (adapter.name == std::string("feeder")) more.assign({"--resolution", "200dpi", "--load"});
  const Raw raw = scan(dir, "whole", device, more);
  EXPECT_EQ(raw.format.width_px, adapter.width_px / kPitch);
  EXPECT_EQ(raw.format.n_lines, adapter.height_px / kPitch);
  const auto film =
      film_samples(device, raw.format, (adapter.frame - 1) * adapter.frame_px, kPitch);
  EXPECT_TRUE(raw.samples == film) << "elsewhere on the film";
  const std::set<std::uint16_t> values(film.begin(), film.end());
  EXPECT_GT(values.size(), 1000U) << "a flat film would show nothing";
}

INSTANTIATE_TEST_SUITE_P(Adapters, EveryAdapter,
                         ::testing::Values(Adapter{"mount", 1, 0, 5782, 3946},
                                           Adapter{"sa21", 6, 5959, 5959, 3946},
                                           Adapter{"sa30", 37, 5959, 5959, 3946},
                                           Adapter{"aps", 25, 4453, 4453, 2916},
                                           Adapter{"feeder", 1, 0, 5782, 3946}),
                         [](const auto& one) { return std::string(one.param.name); });

// How many lines the second picture lies further along the film; absent where they show no common
// part.
std::optional<int> shift_of(const Raw& one, const Raw& other) {
  constexpr int kMost = 120;
  const int n = one.format.n_lines - kMost;
  for (int shift = -kMost; shift <= kMost; ++shift) {
    const int from_one = std::max(shift, 0), from_other = std::max(-shift, 0);
    if (std::equal(one.line(from_one), one.line(from_one + n), other.line(from_other))) {
      return shift;
    }
  }
  return std::nullopt;
}

TEST(FilmE2e, AFrameMovesByAQuarterOfAMillimetreOnTheFilm) {
  const TempDir dir;
  const std::string strip = kUnit + "&adapter=sa21&frames=4";
  const auto at = [&](const std::string& name, const std::string& offset) {
    return scan(dir, name, strip,
                {"--frame", "3", "--frame-offset", offset, "-l", "10mm", "-t", "10mm", "-x",
                 "1.5mm", "-y", "1.5mm"});
  };
  const Raw still = at("still", "0mm");
  // The film stops at pulses of the motor, 7 units of 4000 to the inch.
  constexpr double kHalfPulse_mm = 3.5 * 25.4 / kOptical_dpi;
  for (const double offset_mm : {0.25, -0.25, 0.5}) {
    const Raw moved = at(fmt::format("moved{}", offset_mm), fmt::format("{}mm", offset_mm));
    const std::optional<int> shift = shift_of(still, moved);
    ASSERT_TRUE(shift.has_value()) << offset_mm;
    EXPECT_NEAR(*shift * 25.4 / kOptical_dpi, offset_mm, kHalfPulse_mm + 0.001);
  }
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "moved-0.25.json"));
  EXPECT_EQ(receipt["scan"]["request"]["frame_offset_mm"], -0.25);
  EXPECT_EQ(receipt["scan"]["request"]["samples"], 1);
  EXPECT_EQ(receipt["scan"]["request"]["sensor_lines"], "auto");
}

TEST(FilmE2e, TheReceiptSaysHowTheLinesWereRead) {
  const TempDir dir;
  scan(dir, "one", kUnit, {"--samples", "2", "--sensor-lines", "all", "-x", "1mm", "-y", "1mm"});
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "one.json"));
  EXPECT_EQ(receipt["scan"]["request"]["samples"], 2);
  EXPECT_EQ(receipt["scan"]["request"]["sensor_lines"], "all");
  EXPECT_EQ(receipt["scan"]["samples"], 2);
  EXPECT_EQ(receipt["scan"]["sensor_lines"], 2);
}

TEST(FilmE2e, PreviewMakesItsFolder) {
  const TempDir dir;
  const ProcessResult result =
      reseau({"preview", "-d", "sim:ls5000?frames=2", "-o", dir / "new/deep/strip.png"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(names_in(dir / "new/deep"), (std::vector<std::string>{"strip.png"}));
}

TEST(FilmE2e, ARecordingMakesItsFolder) {
  const TempDir dir;
  const ProcessResult result =
      reseau({"scan", "-d", kUnit, "--resolution", "500dpi", "-x", "2mm", "-y", "2mm", "-o",
              dir / "scans", "--no-reconstruct", "--record", dir / "sessions/box3.pcapng"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(reseau({"session", "check", dir / "sessions/box3.pcapng"}).exit_code, 0);
}

TEST(FilmE2e, OnlyUnitsWithUsbAreExported) {
  const TempDir dir;
  for (const std::string model : {"ls9000", "ls30"}) {
    const ProcessResult result =
        reseau({"simulate", "--usbip", "unix:" + (dir / "s").string(), "--model", model});
    EXPECT_EQ(result.exit_code, 64);
    EXPECT_THAT(result.err, HasSubstr("has no USB"));
  }
}

TEST(FilmE2e, WhatDoesNotBeginLeavesNoFolderBehind) {
  const TempDir dir;
  for (const std::string device : {"sim:nonsense", "usb:04b0:4999", "sim:ls5000?film=empty"}) {
    for (const std::vector<std::string>& verb :
         {std::vector<std::string>{"scan", "-o", dir / "new/deep"},
          std::vector<std::string>{"preview", "-o", dir / "new/deep/a.png"}}) {
      std::vector<std::string> arguments = verb;
      arguments.insert(arguments.end(), {"-d", device});
      EXPECT_NE(reseau(arguments).exit_code, 0) << device;
      EXPECT_TRUE(names_in(dir.path()).empty()) << verb[0] << " " << device;
    }
  }
  std::filesystem::create_directory(dir / "mine");
  EXPECT_NE(reseau({"scan", "-d", "sim:nonsense", "-o", dir / "mine/new"}).exit_code, 0);
  EXPECT_EQ(names_in(dir.path()), (std::vector<std::string>{"mine"})) << "one that was there stays";
  EXPECT_TRUE(names_in(dir / "mine").empty());
}

}  // namespace
}  // namespace reseau::testing
