// Scans whose samples are not linear: one film, encoded in several ways, gives one picture.
#include <cmath>
#include <cstddef>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <tiffio.h>

#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"

namespace reseau::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

Pixels encoded(Pixels pixels, double gamma, bool infrared_too) {
  for (std::size_t i = 0; i < pixels.samples.size(); ++i) {
    if (i % 4 == 3 && !infrared_too) continue;
    const double linear = pixels.samples[i] / 65535.0;
    pixels.samples[i] =
        static_cast<std::uint16_t>(std::lround(65535 * std::pow(linear, 1 / gamma)));
  }
  return pixels;
}

void embed(const std::string& tiff_path, const std::string& icc) {
  TIFF* const tiff = TIFFOpen(tiff_path.c_str(), "r+");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_ICCPROFILE, static_cast<std::uint32_t>(icc.size()), icc.data());
  ASSERT_EQ(TIFFRewriteDirectory(tiff), 1);
  TIFFClose(tiff);
}

TEST(EncodedScanE2e, ProfileGammaAndLinearSamplesGiveOnePicture) {
  TempDir dir;
  ASSERT_EQ(
      reseau({"simulate", "width_px=420", "height_px=400", "scene=natural", "-o", dir / "film.tif"})
          .exit_code,
      0);
  const Pixels film = read_pixels(dir / "film.tif");
  ASSERT_EQ(
      reseau({"colour", "profile", "--space", "rec2020", "--curve", "2.2", "-o", dir / "curve.icc"})
          .exit_code,
      0);
  const std::string icc = file_bytes(dir / "curve.icc");
  write_tiff(dir / "linear.tif", film, 16);
  // A profile speaks of red, green and blue; --gamma of all four.
  write_tiff(dir / "profiled.tif", encoded(film, 2.2, false), 16);
  embed(dir / "profiled.tif", icc);
  write_tiff(dir / "gamma.tif", encoded(film, 2.2, true), 16);
  write_tiff(dir / "wrongly.tif", film, 16);
  embed(dir / "wrongly.tif", icc);

  const auto reconstructed = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"reconstruct", dir / (name + ".tif"), "-o",
                                       dir.path().string(), "--no-view"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProcessResult result = reseau(arguments);
    EXPECT_EQ(result.exit_code, 0) << name << result.err;
    return dir / (name + ".exr");
  };
  const auto difference = [&](const std::string& a, const std::string& b) {
    const json compared = json::parse(reseau({"compare", a, b, "--json"}).out);
    return compared["delta_e_2000"]["p95"].get<double>();
  };
  const std::string linear = reconstructed("linear", {});
  // What is left is the rounding of dark samples to 16 bits.
  EXPECT_LT(difference(linear, reconstructed("profiled", {})), 0.05);
  EXPECT_LT(difference(linear, reconstructed("gamma", {"--gamma", "2.2"})), 0.05);
  const std::string overridden = reconstructed("wrongly", {"--gamma", "1"});
  EXPECT_EQ(difference(linear, overridden), 0);
  for (const char* name : {"profiled", "gamma", "wrongly"}) {
    EXPECT_THAT(file_bytes(dir / (std::string(name) + ".json")),
                HasSubstr(name == std::string("profiled") ? "curves of the embedded" : "gamma"))
        << name;
  }
  // Believed, a wrong profile shows.
  ASSERT_EQ(std::filesystem::remove(overridden), true);
  ASSERT_EQ(std::filesystem::remove(dir / "wrongly.json"), true);
  EXPECT_GT(difference(linear, reconstructed("wrongly", {})), 1);
}

}  // namespace
}  // namespace reseau::testing
