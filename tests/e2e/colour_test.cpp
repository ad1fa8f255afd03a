// `reseau colour …` and `reseau paper`, and colours of reconstructions, as people run them.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcms2.h>

#include "capture/image/exr_file.h"
#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"

namespace reseau::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

json json_of(const std::vector<std::string>& arguments) {
  const ProcessResult result = reseau(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return json::parse(result.out, nullptr, false);
}

TEST(ColourE2e, ShowGivesTheFiguresOfTheReference) {
  const json set =
      json_of({"colour", "show", "harrison-horner-1939", "--illuminant", "D65", "--json"});
  EXPECT_EQ(set["schema"], "reseau-colour/1");
  const json& green = set["elements"]["green"];
  EXPECT_NEAR(green["x"].get<double>(), 0.2546, 5e-5);
  EXPECT_NEAR(green["y"].get<double>(), 0.5960, 5e-5);
  EXPECT_NEAR(green["Y"].get<double>(), 0.4203, 5e-5);
  EXPECT_GT(green["dominant_wavelength_nm"].get<double>(), 530);
  EXPECT_NEAR(set["reseau"]["x"].get<double>(), 0.3304, 1e-4);
  EXPECT_GT(set["gamut"]["area_of_srgb"].get<double>(), 0.5);
}

TEST(ColourE2e, EveryListedSetCanBeShownAndDrawn) {
  TempDir dir;
  const json list = json_of({"colour", "list", "--json"});
  ASSERT_GE(list["primaries"].size(), 8u);
  // One set of each kind is drawn, all are shown.
  for (const auto& set : list["sets"]) {
    const std::string name = set["name"];
    EXPECT_EQ(reseau({"colour", "show", name}).exit_code, 0) << name;
  }
  for (const char* name : {"neblette-1952", "hubicka-2025"}) {
    ASSERT_EQ(
        reseau({"colour", "show", name, "--svg", dir / (std::string(name) + ".svg")}).exit_code, 0);
    EXPECT_THAT(file_bytes(dir / (std::string(name) + ".svg")), HasSubstr("</svg>"));
  }
}

// Rows of 5 nm from 380 to 780: three bands.
std::string spectra(const char* separator, bool decimal_comma, double scale, const char* line_end) {
  std::string text = std::string("wavelength_nm") + separator + "red" + separator + "green" +
                     separator + "blue" + line_end;
  for (int nm = 380; nm <= 780; nm += 5) {
    const auto band = [&](double middle) {
      std::string v =
          std::to_string(scale * (0.02 + 0.8 * std::exp(-std::pow((nm - middle) / 40, 2))));
      if (decimal_comma) v.replace(v.find('.'), 1, ",");
      return v;
    };
    text += std::to_string(nm) + separator + band(620) + separator + band(540) + separator +
            band(460) + line_end;
  }
  return text;
}

TEST(ColourE2e, OnesOwnSpectraAreASetLikeAnyOther) {
  TempDir dir;
  write_bytes(dir / "plain.csv", spectra(",", false, 1, "\n"));
  write_bytes(dir / "percent.csv", spectra(",", false, 100, "\n"));
  write_bytes(dir / "comma.csv", spectra(";", true, 1, "\r\n"));
  write_bytes(dir / "bom.csv", "\xEF\xBB\xBF" + spectra(",", false, 1, "\r\n"));
  const json plain = json_of({"colour", "show", dir / "plain.csv", "--json"});
  for (const char* name : {"percent.csv", "comma.csv", "bom.csv"}) {
    const json other = json_of({"colour", "show", dir / name, "--json"});
    for (const char* element : {"red", "green", "blue"}) {
      for (const char* key : {"x", "y", "Y"}) {
        EXPECT_NEAR(other["elements"][element][key].get<double>(),
                    plain["elements"][element][key].get<double>(), 1e-6)
            << name;
      }
    }
  }
  EXPECT_EQ(reseau({"colour", "compare", dir / "plain.csv", "neblette-1952"}).exit_code, 0);
}

struct BadTable {
  const char* name;
  std::string text;
};

TEST(ColourE2e, BadTablesAreRefusedWithASentence) {
  TempDir dir;
  const std::string good = spectra(",", false, 1, "\n");
  const auto without = [&good](int from, int to) {
    std::string text;
    for (std::size_t at = 0; at < good.size();) {
      const std::size_t end = good.find('\n', at) + 1;
      const int nm = std::atoi(good.substr(at, 3).c_str());
      if (nm < from || nm > to) text += good.substr(at, end - at);
      at = end;
    }
    return text;
  };
  std::string negative = good, nan = good, text = good;
  negative.replace(negative.find("550,") + 4, 1, "-");
  nan.replace(nan.find("550,") + 4, 8, "nan");
  text.replace(text.find("550,") + 4, 8, "dark");
  const BadTable tables[] = {
      {"empty", ""},
      {"binary", std::string("\x7F"
                             "ELF\0\1\2\3",
                             8)},
      {"header-only", "wavelength_nm,red,green,blue\n"},
      {"one-row", "wavelength_nm,red,green,blue\n500,0.1,0.2,0.3\n"},
      {"twice", good + "550,0.1,0.2,0.3\n"},
      {"gap", without(480, 700)},
      {"no-red-end", without(600, 900)},
      {"no-blue-end", without(0, 480)},
      {"negative", negative},
      {"nan", nan},
      {"text", text},
      {"long-field", "wavelength_nm,red,green,blue\n" + std::string(100000, '9') + ",1,2,3\n"},
      {"mixed-separators", "wavelength_nm,red,green,blue\n400;0,1;0,2;0,3\n"},
      {"micrometres",
       "wavelength_nm,red,green,blue\n0.4,0.1,0.2,0.3\n0.5,0.1,0.2,0.3\n0.7,0.1,0.2,0.3\n"},
      {"two-colours", "wavelength_nm,red,green\n400,0.1,0.2\n700,0.3,0.4\n"},
      {"xy-beyond", "element,x,y\nred,0.7,0.6\ngreen,0.2,0.7\nblue,0.1,0.1\n"},
      {"on-a-line", "element,x,y\nred,0.3,0.3\ngreen,0.4,0.4\nblue,0.2,0.2\n"},
  };
  for (const BadTable& table : tables) {
    const std::string path = dir / (std::string(table.name) + ".csv");
    write_bytes(path, table.text);
    const ProcessResult result = reseau({"colour", "show", path});
    const bool no_colors = table.name == std::string("on-a-line");  // found when they are used
    EXPECT_EQ(result.exit_code, no_colors ? 64 : 65) << table.name;
    EXPECT_THAT(result.err, HasSubstr(".")) << table.name;
    EXPECT_LT(result.err.size(), 600U) << table.name;
    EXPECT_TRUE(result.out.empty()) << table.name << result.out;
  }
  // Falling readings are turned round and used, others that are out of order are refused.
  std::string rows = good.substr(good.find('\n') + 1),
              falling = good.substr(0, good.find('\n') + 1);
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < rows.size(); at = rows.find('\n', at) + 1) {
    lines.push_back(rows.substr(at, rows.find('\n', at) + 1 - at));
  }
  std::reverse(lines.begin(), lines.end());
  std::string unsorted = falling;
  for (const std::string& line : lines) falling += line;
  std::swap(lines[20], lines[40]);
  for (const std::string& line : lines) unsorted += line;
  write_bytes(dir / "falling.csv", falling);
  write_bytes(dir / "unsorted.csv", unsorted);
  const ProcessResult turned = reseau({"colour", "show", dir / "falling.csv"});
  EXPECT_EQ(turned.exit_code, 0) << turned.err;
  const ProcessResult refused = reseau({"colour", "show", dir / "unsorted.csv"});
  EXPECT_EQ(refused.exit_code, 65);
  EXPECT_THAT(refused.err, HasSubstr("sort the table"));
}

