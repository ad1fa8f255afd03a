// `reseau calibrate` at a simulated scanner whose truth is known: edges, focus, open frame.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/scan_reader.h"
#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"
#include "tests/support/process.h"
#include "tests/support/temp_dir.h"

namespace reseau::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr double kNoise = 0.004, kDark = 0.01;

// As reseau(), with the time that a whole calibration takes on a busy machine.
ProcessResult calibrate(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  ProcessResult result = run_process(command(arguments), options, std::chrono::minutes(9));
  EXPECT_FALSE(result.timed_out) << result.err;
  return result;
}

ProcessOptions home_of(const TempDir& dir) {
  ProcessOptions home;
  home.environment = {"XDG_DATA_HOME=" + (dir / "data").string()};
  return home;
}

std::vector<std::string> bench(const TempDir& dir, const std::string& device) {
  return {"calibrate", "--device", device, "--yes", "--json", "-o",  dir / "bench",
          "-t",        "1mm",      "-x",   "4.5mm", "-y",     "4mm", "--focus-positions",
          "5"};
}

// Frequency where a Gaussian of sigma behind a square aperture of 1 px, seen across the pixels at a
// few degrees, falls to one half.
double mtf50_of(double sigma_px) {
  double low = 0.01, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double f = (low + high) / 2, t = std::acos(-1.0) * f;
    const double a = 5 * std::acos(-1.0) / 180;
    const auto sinc = [](double x) { return x == 0 ? 1 : std::sin(x) / x; };
    const double m =
        std::exp(-2 * t * t * sigma_px * sigma_px) * sinc(t * std::cos(a)) * sinc(t * std::sin(a));
    (m > 0.5 ? low : high) = f;
  }
  return low;
}

