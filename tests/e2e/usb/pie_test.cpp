// PIE units as USB devices: our own driver through the real libusb, and an unmodified scanimage
// with SANE's pieusb, which its authors made on units of their own.
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "drivers/sim/simulate.h"
#include "tests/e2e/reseau_run.h"
#include "tests/e2e/usb/exported_unit.h"

namespace reseau::testing {
namespace {

// Without noise, and with a sensor that is even, a pass is known to the last bit.
const std::vector<std::string> kEven{"scene=natural", "noise=0",      "cells=1",
                                     "seed=3",        "busy_polls=0", "shading=0",
                                     "pixel_gain=0",  "dark=0",       "dark_pattern=0"};

std::string direct(const std::string& model) {
  return fmt::format("sim:{}?{}", model, fmt::join(kEven, "&"));
}

std::vector<std::uint16_t> samples_of_master(const std::string& path) {
  const Scan scan = read_scan(path);
  const LineFormat format = scan.source->format();
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(format.n_lines) *
                                     format.samples_per_line());
  scan.source->read(0, format.n_lines, samples);
  return samples;
}

TEST(PieOverUsb, OurDriverSeesTheSameUnitAsWithoutACable) {
  for (const std::string model : {"crystalscan3600", "rps7200"}) {
    SCOPED_TRACE(model);
    const ExportedUnit unit(model, kEven);
    const auto scan = [&](const std::string& name) {
      return std::vector<std::string>{RESEAU_BINARY,  "scan",   "--no-reconstruct",
                                      "--resolution", "600dpi", "--red-exposure",
                                      "3000us",       "-x",     "4mm",
                                      "-y",           "4mm",    "-o",
                                      unit.file(name)};
    };
    // Twice: a client that has gone leaves a unit that serves the next.
    for (const std::string name : {"first.tif", "second.tif"}) {
      const ProcessResult result = unit.run(scan(name));
      ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    std::vector<std::string> straight = scan("direct.tif");
    straight.insert(straight.end(), {"-d", direct(model)});
    ASSERT_EQ(run_process(straight, {}).exit_code, 0);
    const auto expected = samples_of_master(unit.file("direct.tif"));
    EXPECT_TRUE(samples_of_master(unit.file("first.tif")) == expected);
    EXPECT_TRUE(samples_of_master(unit.file("second.tif")) == expected);
  }
}

// The last scan frame that SANE sent, as its log shows the bytes.
sim::ScanWindow frame_in(const std::string& log, int pitch) {
  const std::string head = "12 00 0a 00 80 00 ";
  const std::size_t at = log.rfind(head);
  if (at == std::string::npos) return {};
  std::istringstream bytes(log.substr(at + head.size(), 23));
  int corner[4] = {};
  for (int& value : corner) {
    int low = 0, high = 0;
    bytes >> std::hex >> low >> high;
    value = low | high << 8;
  }
  sim::ScanWindow window;
  window.pitch = pitch;
  window.x_px = corner[0];
  window.y_px = corner[1];
  window.width_px = (corner[2] - corner[0] + 1) / pitch;
  window.n_lines = (corner[3] - corner[1] + 1) / pitch;
  return window;
}

struct PieJob {
  const char* model;
  int resolution_dpi, max_dpi;
};

class ScanimagePieusb : public ::testing::TestWithParam<PieJob> {};

TEST_P(ScanimagePieusb, ScansTheFilmLineByLine) {
  const PieJob& job = GetParam();
  const ExportedUnit unit(job.model, kEven, "pieusb");
  const std::string path = unit.file("scan.pnm");
  const ProcessResult result = unit.scanimage({"-d",
                                               "pieusb:libusb:001:002",
                                               "--mode",
                                               "Color",
                                               "--depth",
                                               "16",
                                               "--resolution",
                                               std::to_string(job.resolution_dpi),
                                               "--calibration",
                                               "default values",
                                               "--gain-adjust",
                                               "* 1.0",
                                               "--correct-shading=no",
                                               "--crop",
                                               "None",
                                               "-l",
                                               "5",
                                               "-t",
                                               "4",
                                               "-x",
                                               "8",
                                               "-y",
                                               "6",
                                               "--format=pnm",
                                               "-o",
                                               path},
                                              {"SANE_DEBUG_PIEUSB=15"});
  ASSERT_EQ(result.exit_code, 0) << result.err.substr(result.err.size() - 2000);
  const sim::ScanWindow window = frame_in(result.err, job.max_dpi / job.resolution_dpi);
  const sim::SimulatedScan film =
      sim::simulate_window(sim::parse_sim_spec(direct(job.model)), window);
  const std::string bytes = test::file_bytes(path);
  const auto width = static_cast<std::size_t>(window.width_px);
  const auto n = static_cast<std::size_t>(window.n_lines) * width * 3;
  ASSERT_GT(n, 10000U);
  ASSERT_GT(bytes.size(), 2 * n);
  const std::string head = bytes.substr(0, bytes.size() - 2 * n);
  EXPECT_NE(head.find(fmt::format("{} {}\n65535", window.width_px, window.n_lines)),
            std::string::npos)
      << head;
  int n_wrong = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto high = static_cast<unsigned char>(bytes[head.size() + 2 * i]);
    const auto low = static_cast<unsigned char>(bytes[head.size() + 2 * i + 1]);
    const std::size_t line = i / (3 * width), x = i / 3 % width, colour = i % 3;
    n_wrong += (high << 8 | low) != film.samples[(line * 4 + colour) * width + x] ? 1 : 0;
  }
  EXPECT_EQ(n_wrong, 0);
}

INSTANTIATE_TEST_SUITE_P(Models, ScanimagePieusb,
                         ::testing::Values(PieJob{"crystalscan7200", 600, 7200},
                                           PieJob{"proscan10t", 1000, 10000},
                                           PieJob{"digitdia6000", 500, 5000},
                                           PieJob{"crystalscan3600", 900, 3600}),
                         [](const auto& job) { return std::string(job.param.model); });

}  // namespace
}  // namespace reseau::testing