TEST(ColourE2e, ProfilesAreTheSameBytesAndReadable) {
  TempDir dir;
  for (const char* space :
       {"process", "xyz", "srgb-linear", "display-p3", "rec2020", "prophoto", "aces-ap0", "film"}) {
    const std::string a = dir / (std::string(space) + "-a.icc"),
                      b = dir / (std::string(space) + "-b.icc");
    ASSERT_EQ(reseau({"colour", "profile", "--space", space, "-o", a}).exit_code, 0) << space;
    ASSERT_EQ(reseau({"colour", "profile", "--space", space, "-o", b}).exit_code, 0) << space;
    EXPECT_TRUE(file_bytes(a) == file_bytes(b)) << space;
    cmsHPROFILE profile = cmsOpenProfileFromFile(a.c_str(), "r");
    ASSERT_NE(profile, nullptr) << space;
    EXPECT_TRUE(cmsIsMatrixShaper(profile)) << space;
    EXPECT_NEAR(cmsGetProfileVersion(profile), 4.3, 0.01);
    cmsCloseProfile(profile);
  }
  EXPECT_EQ(reseau({"colour", "profile", "-o", dir / "xyz-a.icc"}).exit_code, 74);
  EXPECT_NE(reseau({"colour", "profile", "--curve", "cubic", "-o", dir / "new.icc"}).exit_code, 0);
}