TEST(CalibrateBenchE2e, ASimulatedUnitIsMeasuredAsItIs) {
  const TempDir dir;
  std::vector<std::string> arguments =
      bench(dir, "sim:ls5000?noise=0.004&dark=0.01&shading=0.08&pixel_gain=0.01");
  arguments.emplace_back("--with-random");
  const ProcessResult run = calibrate(arguments, home_of(dir));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = json_lines(run.out).at(0);

  // Edges: a Gaussian of 0.6 px (infrared 0.7) and the pixel.
  const json& green = result.at("channels").at("green");
  EXPECT_NEAR(green.at("mtf50").get<double>(), mtf50_of(0.6), 0.004 * mtf50_of(0.6));
  const json& infrared = result.at("channels").at("infrared");
  EXPECT_NEAR(infrared.at("mtf50").get<double>(), mtf50_of(0.7), 0.004 * mtf50_of(0.7));

  // Focus: the unit is sharpest at step 209; blur grows by 0.015 px a step in quadrature, which
  // takes 2 (pi 0.015 f u)^2 of ln M.
  const json& focus = result.at("focus");
  const double f = focus.at("frequency_cy_per_px").get<double>();
  const double depth = std::sqrt(-std::log(0.8) / 2) / (std::acos(-1.0) * 0.015 * f);
  for (const char* channel : {"red", "green", "blue", "infrared"}) {
    const json& one = focus.at("channels").at(channel);
    ASSERT_TRUE(one.at("ok").get<bool>()) << one.dump();
    EXPECT_NEAR(one.at("best_steps").get<double>(), 209,
                4 * one.at("best_steps_sd").get<double>() + 0.2)
        << channel;
    EXPECT_LT(one.at("best_steps_sd").get<double>(), 1);
    EXPECT_NEAR(one.at("depth_of_field_steps").get<double>(), 2 * depth, 0.03 * 2 * depth);
  }

  // Open frame.
  for (const char* channel : {"red", "green", "blue", "infrared"}) {
    const json& one = result.at("gate").at("channels").at(channel);
    EXPECT_NEAR(one.at("dark_level").get<double>(), kDark,
                4 * one.at("dark_level_sd").get<double>() + 1e-5);
    const json& noise = one.at("noise");
    const double shot = kNoise * kNoise * 0.96, read = kNoise * kNoise * 0.04;
    EXPECT_NEAR(noise.at("shot_variance_per_level").get<double>(), shot, 0.03 * shot);
    EXPECT_NEAR(noise.at("read_variance").get<double>(), read,
                4 * std::sqrt(noise.at("covariance").at(0).at(0).get<double>()) + 0.02 * read);
    EXPECT_LT(one.at("nonlinearity").get<double>(), 3e-4);
    for (const auto& [from, leak] : one.at("leakage_from").items()) {
      EXPECT_NEAR(leak.at("share").get<double>(), 0, 4 * leak.at("sd").get<double>() + 1e-4)
          << from;
    }
    EXPECT_NEAR(one.at("pixel_gain_rms").get<double>(), 0.01, 0.001);
  }

  // The random target sees what the edges see.
  const json& random = result.at("random").at(0).at("channels").at("green");
  ASSERT_EQ(random.at("status"), "ok");
  EXPECT_NEAR(random.at("mtf50_x").get<double>(), mtf50_of(0.6),
              3 * random.at("mtf50_x_sd").get<double>() + 0.006 * mtf50_of(0.6));

  // Kept for this unit, with a report that needs nothing else.
  const std::filesystem::path kept = result.at("profile").get<std::string>();
  EXPECT_THAT(kept.string(), HasSubstr((dir / "data/reseau/calibrations").string()));
  const json profile = json::parse(file_bytes(kept));
  const json& channel = profile.at("channels").at("green");
  EXPECT_EQ(channel.at("flat_gain").size(),
            result.at("gate").at("channels").at("green").at("flat_pixels"));
  EXPECT_TRUE(channel.at("gate").contains("noise_covariance"));
  EXPECT_TRUE(channel.contains("focus"));
  EXPECT_EQ(channel.at("random").at("psf_per_px2").size(), random.at("psf_per_px2").size());
  const json& model = profile.at("psf_model");
  const std::size_t n = model.at("names").size();
  EXPECT_EQ(model.at("covariance").size(), n * n);
  // Every parameter over the frame, which a rendered Gaussian does not change.
  const json& surfaces = model.at("surfaces");
  const std::size_t m = surfaces.at("coefficients").size();
  EXPECT_EQ(surfaces.at("covariance").size(), m * m);
  for (const json& at : result.at("psf_field").at("mtf50").at("green")) {
    EXPECT_NEAR(at.at("mtf50_x").get<double>(), mtf50_of(0.6),
                4 * at.at("mtf50_x_sd").get<double>() + 0.002 * mtf50_of(0.6));
  }
  const std::string html = file_bytes(result.at("report").get<std::string>());
  for (const char* part : {"Through focus", "Noise against level", "Flat field", "SFR50",
                           "Optics over the frame", "illumination non-uniformity", "ISO 19264-1"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(html.find("src="), std::string::npos);

  // The same calibration has not changed against itself; one of another day would be shown.
  const ProcessResult same = reseau({"calibrate", "--compare", kept, kept, "--json"});
  ASSERT_EQ(same.exit_code, 0) << same.err;
  EXPECT_FALSE(json_lines(same.out).at(0).at("changed").get<bool>());
  json other = profile;
  json& width = other["channels"]["green"]["psf"]["sigma_px"];
  width = 1.1 * width.get<double>();
  write_bytes(dir / "other.json", other.dump());
  const ProcessResult changed =
      reseau({"calibrate", "--compare", dir / "other.json", kept, "--json"});
  const json compared = json_lines(changed.out).at(0);
  EXPECT_TRUE(compared.at("changed").get<bool>());
  EXPECT_NEAR(compared.at("channels").at("green").at("width_change").get<double>(), 0.1, 1e-6);
}

// Stopped while the film moves: what was read is a scan that opens, and there is nothing else.
void stopped_leaves_nothing_half_done(int signal) {
  const TempDir dir;
  Process process(command(bench(dir, "sim:ls5000")), home_of(dir));
  const auto files = [&] {
    std::vector<std::string> out;
    if (!std::filesystem::exists(dir / "bench")) return out;
    for (const auto& entry : std::filesystem::directory_iterator(dir / "bench")) {
      out.push_back(entry.path().filename().string());
    }
    return out;
  };
  const auto scans = [&] {
    return std::ranges::any_of(files(), [](const std::string& f) { return f.ends_with(".part"); });
  };
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (!scans() && std::chrono::steady_clock::now() < until) std::this_thread::yield();
  ASSERT_TRUE(scans());
  process.send(signal);
  const ProcessResult result = process.wait(std::chrono::minutes(2));
  ASSERT_FALSE(result.timed_out) << result.err;
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr("no calibration was kept"));
  EXPECT_FALSE(std::filesystem::exists(dir / "data/reseau/calibrations"));
  for (const std::string& file : files()) {
    EXPECT_TRUE(file.ends_with(".partial.tif")) << file;
    EXPECT_GT(read_scan(dir / ("bench/" + file)).source->format().n_lines, 0);
  }
}

TEST(CalibrateBenchE2e, CtrlCLeavesNothingHalfDone) { stopped_leaves_nothing_half_done(SIGINT); }
TEST(CalibrateBenchE2e, TerminateLeavesNothingHalfDone) {
  stopped_leaves_nothing_half_done(SIGTERM);
}

TEST(CalibrateBenchE2e, InfraredFocusesElsewhereThroughALens) {
  const TempDir dir;
  // A micrometre is a third of a step: infrared is best 10 steps above green.
  std::vector<std::string> arguments =
      bench(dir,
            "sim:ls5000?f_number=8&red_nm=600&green_nm=550&blue_nm=470&ir_nm=850&ir_focus_um=-30"
            "&noise=0.001&red_shift_px=0.25&blue_shift_y_px=-0.15");
  arguments.emplace_back("--no-gate");
  const ProcessResult run = calibrate(arguments, home_of(dir));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = json_lines(run.out).at(0);
  const json& one = result.at("focus").at("channels").at("infrared");
  EXPECT_NEAR(one.at("from_green_steps").get<double>(), 10,
              4 * one.at("from_green_steps_sd").get<double>() + 0.3);
  // Channels that look elsewhere: what green sees at (x, y), red sees at (x, y) + offset.
  const json profile = json::parse(file_bytes(result.at("profile").get<std::string>()));
  const auto offset = [&](const char* channel, std::size_t axis) {
    return profile.at("channels").at(channel).at("offset_from_green_px").at(axis).get<double>();
  };
  EXPECT_NEAR(std::abs(offset("red", 0)), 0.25, 0.003);
  EXPECT_NEAR(offset("red", 1), 0, 0.003);
  EXPECT_NEAR(std::abs(offset("blue", 1)), 0.15, 0.003);
  EXPECT_LT(profile.at("channels").at("red").at("offset_sd_px").at(0).get<double>(), 0.003);
}

// Open frames and edges from files, as someone has them who scanned them some other day; then a
// scan of a film by the same unit, which is reconstructed with the dark level and the flat field.
TEST(CalibrateBenchE2e, OpenFramesFromFilesServeALaterScan) {
  const TempDir dir;
  const std::string unit = "sim:ls5000?noise=0.002&dark=0.01&shading=0.08&pixel_gain=0.01";
  const auto scan = [&](const std::string& film, const std::string& name,
                        const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "scan", "-d", unit + "&" + film, "-t", "1mm", "-x", "4.5mm", "-y", "4mm", "-o", dir / name};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return calibrate(arguments, home_of(dir));
  };
  ASSERT_EQ(scan("film=razor", "razor.tif", {"--no-reconstruct"}).exit_code, 0);
  std::vector<std::string> arguments{"calibrate", dir / "razor.tif", "--save", "--json"};
  for (const char* factor : {"1", "0.6", "0.3"}) {
    const std::string name = std::string("open") + factor + ".tif";
    const ProcessResult open = scan("film=clear", name, {"--no-reconstruct", "--exposure", factor});
    ASSERT_EQ(open.exit_code, 0) << open.err;
    arguments.insert(arguments.end(), {"--gate", dir / name});
  }
  const ProcessResult run = calibrate(arguments, home_of(dir));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = json_lines(run.out).at(0);
  const json& green = result.at("gate").at("channels").at("green");
  EXPECT_NEAR(green.at("dark_level").get<double>(), kDark,
              4 * green.at("dark_level_sd").get<double>() + 2e-5);
  EXPECT_NEAR(green.at("pixel_gain_rms").get<double>(), 0.01, 0.002);
  EXPECT_TRUE(result.contains("profile")) << run.out;

  const ProcessResult film = scan("film=dufay", "film.tif", {});
  ASSERT_EQ(film.exit_code, 0) << film.err;
  const json receipt = json::parse(file_bytes(dir / "film.json"));
  const json& used = receipt.at("reconstruction").at("sharpness").at("profile");
  EXPECT_TRUE(used.at("dark_level_used").get<bool>()) << used;
  EXPECT_TRUE(used.at("flat_field_used").get<bool>()) << used;
}

TEST(CalibrateBenchE2e, SaysWhatIsMissing) {
  const TempDir dir;
  // Nobody answers, and nothing says that all is in place.
  const ProcessResult silent =
      reseau({"calibrate", "--device", "sim:ls5000", "-o", dir / "bench"}, home_of(dir));
  EXPECT_EQ(silent.exit_code, 64);
  EXPECT_THAT(silent.err, HasSubstr("--yes"));
  const ProcessResult both = reseau({"calibrate", "x.tif", "--device", "sim:ls5000"});
  EXPECT_EQ(both.exit_code, 64);
  const ProcessResult one = reseau({"calibrate", "--compare", "a.json"});
  EXPECT_EQ(one.exit_code, 64);
}

}  // namespace
}  // namespace reseau::testing
