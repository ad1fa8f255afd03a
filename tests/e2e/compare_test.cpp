// Truth files, and mistakes put into one side of a comparison: each must be seen, and beside it the
// same comparison without the mistake must be clean.
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image/exr_file.h"
#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"

namespace reseau::testing {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 300, kHeight = 280;

class CompareE2e : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempDir;
    ASSERT_EQ(simulate("film", {}).exit_code, 0);
    ASSERT_EQ(reseau({"reconstruct", path("film.tif"), "-o", path("out"), "--space", "process",
                      "--white", "0.9", "--no-view"})
                  .exit_code,
              0);
    ASSERT_EQ(reseau({"register", path("film.tif"), "--map", path("map.exr")}).exit_code, 0);
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }
  static std::string path(const std::string& name) { return *shared_ / name; }
  static ProcessResult simulate(const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"simulate",
                                       "--width",
                                       std::to_string(kWidth),
                                       "--height",
                                       std::to_string(kHeight),
                                       "--scene",
                                       "natural",
                                       "-o",
                                       path(name + ".tif"),
                                       "--truth",
                                       path(name + ".exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return reseau(arguments);
  }
  static nlohmann::json compare(const std::string& a, const std::string& b,
                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"compare", a, b, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = reseau(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  }
  // The map of the registration with every pair of numbers changed.
  std::string changed_map(const char* name, const std::function<void(float&, float&)>& change) {
    FloatImage map = read_exr(path("map.exr"), {"u", "v"});
    for (std::size_t i = 0; i < map.samples.size(); i += 2) {
      change(map.samples[i], map.samples[i + 1]);
    }
    return written(map, name);
  }
  std::string written(const FloatImage& image, const char* name) {
    FloatImageWriter writer(dir / name, image.width_px, image.height_px, image.channels);
    writer.rows(0, image.height_px, image.samples);
    writer.finish();
    return dir / name;
  }
  static double rms(const nlohmann::json& json) { return json["registration"]["rms_px"]; }
  static double mean(const nlohmann::json& json) { return json["delta_e_2000"]["mean"]; }

  static TempDir* shared_;
  TempDir dir;
};
TempDir* CompareE2e::shared_ = nullptr;

TEST_F(CompareE2e, TheTruthIsSeenAsTheResultShowsIt) {
  const auto process = compare(path("film.exr"), path("out/film.exr"));
  EXPECT_TRUE(process["convention"]["process_rgb"].get<bool>());
  ASSERT_EQ(
      reseau({"reconstruct", path("film.tif"), "-o", dir / "xyz", "--space", "xyz", "--primaries",
              "neblette-1952", "--balance", "brightness", "--white", "0.9", "--no-view"})
          .exit_code,
      0);
  const auto xyz = compare(path("film.exr"), dir / "xyz/film.exr");
  EXPECT_THAT(xyz["convention"]["colors"].get<std::string>(), HasSubstr("primaries of the result"));
  // The same intensities through other dyes: not the same figure, but one of the same size.
  EXPECT_NEAR(xyz["delta_e_2000"]["median"].get<double>(),
              process["delta_e_2000"]["median"].get<double>(), 1.0);
  const auto other = compare(path("out/film.exr"), dir / "xyz/film.exr");
  EXPECT_GT(mean(other), 2.0) << "seen through its own primaries, each is another picture";
}

TEST_F(CompareE2e, HalfAPixelOfRegistrationIsSeen) {
  const auto clean = compare(path("film.exr"), path("map.exr"));
  EXPECT_LT(rms(clean), 0.05);
  EXPECT_TRUE(clean["warnings"].empty());
  // The réseau itself half a pixel further: as much for every place of the film.
  ASSERT_EQ(simulate("moved", {"--set", "phase_u=0.364"}).exit_code, 0);
  const auto moved = compare(path("moved.exr"), path("map.exr"));
  EXPECT_NEAR(rms(moved), 0.064 * clean["registration"]["period_px"][0].get<double>(), 0.05);
  EXPECT_GT(rms(moved), 0.4);
  EXPECT_FALSE(moved["warnings"].empty());
}

TEST_F(CompareE2e, HalfAPixelOfThePictureIsSeen) {
  const FloatImage exact = read_exr(path("out/film.exr"));
  FloatImage moved = exact;
  for (std::size_t i = 0; i + 3 < moved.samples.size(); ++i) {
    moved.samples[i] = 0.5F * (exact.samples[i] + exact.samples[i + 3]);
  }
  const auto clean = compare(written(exact, "same.exr"), dir / "same.exr");
  EXPECT_EQ(clean["shift"]["x_px"], 0.0);
  EXPECT_TRUE(clean["warnings"].empty());
  const auto shifted = compare(dir / "same.exr", written(moved, "moved.exr"));
  EXPECT_NEAR(shifted["shift"]["x_px"].get<double>(), -0.5, 0.1);
  EXPECT_GT(mean(shifted), 0.05);
  EXPECT_FALSE(shifted["warnings"].empty());
}

TEST_F(CompareE2e, TheWrongOrderOfElementsIsSeen) {
  EXPECT_LT(rms(compare(path("film.exr"), path("map.exr"))), 0.05);
  // Green taken for blue.
  const auto half =
      compare(path("film.exr"), changed_map("half.exr", [](float& u, float&) { u += 0.5F; }));
  EXPECT_GT(rms(half), 3.0);
  const auto whole = compare(
      path("film.exr"), changed_map("whole.exr", [](float& u, float& v) { u = 3 - u, v += 2; }));
  EXPECT_LT(rms(whole), 0.05) << "another origin and direction are no mistake";
  // Red and blue exchanged in the picture.
  FloatImage picture = read_exr(path("film.exr"));
  const double clean = mean(compare(path("film.exr"), path("out/film.exr")));
  const auto plain = compare(written(picture, "plain.exr"), dir / "plain.exr");
  EXPECT_EQ(mean(plain), 0);
  for (std::size_t i = 0; i < picture.samples.size(); i += 3) {
    std::swap(picture.samples[i], picture.samples[i + 2]);
  }
  EXPECT_GT(mean(compare(dir / "plain.exr", written(picture, "exchanged.exr"))), 2 * clean);
}

TEST_F(CompareE2e, ATransposedAxisIsSeen) {
  const auto exchanged = compare(
      path("film.exr"), changed_map("swapped.exr", [](float& u, float& v) { std::swap(u, v); }));
  EXPECT_TRUE(exchanged["registration"]["equivalence"]["axes_exchanged"].get<bool>());
  EXPECT_THAT(exchanged["warnings"].dump(), HasSubstr("exchanged"));
  // Rows for columns in the map of a square part.
  FloatImage map = read_exr(path("map.exr"), {"u", "v"});
  const FloatImage exact = map;
  for (std::size_t y = 0; y < 280; ++y) {
    for (std::size_t x = 0; x < 280; ++x) {
      for (std::size_t k = 0; k < 2; ++k) {
        map.samples[2 * (y * 300 + x) + k] = exact.samples[2 * (x * 300 + y) + k];
      }
    }
  }
  const std::vector<std::string> square{"--crop", "0,0,280,280"};
  EXPECT_LT(rms(compare(path("film.exr"), path("map.exr"), square)), 0.05);
  const auto transposed = compare(path("film.exr"), written(map, "transposed.exr"), square);
  EXPECT_GT(rms(transposed), 0.5);
  EXPECT_THAT(transposed["warnings"].dump(), HasSubstr("not describe the same lattice"));
}

TEST_F(CompareE2e, OnePercentOfAreaIsSeenAndOtherNoiseIsNot) {
  // The two scans of the control differ in their noise alone.
  const std::vector<std::string> even{"--scene", "chart24", "--noise", "0.002"};
  const auto scan = [&](const char* name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"simulate", "--width",  "300",   "--height",         "280",
                                       "-o",       path(name), "--set", "red_fraction=0.42"};
    arguments.insert(arguments.end(), even.begin(), even.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(reseau(arguments).exit_code, 0);
    return path(name);
  };
  const std::string plain = scan("plain.tif", {"--seed", "1"});
  const std::string noise = scan("noise.tif", {"--seed", "2"});
  const std::string wider = scan("wider.tif", {"--seed", "2", "--set", "red_fraction=0.4242"});
  const auto z = [](const nlohmann::json& json) {
    const auto& d = json["mean_difference_lab"];
    return std::abs(d["a"].get<double>()) / d["sd"]["a"].get<double>();
  };
  const auto clean = compare(plain, noise), wrong = compare(plain, wider);
  EXPECT_LT(z(clean), 4);
  EXPECT_GT(z(wrong), 10);
  EXPECT_GT(mean(wrong), 1.1 * mean(clean));
}

TEST_F(CompareE2e, TheFileIsWhatTheWireGives) {
  const std::string device = "sim:ls5000?width_px=200&height_px=120&noise=0&seed=5&angle=31";
  // The white-balance exposures of the unit: bare light at the level that a file has.
  ASSERT_EQ(reseau({"scan", "-d", device, "-o", dir / "wire.tif", "--no-reconstruct", "-x", "1mm",
                    "-y", "0.6mm", "--red-exposure", "579.80us", "--green-exposure", "483.56us",
                    "--blue-exposure", "328.54us", "--infrared-exposure", "3290.50us"})
                .exit_code,
            0);
  ASSERT_EQ(reseau({"simulate", device, "-o", dir / "file.tif"}).exit_code, 0);
  ASSERT_EQ(reseau({"simulate", device, "-o", dir / "other.tif", "--angle", "31.5"}).exit_code, 0);
  const Pixels wire = read_pixels(dir / "wire.tif"), file = read_pixels(dir / "file.tif");
  const Pixels other = read_pixels(dir / "other.tif");
  ASSERT_GT(wire.width_px, 100);
  ASSERT_LE(wire.width_px, file.width_px);
  long long different = 0, control = 0;
  for (int y = 0; y < wire.height_px; ++y) {
    for (int i = 0; i < wire.width_px * 4; ++i) {
      const auto a = wire.samples[static_cast<std::size_t>(y * wire.width_px * 4 + i)];
      const auto at = static_cast<std::size_t>(y * file.width_px * 4 + i);
      different += a != file.samples[at] ? 1 : 0;
      control += a != other.samples[at] ? 1 : 0;
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(control, 1000);
}

TEST_F(CompareE2e, TheTruthFilesAgreeWithEachOther) {
  const auto json = nlohmann::json::parse(file_bytes(path("film.json")));
  EXPECT_EQ(json["schema"], "reseau-truth/1");
  EXPECT_EQ(json["seed"], 1);
  EXPECT_EQ(json["film"]["width_px"], kWidth);
  EXPECT_EQ(json["files"]["elements"], "film.elements.exr");
  EXPECT_GT(json["noise_model"]["per_signal"].get<double>(), 0);
  // Light that reaches a pixel: the spread functions hold all of it but their tails.
  const FloatImage psf = read_exr(path("film.psf.exr"), {"R", "G", "B", "IR"});
  const int side = json["psf"]["side"];
  ASSERT_EQ(psf.width_px, 3 * side);
  double light = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      light += double{psf.samples[static_cast<std::size_t>(4 * (y * psf.width_px + x))]};
    }
  }
  EXPECT_NEAR(light / std::pow(json["psf"]["samples_per_px"].get<double>(), 2), 1, 0.01);
  // Where a green element lies the map is at whole periods, and the picture has its intensity.
  const FloatImage map = read_exr(path("film.exr"), {"R", "G", "B", "u", "v"});
  const FloatImage elements = read_exr(path("film.elements.exr"), {"R", "G", "B", "x", "y"});
  int inside = 0;
  for (int j = 0; j < elements.height_px; ++j) {
    for (int i = 0; i < elements.width_px; ++i) {
      const float* e = &elements.samples[static_cast<std::size_t>(5 * (j * elements.width_px + i))];
      if (!(e[3] > 20 && e[3] < kWidth - 20 && e[4] > 20 && e[4] < kHeight - 20)) continue;
      ++inside;
      const auto x = std::lround(e[3]), y = std::lround(e[4]);
      const float* p = &map.samples[static_cast<std::size_t>(5 * (y * kWidth + x))];
      EXPECT_NEAR(p[3], json["elements"]["first_u"].get<int>() + i, 0.1);
      EXPECT_NEAR(p[4], json["elements"]["first_v"].get<int>() + j, 0.1);
      EXPECT_NEAR(e[1], p[1], 0.35);
    }
  }
  EXPECT_NEAR(inside, (kWidth - 40.0) * (kHeight - 40.0) / 61, 60);
}

TEST_F(CompareE2e, SimulateRefusesWhatItCannotUse) {
  const auto simulate_to = [this](std::vector<std::string> more) {
    std::vector<std::string> arguments{"simulate", "-o", dir / "x.tif"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return reseau(arguments).exit_code;
  };
  EXPECT_EQ(simulate_to({"--set", "nonsense=1"}), 64);
  EXPECT_EQ(simulate_to({"--set", "angle"}), 64);
  EXPECT_EQ(simulate_to({"--width", "many"}), 64);
  EXPECT_EQ(simulate_to({"--scene", "no-such-scene"}), 64);
  EXPECT_EQ(simulate_to({"--truth", dir / "truth.json"}), 64);
  write_bytes(dir / "taken.json", "mine");
  EXPECT_EQ(simulate_to({"--truth", dir / "taken.exr"}), 74);
  EXPECT_FALSE(std::filesystem::exists(dir / "x.tif"));
  EXPECT_EQ(reseau({"compare", path("film.exr"), path("film.exr"), "--crop", "1,2,3"}).exit_code,
            64);
  EXPECT_EQ(reseau({"compare", path("film.exr"), path("film.exr"), "--fit", "much"}).exit_code, 64);
  EXPECT_EQ(
      reseau({"compare", path("film.exr"), path("film.exr"), "--map", dir / "e.jpg"}).exit_code,
      64);
}

TEST_F(CompareE2e, TheErrorMapIsWrittenOnce) {
  for (const char* name : {"e.svg", "e.png"}) {
    const std::vector<std::string> command{"compare", path("film.exr"), path("out/film.exr"),
                                           "--map", dir / name};
    EXPECT_EQ(reseau(command).exit_code, 0);
    EXPECT_GT(std::filesystem::file_size(dir / name), 1000U);
    EXPECT_EQ(reseau(command).exit_code, 74);
  }
}

}  // namespace
}  // namespace reseau::testing
