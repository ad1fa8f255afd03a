// `reseau calibrate` on edges whose transfer function is known in closed form.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"
#include "tests/support/temp_dir.h"

namespace reseau::testing {
namespace {

using ::testing::HasSubstr;

// A dark and a bright half with a straight edge between them, blurred by a Gaussian of its own for
// each channel, and the same small noise in every run.
Pixels slanted_edge(double angle_deg, const std::vector<double>& sigma_px) {
  const double angle = angle_deg * std::numbers::pi / 180;
  Pixels p{90, 120, static_cast<int>(sigma_px.size()), {}};
  std::uint32_t state = 1;
  for (int y = 0; y < p.height_px; ++y) {
    for (int x = 0; x < p.width_px; ++x) {
      const double d = (x - 45) * std::cos(angle) + (y - 60) * std::sin(angle);
      for (const double sigma : sigma_px) {
        state = state * 1664525u + 1013904223u;
        const double noise = (static_cast<double>(state >> 8) / (1 << 24) - 0.5) * 200;
        const double light = 0.5 * std::erfc(-d / (sigma * std::numbers::sqrt2));
        p.samples.push_back(static_cast<std::uint16_t>(6000 + 42000 * light + noise));
      }
    }
  }
  return p;
}

double mtf50_of_gaussian(double sigma_px) {
  return std::sqrt(2 * std::numbers::ln2) / (2 * std::numbers::pi * sigma_px);
}

TEST(CalibrateE2e, FindsTheKnownTransferFunctionOfEveryChannel) {
  const TempDir dir;
  const std::vector<double> sigma_px{0.7, 0.9, 0.8, 1.2};
  write_tiff(dir / "edge.tif", slanted_edge(6, sigma_px), 16);
  const ProcessResult run =
      reseau({"calibrate", dir / "edge.tif", "--gamma", "1", "--roi", "5,5,80,110", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto lines = json_lines(run.out);
  ASSERT_FALSE(lines.empty());
  const nlohmann::json& channels = lines.front().at("channels");
  const char* const names[] = {"red", "green", "blue", "infrared"};
  for (std::size_t c = 0; c < sigma_px.size(); ++c) {
    const nlohmann::json& channel = channels.at(names[c]);
    EXPECT_EQ(channel.at("status"), "ok") << names[c];
    const double truth = mtf50_of_gaussian(sigma_px[c]);
    EXPECT_NEAR(channel.at("mtf50").get<double>(), truth, 0.01 * truth) << names[c];
    EXPECT_NEAR(std::abs(channel.at("angle_deg").get<double>()), 6, 0.1) << names[c];
    EXPECT_GT(channel.at("mtf50_sd").get<double>(), 0) << names[c];
  }
}

TEST(CalibrateE2e, RefusesWhatIsNoEdgeWithReasons) {
  const TempDir dir;
  Pixels grey = slanted_edge(6, {0.8, 0.8, 0.8});
  for (std::uint16_t& sample : grey.samples) sample = 20000;
  write_tiff(dir / "grey.tif", grey, 16);
  for (const char* roi : {"0,0,90,120", "0,0,1,1"}) {
    const ProcessResult run =
        reseau({"calibrate", dir / "grey.tif", "--gamma", "1", "--roi", roi, "--json"});
    const auto lines = json_lines(run.out);
    ASSERT_FALSE(lines.empty()) << run.err;
    const nlohmann::json& red = lines.front().at("channels").at("red");
    EXPECT_NE(red.at("status"), "ok") << roi;
    EXPECT_FALSE(red.at("reasons").empty()) << roi;
    EXPECT_TRUE(red.at("mtf50").is_null()) << roi;
  }
}

TEST(CalibrateE2e, TheReportHoldsTablesPlotsAndTheSharedOptics) {
  const TempDir dir;
  write_tiff(dir / "edge.tif", slanted_edge(6, {0.7, 0.9, 0.8, 1.2}), 16);
  const std::vector<std::string> command{"calibrate", dir / "edge.tif", "--gamma", "1",
                                         "--report",  dir / "a.html",   "--json"};
  const ProcessResult run = reseau(command);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto lines = json_lines(run.out);
  ASSERT_FALSE(lines.empty());
  const nlohmann::json& psf = lines.front().at("psf");
  EXPECT_TRUE(psf.at("ok").get<bool>());
  EXPECT_TRUE(psf.at("parameters").contains("aperture_squared_px2"));
  EXPECT_TRUE(psf.at("parameters").contains("infrared.diffraction_px"));
  EXPECT_LT(psf.at("chi2_per_freedom").get<double>(), 2);
  const std::string html = file_bytes(dir / "a.html");
  for (const char* part :
       {"<svg", "SFR50", "sampling efficiency", "infrared", "aperture_squared_px2"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  // Needs nothing from elsewhere, and is never written over.
  EXPECT_EQ(html.find("src="), std::string::npos);
  EXPECT_EQ(reseau(command).exit_code, 74);
}

// The same lens sees an edge and a random target: both say how sharp it is, by ways that have
// nothing in common.
TEST(CalibrateE2e, ARandomTargetAgreesWithEdgesOfTheSameLens) {
  const TempDir dir;
  const auto simulate = [&](const char* name, const std::vector<std::string>& what) {
    std::vector<std::string> command{"simulate",    "--set", "optics=coolscan", "--set",
                                     "noise=0.001", "-o",    dir / name};
    command.insert(command.end(), what.begin(), what.end());
    ASSERT_EQ(reseau(command).exit_code, 0);
  };
  simulate("random.tif", {"--film", "random", "--seed", "7", "--width", "112", "--height", "100"});
  simulate("edge.tif", {"--film", "none", "--scene", "edges", "--width", "500", "--height", "500"});
  const ProcessResult run = reseau({"calibrate", dir / "edge.tif", "--random", dir / "random.tif",
                                    "--target", "7,3.2", "--roi", "192,288,112,112", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = json_lines(run.out).front();
  const nlohmann::json& channels = result.at("random").at(0).at("channels");
  for (const char* name : {"red", "green", "blue", "infrared"}) {
    const nlohmann::json& c = channels.at(name);
    ASSERT_EQ(c.at("status"), "ok") << name;
    EXPECT_NEAR(c.at("turn_deg").get<double>(), 5, 0.02) << name;
    EXPECT_LT(c.at("relative_sd").get<double>(), 0.02) << name;
    EXPECT_LT(c.at("target_sd_px").at(0).get<double>(), 0.01) << name;
    EXPECT_EQ(c.at("psf_per_px2").size(), 19 * 19) << name;
  }
  int compared = 0;
  for (const nlohmann::json& pair : result.at("random_against_edges")) {
    const double random = pair.at("mtf50_random"), edge = pair.at("mtf50_edge");
    const double sd = std::hypot(pair.at("mtf50_random_sd").get<double>(),
                                 pair.at("mtf50_edge_sd").get<double>());
    EXPECT_NEAR(random, edge, 3 * sd + 0.006 * edge) << pair;
    EXPECT_NEAR(random, edge, 0.03 * edge) << pair;
    ++compared;
  }
  EXPECT_GE(compared, 4);
  // Another target than the one that was laid in.
  const ProcessResult wrong = reseau({"calibrate", "--random", dir / "random.tif", "--target",
                                      "8,3.2", "--report", dir / "a.html", "--json"});
  EXPECT_EQ(wrong.exit_code, 65);
  const nlohmann::json green =
      json_lines(wrong.out).front().at("random").at(0).at("channels").at("green");
  EXPECT_EQ(green.at("status"), "not_this_target");
  EXPECT_FALSE(green.contains("psf_per_px2"));
  EXPECT_THAT(file_bytes(dir / "a.html"), HasSubstr("does not look like the random target"));
  EXPECT_EQ(reseau({"calibrate", "--random", dir / "random.tif", "--target", "x"}).exit_code, 64);
}

TEST(CalibrateE2e, SaysWhatIsWrongWithFileAndRegion) {
  const TempDir dir;
  EXPECT_EQ(reseau({"calibrate", dir / "none.tif"}).exit_code, 65);
  write_tiff(dir / "edge.tif", slanted_edge(6, {0.8, 0.8, 0.8}), 16);
  const ProcessResult outside = reseau({"calibrate", dir / "edge.tif", "--roi", "80,0,50,50"});
  EXPECT_EQ(outside.exit_code, 64);
  EXPECT_THAT(outside.err, HasSubstr("90"));
}

// No target at all: the réseau of a film tells where infrared lies against the colours.
TEST(CalibrateE2e, TheReseauTellsWhereInfraredLies) {
  const TempDir dir;
  ASSERT_EQ(reseau({"simulate", "--film", "dufay", "--scene", "natural", "--width", "500",
                    "--height", "400", "--set", "ir_shift_px=0.2", "--set", "ir_shift_y_px=-0.1",
                    "-o", dir / "film.tif"})
                .exit_code,
            0);
  ASSERT_EQ(
      reseau({"reconstruct", dir / "film.tif", "-o", dir / "out", "--no-view", "--profile", "none"})
          .exit_code,
      0);
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "out/film.json"));
  const nlohmann::json& sharpness = receipt.at("reconstruction").at("sharpness");
  // Infrared looks 0.2 px further along the sensor: what colours show at p it shows before.
  const double expected[] = {-0.2, 0.1};
  for (std::size_t i = 0; i < 2; ++i) {
    const double sd = sharpness.at("infrared_from_rgb_sd_px").at(i);
    EXPECT_LT(sd, 0.003);
    EXPECT_NEAR(sharpness.at("infrared_from_rgb_px").at(i).get<double>(), expected[i],
                4 * sd + 1e-4);
  }
}

// So it does where red and blue lie; each channel sees all three elements.
TEST(CalibrateE2e, TheReseauTellsWhereEveryChannelLies) {
  const TempDir dir;
  const double red[] = {0.15, -0.08}, blue[] = {-0.2, 0.1}, infrared[] = {0.1, 0.05};
  const auto word = [](const char* key, double value) { return fmt::format("{}={}", key, value); };
  ASSERT_EQ(reseau({"simulate",
                    "--film",
                    "dufay",
                    "--scene",
                    "natural",
                    "--width",
                    "500",
                    "--height",
                    "400",
                    "--seed",
                    "3",
                    "--set",
                    word("red_shift_px", red[0]),
                    "--set",
                    word("red_shift_y_px", red[1]),
                    "--set",
                    word("blue_shift_px", blue[0]),
                    "--set",
                    word("blue_shift_y_px", blue[1]),
                    "--set",
                    word("ir_shift_px", infrared[0]),
                    "--set",
                    word("ir_shift_y_px", infrared[1]),
                    "-o",
                    dir / "film.tif"})
                .exit_code,
            0);
  const ProcessResult run = reseau({"calibrate", "--reseau", dir / "film.tif", "--model", "X",
                                    "--dpi", "4000", "--profile", dir / "unit.json", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = json_lines(run.out).front();
  const nlohmann::json& channels = result.at("reseau").at(0).at("channels_from_green");
  const auto unit = nlohmann::json::parse(file_bytes(dir / "unit.json"));
  double squares = 0;
  const std::pair<const char*, const double*> all[] = {
      {"red", red}, {"blue", blue}, {"infrared", infrared}};
  for (const auto& [channel, shift] : all) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double at = channels.at(channel).at("px").at(i),
                   sd = channels.at(channel).at("sd_px").at(i);
      // A channel that looks farther along sees what green sees before.
      squares += std::pow((at + shift[i]) / sd, 2) / 6;
      EXPECT_LT(std::abs(at + shift[i]), 4 * sd) << channel << " " << at << " ± " << sd;
      EXPECT_LT(sd, 0.02) << channel;
      EXPECT_EQ(unit.at("channels").at(channel).at("offset_from_green_px").at(i), at);
    }
  }
  EXPECT_LT(std::sqrt(squares), 2);
  // Elements that do not lie evenly about a point: said, not told.
  ASSERT_EQ(reseau({"simulate", "--film", "joly", "--scene", "natural", "--width", "500",
                    "--height", "400", "-o", dir / "lines.tif"})
                .exit_code,
            0);
  const ProcessResult lines = reseau({"calibrate", "--reseau", dir / "lines.tif", "--json"});
  EXPECT_EQ(lines.exit_code, 65) << lines.err;
  EXPECT_THAT(lines.out, HasSubstr("looks like a shift"));
}

// Mean colour error of a reconstruction against what the simulated film holds.
double median_error(const TempDir& dir, const std::string& folder) {
  const ProcessResult run =
      reseau({"compare", dir / "truth.exr", dir / (folder + "/film.exr"), "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return json_lines(run.out).at(0).at("delta_e_2000").at("median").get<double>();
}

TEST(CalibrateE2e, AScanOfACalibratedUnitComesOutTruer) {
  const TempDir dir;
  ProcessOptions home;
  home.environment = {"XDG_DATA_HOME=" + (dir / "data").string()};
  // The same lens sees a razor and a film. Its diffraction fades colours, which no scan tells.
  const std::vector<std::string> optics{"--set", "optics=coolscan", "--set", "noise=0.0005"};
  std::vector<std::string> razor{"simulate",       "--film", "none",     "--scene", "edges",
                                 "--width",        "500",    "--height", "500",     "-o",
                                 dir / "razor.tif"};
  razor.insert(razor.end(), optics.begin(), optics.end());
  ASSERT_EQ(reseau(razor).exit_code, 0);
  std::vector<std::string> film{"simulate",       "--scene", "chart24", "--width",        "600",
                                "--height",       "600",     "-o",      dir / "film.tif", "--truth",
                                dir / "truth.exr"};
  film.insert(film.end(), optics.begin(), optics.end());
  ASSERT_EQ(reseau(film).exit_code, 0);
  const auto reconstruct = [&](const std::string& folder, const std::string& profile) {
    return reseau({"reconstruct", dir / "film.tif", "-o", dir / folder, "--space", "process",
                   "--white", "0.9", "--no-view", "--profile", profile},
                  home);
  };
  // The unit's name is that of the scan; a wrong one is refused, and nothing is written.
  ASSERT_EQ(reseau({"calibrate", dir / "razor.tif", "--save", "--model", "simulated film"}, home)
                .exit_code,
            0);
  const auto kept = only_file(dir / "data/reseau/calibrations/simulated_film-", ".json");
  ASSERT_EQ(reconstruct("without", "none").exit_code, 0);
  ASSERT_EQ(reconstruct("with", "auto").exit_code, 0);
  ASSERT_EQ(reconstruct("given", kept.string()).exit_code, 0);
  const double without = median_error(dir, "without"), with = median_error(dir, "with");
  std::printf("median dE00 %.3f without, %.3f with the calibration\n", without, with);
  EXPECT_LT(with, 0.7 * without);
  EXPECT_EQ(file_bytes(dir / "with/film.exr"), file_bytes(dir / "given/film.exr"));
  const auto receipt = nlohmann::json::parse(file_bytes(dir / "with/film.json"));
  const auto& sharpness = receipt.at("reconstruction").at("sharpness");
  EXPECT_EQ(sharpness.at("profile").at("path"), kept.string());
  EXPECT_GT(sharpness.at("infrared").at("of_unit").at("far_share").get<double>(), 0.03);

  std::string other = file_bytes(kept);
  const std::string name = "\"simulated film\"";
  other.replace(other.find(name), name.size(), "\"LS-50\"");
  write_bytes(dir / "other.json", other);
  const ProcessResult refused = reconstruct("other", dir / "other.json");
  EXPECT_EQ(refused.exit_code, 65);
  EXPECT_THAT(refused.err, HasSubstr("does not fit this scan"));
  EXPECT_THAT(refused.err, HasSubstr("LS-50"));
  EXPECT_FALSE(std::filesystem::exists(dir / "other"));
  // Before the scanner moves, too.
  const ProcessResult scan = reseau({"scan", "-d", "sim:ls5000", "-o", dir / "scan", "--profile",
                                     dir / "other.json", "--no-reconstruct"});
  EXPECT_EQ(scan.exit_code, 65);
  EXPECT_THAT(scan.err, HasSubstr("does not fit this scan"));
  EXPECT_FALSE(std::filesystem::exists(dir / "scan"));
}

}  // namespace
}  // namespace reseau::testing