// One film, with infrared and without, for the tests below.
class ColourFilmE2e : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempDir;
    ASSERT_EQ(reseau({"simulate", "width_px=420", "height_px=400", "scene=natural", "-o", film()})
                  .exit_code,
              0);
    write_tiff(rgb(), first_channels(read_pixels(film()), 3), 16);
    ASSERT_EQ(reseau({"reconstruct", film(), "-o", *shared_ / "ir", "--no-view"}).exit_code, 0);
  }
  static void TearDownTestSuite() {
    delete shared_;
    shared_ = nullptr;
  }
  static std::string film() { return *shared_ / "film.tif"; }
  static std::string rgb() { return *shared_ / "rgb.tif"; }
  static std::string with_infrared() { return *shared_ / "ir/film.exr"; }

  static json receipt(const std::filesystem::path& path) { return json::parse(file_bytes(path)); }
  double difference(const std::string& picture) const {
    return json_of({"compare", with_infrared(), picture, "--json"})["delta_e_2000"]["mean"]
        .get<double>();
  }

  static TempDir* shared_;
  TempDir dir;
};
TempDir* ColourFilmE2e::shared_ = nullptr;

TEST_F(ColourFilmE2e, SilverFromRgbIsLearnedOnAScanWithInfrared) {
  const json taught = receipt(*shared_ / "ir/film.json")["reconstruction"];
  EXPECT_EQ(taught["silver_from"], "infrared");
  EXPECT_THAT(taught["silver_from_rgb"]["origin"].get<std::string>(), HasSubstr("learned"));
  EXPECT_GT(taught["silver_from_rgb"]["correlation"].get<double>(), 0.9);

  ASSERT_EQ(reseau({"reconstruct", rgb(), "-o", dir / "elements", "--no-view"}).exit_code, 0);
  const json elements = receipt(dir / "elements/rgb.json")["reconstruction"];
  EXPECT_EQ(elements["silver_from"], "rgb");
  EXPECT_EQ(elements["silver_from_rgb"]["origin"], "element classes of this scan");

  // From the receipt, and from the scan itself: the same weights, the same picture.
  ASSERT_EQ(reseau({"reconstruct", rgb(), "-o", dir / "receipt", "--no-view", "--silver-from",
                    *shared_ / "ir/film.json"})
                .exit_code,
            0);
  ASSERT_EQ(reseau({"reconstruct", rgb(), "-o", dir / "scan", "--no-view", "--silver-from", film()})
                .exit_code,
            0);
  const json learned = receipt(dir / "receipt/rgb.json")["reconstruction"]["silver_from_rgb"];
  EXPECT_EQ(learned["origin"], "learned on film.json");
  EXPECT_EQ(learned["weights"], taught["silver_from_rgb"]["weights"]);
  EXPECT_TRUE(read_exr(dir / "receipt/rgb.exr").samples == read_exr(dir / "scan/rgb.exr").samples);

  // Nearer to the picture with infrared than what the elements of the scan alone can tell.
  const double with_learned = difference(dir / "receipt/rgb.exr");
  EXPECT_LT(with_learned, difference(dir / "elements/rgb.exr") + 0.05);
  EXPECT_LT(with_learned, 5);

  // The infrared of a scan can be left aside, and that is the picture of the scan without it.
  ASSERT_EQ(
      reseau({"reconstruct", film(), "-o", dir / "aside", "--no-view", "--silver-from", "rgb"})
          .exit_code,
      0);
  EXPECT_TRUE(read_exr(dir / "aside/film.exr").samples ==
              read_exr(dir / "elements/rgb.exr").samples);
  EXPECT_TRUE(receipt(dir / "aside/film.json")["reconstruction"]["silver_from_rgb"].contains(
      "infrared_of_this_scan"));
}

