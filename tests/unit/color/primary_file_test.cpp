#include "core/color/primary_file.h"

#include <functional>

#include <gmock/gmock.h>

#include "core/base/error.h"

namespace reseau {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<PrimarySet> parse(const std::string& text) {
  return parse_primary_sets(text, "my.csv", TableOrigin::kOwn);
}

std::string complaint(const std::string& text) {
  try {
    (void)parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string notes_of(const std::string& text) {
  const PrimarySet set = parse(text).at(0);
  std::string all;
  for (const std::string& note : set.notes) all += note + "\n";
  return all;
}

// A good table; `edit` may change or drop a row (empty text drops it).
using Edit = std::function<std::string(int element, int wavelength_nm, std::string row)>;
std::string spectra(const Edit& edit, const std::string& header = "transmittance_percent",
                    double scale = 1) {
  std::string text = "element,wavelength_nm," + header + "\n";
  const char* const names[] = {"red", "green", "blue"};
  for (int k = 0; k < 3; ++k) {
    for (int nm = 390; nm <= 710; nm += 10) {
      const double percent = 5 + (nm > 620 - 100 * k && nm < 720 - 100 * k ? 70 : 0);
      std::string row =
          std::string(names[k]) + "," + std::to_string(nm) + "," + std::to_string(percent * scale);
      row = edit(k, nm, row);
      if (!row.empty()) text += row + "\n";
    }
  }
  return text;
}
std::string same(int /*element*/, int /*nm*/, std::string row) { return row; }

Matrix3 colors(const std::string& text) { return element_xyz(parse(text).at(0), Viewing{}); }

TEST(PrimaryFile, ReadsAGoodTableWithoutAWord) {
  const PrimarySet set = parse(spectra(same)).at(0);
  EXPECT_EQ(set.name, "my.csv");
  EXPECT_TRUE(set.notes.empty());
  ASSERT_TRUE(set.charts.has_value());
  EXPECT_EQ(set.charts->points[1].size(), 33u);
}

TEST(PrimaryFile, UnitsAndLayoutsOfOneTableMeanTheSame) {
  const Matrix3 percent = colors(spectra(same));
  const Matrix3 fraction = colors(spectra(same, "transmittance_fraction", 0.01));
  const Matrix3 unsaid = colors(spectra(same, "transmittance", 0.01));
  std::string wide = "wavelength_nm;red;green;blue\r\n";
  for (int nm = 710; nm >= 390; nm -= 10) {
    wide += std::to_string(nm);
    for (int k = 0; k < 3; ++k) {
      wide += nm > 620 - 100 * k && nm < 720 - 100 * k ? ";75,0" : ";5,0";
    }
    wide += "\r\n";
  }
  const Matrix3 turned = colors(wide);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(fraction[i], percent[i], 1e-6);
    EXPECT_NEAR(unsaid[i], percent[i], 1e-6);
    EXPECT_NEAR(turned[i], percent[i], 1e-12);
  }
  EXPECT_THAT(notes_of(wide), HasSubstr("Commas in numbers"));
  EXPECT_THAT(notes_of(wide), HasSubstr("read from its end"));
  EXPECT_THAT(notes_of(wide), HasSubstr("percent"));
  EXPECT_THAT(notes_of(spectra(same, "transmittance", 0.01)), HasSubstr("fractions"));
}

TEST(PrimaryFile, ADensityIsThePowerOfTen) {
  const PrimarySet set = parse(spectra(same, "optical_density", 0.01)).at(0);
  const Spectrum t = element_transmittance(set, 0, {400, 10, 2}, {});
  EXPECT_NEAR(t.values[0], std::pow(10, -0.05), 1e-12);
}

TEST(PrimaryFile, RefusesWhatCannotBeMeant) {
  const struct {
    const char* what;
    std::string text, says;
  } cases[] = {
      {"unsorted", spectra([](int, int nm, std::string row) {
         return nm == 500 ? row.replace(row.find("500"), 3, "555") : row;
       }),
       "must rise"},
      {"twice",
       spectra([](int, int nm, std::string row) { return nm == 500 ? row + "\n" + row : row; }),
       "there twice"},
      {"negative", spectra([](int k, int nm, std::string row) {
         return k == 2 && nm == 500 ? "blue,500,-7" : row;
       }),
       "negative value at 500 nm"},
      {"too much", spectra([](int k, int nm, std::string row) {
         return k == 2 && nm == 500 ? "blue,500,130" : row;
       }),
       "more than all light"},
      {"no number", spectra([](int k, int nm, std::string row) {
         return k == 2 && nm == 500 ? "blue,500,n/a" : row;
       }),
       "'n/a' is no number"},
      {"NaN", spectra([](int k, int nm, std::string row) {
         return k == 2 && nm == 500 ? "blue,500,NaN" : row;
       }),
       "'NaN' is no number"},
      {"missing ends", spectra([](int, int nm, std::string row) { return nm < 450 ? "" : row; }),
       "covers only 450 nm"},
      {"wide gap",
       spectra([](int, int nm, std::string row) { return nm > 420 && nm < 690 ? "" : row; }),
       "gap is too wide"},
      {"percent as fraction", spectra(same, "transmittance_fraction"), "percent"},
      {"percent as density", spectra(same, "optical_density"), "percent"},
      {"unit unclear", spectra(same, "transmittance", 0.02), "does not say its unit"},
      {"element missing", spectra([](int k, int, std::string row) { return k == 1 ? "" : row; }),
       "no rows for green"},
      {"strange element",
       spectra([](int, int nm, std::string row) { return nm == 500 ? "cyan,500,3" : row; }),
       "'cyan' is no element"},
      {"micrometres", "wavelength_nm,red,green,blue\n0.4,1,2,3\n0.7,3,2,50\n", "micrometres"},
      {"angstroms", "wavelength_nm,red,green,blue\n4000,1,2,3\n7000,3,2,50\n", "ångströms"},
      {"no header", "400,1,2,3\n410,1,2,3\n", "header line"},
      {"column missing", "wavelength_nm,red,green\n400,1,2\n", "no column for blue"},
      {"decimal commas", "wavelength_nm,red,green,blue\n400,5,1,0,2,0,3,0\n", "semicolons"},
      {"an empty field", spectra([](int k, int nm, std::string row) {
         return k == 2 && nm == 500 ? "blue,500," : row;
       }),
       "there is no number for"},
      {"two units", "wavelength_nm,red_percent,green_fraction,blue\n400,1,2,3\n700,3,2,50\n",
       "different units"},
      {"one reading", "wavelength_nm,red,green,blue\n400,1,2,30\n", "one reading"},
      {"empty", "", "empty"},
  };
  for (const auto& each : cases)
    EXPECT_THAT(complaint(each.text), HasSubstr(each.says)) << each.what;
}

TEST(PrimaryFile, SaysWhatItMakesUp) {
  EXPECT_THAT(notes_of(spectra([](int k, int nm, std::string row) {
                return k == 0 && nm > 450 && nm < 500 ? "" : row;
              })),
              HasSubstr("Between 450 nm and 500 nm the spectrum of red has no reading"));
  EXPECT_THAT(notes_of(spectra([](int, int nm, std::string row) { return nm < 410 ? "" : row; })),
              HasSubstr("410 nm to 710 nm"));
  EXPECT_THAT(notes_of(spectra([](int k, int nm, std::string row) {
                return k == 0 && nm == 450 ? "red,450,-0.5" : row;
              })),
              HasSubstr("slightly below 0"));
  EXPECT_THAT(notes_of(spectra(same, "transmittance_percent", 0.01)),
              HasSubstr("taken as percent, and nowhere exceeds 1"));
}

constexpr const char* kColors =
    "element,x,y,Y,illuminant\nred,0.633,0.365,0.177,C\ngreen,0.233,0.647,0.43,C\n"
    "blue,0.164,0.089,0.087,C\n";

TEST(PrimaryFile, ColorsAreThoseOfTheBuiltInSet) {
  const Matrix3 own = colors(kColors);
  EXPECT_EQ(own, element_xyz(find_primary_set("hubicka-2025"), Viewing{}));
  EXPECT_TRUE(parse(kColors).at(0).notes.empty());
  const std::string percent =
      "colour;x;y;Y;white\nred;0,633;0,365;17,7;C\ngreen;0,233;0,647;43;C\nblue;0,164;0,089;8,7;"
      "C\n";
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(colors(percent)[i], own[i], 1e-15);
  EXPECT_THAT(notes_of(percent), HasSubstr("percent"));
}

// A light that is no standard illuminant: the colours of a projector's lamp, say.
TEST(PrimaryFile, ColorsMayBeStatedForAnyLight) {
  std::string text = kColors;
  for (std::size_t at = text.find(",C"); at != std::string::npos; at = text.find(",C", at + 1)) {
    text.replace(at, 2, ",3200K");
  }
  Viewing lamp;
  lamp.light = parse_light("3200K");
  const PrimarySet set = parse(text).at(0);
  EXPECT_EQ(element_xyz(set, lamp), element_xyz_as_stated(set, lamp));
  const Matrix3 seen = element_xyz(set, Viewing{});
  const Matrix3 wanted = multiply(
      bradford_target_from_source(white_of(lamp.light, lamp.step), white_of(Illuminant::kD65)),
      element_xyz_as_stated(set, lamp));
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(seen[i], wanted[i], 1e-15);
}

TEST(PrimaryFile, SaysWhichColorNoLightHas) {
  const std::string odd = "element,x,y\nred,0.64,0.33\ngreen,0.05,0.9\nblue,0.15,0.06\n";
  EXPECT_THAT(notes_of(odd), HasSubstr("Line 3 of the table: no light has the colour"));
  // Every built-in set is one that light can have, as are the colours of two decimals.
  const std::string rounded = "element,x,y\nred,0.73,0.27\ngreen,0.07,0.84\nblue,0.17,0.0001\n";
  EXPECT_THAT(notes_of(rounded), Not(HasSubstr("no light")));
}

TEST(PrimaryFile, ColorsWithoutLuminanceMakeTheWhiteTogether) {
  const std::string text = "element,x,y\nred,0.64,0.33\ngreen,0.3,0.6\nblue,0.15,0.06\n";
  const Xyz sum = multiply(colors(text), Vector3{1, 1, 1});
  const Xyz white = white_of(Illuminant::kD65);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(sum[i], white[i], 1e-12);
  EXPECT_THAT(notes_of(text), HasSubstr("No luminances"));
  EXPECT_THAT(notes_of(text), HasSubstr("No illuminant"));
}

TEST(PrimaryFile, SeveralSetsOfOneTableKeepTheirNames) {
  const auto sets = parse(
      "set,element,x,y,Y,illuminant\na,red,0.6,0.3,0.2,C\nb,red,0.6,0.3,0.2,E\na,green,0.2,0.6,0.4,"
      "C\nb,green,0.2,0.6,0.4,E\na,blue,0.15,0.06,0.05,C\nb,blue,0.15,0.06,0.05,E\n");
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets[0].name, "a");
  EXPECT_EQ(sets[1].stated->light->name, "E");
}

TEST(PrimaryFile, RefusesColorsThatCannotBe) {
  const auto with = [](std::string from, std::string to) {
    std::string text = kColors;
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_THAT(complaint(with("0.647,0.43", "0.847,0.43")), HasSubstr("Line 3"));
  EXPECT_THAT(complaint(with("0.087,C", "0,C")), HasSubstr("luminance"));
  EXPECT_THAT(complaint(with("0.087,C", "0.087,E")), HasSubstr("different illuminants"));
  EXPECT_THAT(complaint(with("0.177,C", "0.177,F11")), HasSubstr("Line 2 of the table: There is"));
  EXPECT_THAT(complaint(with("0.177,C", "1.177,C")), HasSubstr("Y_percent"));
  EXPECT_THAT(complaint(with("0.087,C", ",C")), HasSubstr("some elements only"));
  EXPECT_THAT(complaint(with("blue,", "red,")), HasSubstr("there twice"));
  EXPECT_THAT(complaint(with("\nblue,0.164,0.089,0.087,C", "")), HasSubstr("no row for blue"));
}

// Whatever stands in a file: a set that can be used, or a sentence.
TEST(PrimaryFile, SurvivesEveryBrokenByte) {
  const std::string good = kColors + spectra(same).substr(0, 200);
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const char c : {'\0', ',', ';', '\n', '"', '-', '9', '\xFF'}) {
      std::string broken = good;
      broken[at] = c;
      try {
        for (const PrimarySet& set : parse(broken)) (void)element_xyz(set, Viewing{});
      } catch (const InputError& error) {
        EXPECT_GT(std::string(error.what()).size(), 20u);
      }
    }
  }
}

}  // namespace
}  // namespace reseau