TEST_F(ColourFilmE2e, ANeutralIsMadeAndRecorded) {
  ASSERT_EQ(reseau({"reconstruct", rgb(), "-o", dir / "n", "--no-view", "--space", "process",
                    "--neutral", "auto"})
                .exit_code,
            0);
  const FloatImage image = read_exr(dir / "n/rgb.exr");
  Vector3 sum{};
  for (std::size_t i = 0; i < image.samples.size(); ++i) sum[i % 3] += double{image.samples[i]};
  EXPECT_NEAR(sum[0] / sum[1], 1, 1e-4);
  EXPECT_NEAR(sum[2] / sum[1], 1, 1e-4);
  const json settings = receipt(dir / "n/rgb.json")["settings"];
  EXPECT_EQ(settings["neutral"], "auto");
  EXPECT_NE(settings["white_balance"][0].get<double>(), 1);
  const ProcessResult outside = reseau(
      {"reconstruct", rgb(), "-o", dir / "outside", "--no-view", "--neutral", "400,390,50,50"});
  EXPECT_NE(outside.exit_code, 0);
  EXPECT_THAT(outside.err, HasSubstr("does not lie within"));
}

TEST_F(ColourFilmE2e, ApplyRepeatsOnlyTheColours) {
  ASSERT_EQ(reseau({"colour", "apply", with_infrared(), "--primaries", "neblette-1952", "--space",
                    "xyz", "-o", dir / "new"})
                .exit_code,
            0);
  ASSERT_EQ(reseau({"reconstruct", film(), "--primaries", "neblette-1952", "--space", "xyz", "-o",
                    dir / "whole", "--no-view"})
                .exit_code,
            0);
  const FloatImage a = read_exr(dir / "new/film.exr"), b = read_exr(dir / "whole/film.exr");
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) ASSERT_NEAR(a.samples[i], b.samples[i], 1e-5);
  const json timings = receipt(dir / "new/film.json")["timings"];
  for (const char* key : {"reading_s", "colour_s", "writing_s", "all_s"}) {
    EXPECT_TRUE(timings[key].is_number()) << key;
  }
  // A second time the names are taken.
  EXPECT_EQ(reseau({"colour", "apply", with_infrared(), "-o", dir / "new"}).exit_code, 74);
  // A scan is no reconstruction.
  const ProcessResult scan = reseau({"colour", "apply", film(), "-o", dir / "scan"});
  EXPECT_NE(scan.exit_code, 0);
  EXPECT_THAT(scan.err, HasSubstr("OpenEXR"));
}

TEST(PaperE2e, WritesTablesAndPlotsAndHolds) {
  TempDir dir;
  const ProcessResult result = reseau({"paper", "-o", dir / "paper"});
  EXPECT_EQ(result.exit_code, 0) << result.out;
  EXPECT_THAT(result.out, Not(HasSubstr("NOT HELD")));
  for (const char* name :
       {"report.txt", "figures.csv", "tab1.csv", "tab2.csv", "tab3.csv", "tab4.csv",
        "chromaticity.svg", "transmittance.svg", "reseau_tab1.png", "reseau_tab2.svg"}) {
    EXPECT_GT(std::filesystem::file_size(dir / "paper" / name), 100u) << name;
  }
  EXPECT_EQ(reseau({"paper", "-o", dir / "paper"}).exit_code, 74);
}

// On the real crop, where it is.
TEST(PaperE2e, TheLimitsHoldOnTheRealCrop) {
  const std::filesystem::path crop =
      std::filesystem::path(RESEAU_SHARED_DIR) / "data/scans/dufaycolor-ls9000-4000dpi-party.tif";
  if (!std::filesystem::exists(crop)) GTEST_SKIP() << "no " << crop;
  TempDir dir;
  const ProcessResult result = reseau({"paper", "--scan", crop, "-o", dir / "paper", "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const json report = json::parse(result.out);
  EXPECT_TRUE(report["held"].get<bool>());
  int n_limits = 0, n_own = 0;
  for (const json& figure : report["figures"]) {
    n_limits += figure["part"] == "scan" && figure["limit"] != "" ? 1 : 0;
    n_own += figure["part"] == "scan-own" ? 1 : 0;
  }
  EXPECT_EQ(n_limits, 13);  // items 7 and 8: 4 + 6 + 3
  EXPECT_GT(n_own, 40);

  // Silver from RGB against the infrared of the same crop: weights and correlation.
  ASSERT_EQ(reseau({"reconstruct", crop, "-o", dir / "rgb", "--no-view", "--silver-from", "rgb"})
                .exit_code,
            0);
  const json silver =
      json::parse(file_bytes(only_file(dir / "rgb", ".json")))["reconstruction"]["silver_from_rgb"];
  EXPECT_GE(silver["infrared_of_this_scan"]["correlation"].get<double>(), 0.98);
}

}  // namespace
}  // namespace reseau::testing
