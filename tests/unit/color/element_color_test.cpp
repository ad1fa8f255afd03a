#include "core/color/element_color.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/unit/color/reference_tables.h"

namespace reseau {
namespace {

constexpr Balance kBalances[] = {Balance::kNone, Balance::kBrightness, Balance::kNeutral,
                                 Balance::kBradford};

const std::vector<std::string> kPaperSets{"cornwell-clyne-1951",
                                          "harrison-horner-1939",
                                          "collins-giles-1952",
                                          "neblette-1952",
                                          "cornwell-clyne-1951-tab1",
                                          "hubicka-2025",
                                          "srgb"};

TEST(OutputSpace, WordsAreRead) {
  EXPECT_EQ(parse_output_space("process"), OutputSpace::kProcess);
  EXPECT_EQ(parse_output_space("xyz"), OutputSpace::kXyz);
  EXPECT_EQ(parse_output_space("srgb-linear"), OutputSpace::kSrgbLinear);
  EXPECT_THROW((void)parse_output_space("srgb"), InputError);
}

// Computed independently from the same tables.
TEST(ColorModel, KnownMatrices) {
  const struct {
    const char* set;
    Balance balance;
    Matrix3 xyz_from_process;
  } cases[] = {
      {"cornwell-clyne-1951-tab1",
       Balance::kBrightness,
       {0.6353932, 0.1974346, 0.0840551, 0.3692984, 0.5744358, 0.0562657, 0.0020883, 0.0999169,
        0.4610843}},
      {"srgb",
       Balance::kNeutral,
       {0.4124086, 0.3575896, 0.1804315, 0.2126482, 0.7151792, 0.0721726, 0.0193317, 0.1191965,
        0.9502724}},
  };
  for (const auto& each : cases) {
    const ColorModel model = make_color_model(each.set, each.balance, OutputSpace::kXyz);
    for (std::size_t i = 0; i < 9; ++i) {
      EXPECT_NEAR(model.xyz_from_process[i], each.xyz_from_process[i], 2e-6) << each.set;
    }
  }
}

TEST(ColorModel, MatricesAgreeWithTheReferenceTable) {
  const auto rows = read_reference_table("matrices_d65.csv");
  int compared = 0;
  for (const CsvRow& row : rows) {
    const ColorModel model =
        make_color_model(row.at("set"), parse_balance(row.at("balance")), OutputSpace::kXyz);
    const auto first = 3 * static_cast<std::size_t>(number(row, "row"));
    EXPECT_NEAR(model.xyz_from_process[first], number(row, "c0"), 2e-6);
    EXPECT_NEAR(model.xyz_from_process[first + 1], number(row, "c1"), 2e-6);
    EXPECT_NEAR(model.xyz_from_process[first + 2], number(row, "c2"), 2e-6);
    ++compared;
  }
  EXPECT_EQ(compared, 7 * 3 * 3);
}

TEST(ColorModel, ClearFilmIsWhiteInEverySpaceWhenNeutral) {
  const Xyz white = white_of(Illuminant::kD65);
  const auto clear = [](OutputSpace space) {
    return multiply(
        make_color_model("cornwell-clyne-1951", Balance::kNeutral, space).output_from_process,
        Vector3{1, 1, 1});
  };
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(clear(OutputSpace::kProcess)[i], 1.0);
    EXPECT_NEAR(clear(OutputSpace::kXyz)[i], white[i], 1e-14);
    EXPECT_NEAR(clear(OutputSpace::kSrgbLinear)[i], 1.0, 1e-13);
  }
}

// A reader that knows only the chromaticities must see the colours that we mean, whatever the
// balance: XYZ up to the exposure that files do not carry.
TEST(ColorModel, ChromaticitiesOfTheFileGiveBackTheColors) {
  const Vector3 pixel{0.7, 0.2, 0.4};
  for (const std::string& set : kPaperSets) {
    for (const Balance balance : kBalances) {
      const ColorModel process = make_color_model(set, balance, OutputSpace::kProcess);
      const Xyz meant = multiply(process.xyz_from_process, pixel);
      const Xyz seen = multiply(xyz_from_rgb(process.chromaticities), pixel);
      const double exposure = process.reseau[1];
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(seen[i] * exposure, meant[i], 1e-12) << set;
      }
      const ColorModel srgb = make_color_model(set, balance, OutputSpace::kSrgbLinear);
      const Xyz from_srgb =
          multiply(xyz_from_rgb(srgb.chromaticities), multiply(srgb.output_from_process, pixel));
      const ColorModel xyz = make_color_model(set, balance, OutputSpace::kXyz);
      const Xyz from_xyz =
          multiply(xyz_from_rgb(xyz.chromaticities), multiply(xyz.output_from_process, pixel));
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(from_srgb[i], meant[i], 3e-4) << set;  // the two roundings of D65
        EXPECT_NEAR(from_xyz[i], meant[i], 1e-12) << set;
      }
    }
  }
}

TEST(ColorModel, WhiteOfTheProcessFileFollowsTheBalance) {
  const auto white = [](Balance balance) {
    return make_color_model("cornwell-clyne-1951", balance, OutputSpace::kProcess)
        .chromaticities.xy[3];
  };
  const Chromaticity d65 = chromaticity_of(white_of(Illuminant::kD65));
  EXPECT_NEAR(white(Balance::kNeutral)[0], d65[0], 1e-14);
  EXPECT_NEAR(white(Balance::kBradford)[1], d65[1], 1e-14);
  // The pink cast of this réseau stays.
  EXPECT_NEAR(white(Balance::kBrightness)[0], 0.33596, 1e-4);
  EXPECT_NEAR(white(Balance::kNone)[1], 0.30325, 1e-4);
}

TEST(ColorModel, IsWellConditionedForEverySetOfThePaper) {
  for (const std::string& set : kPaperSets) {
    for (const Balance balance : kBalances) {
      const ColorModel model = make_color_model(set, balance, OutputSpace::kXyz);
      EXPECT_GT(model.condition, 1.0);
      EXPECT_LT(model.condition, 10.0) << set;
      EXPECT_DOUBLE_EQ(model.condition, condition_number(model.xyz_from_process));
    }
  }
}

TEST(ColorModel, OwnPrimariesAreCheckedBeforeUse) {
  const Matrix3 good = element_primaries("srgb", Illuminant::kD65);
  const auto make = [](const Matrix3& xyz, const Vector3& areas) {
    return make_color_model("own", xyz, areas, Balance::kNeutral, OutputSpace::kXyz);
  };
  EXPECT_EQ(make(good, {1, 1, 1}).primaries, "own");
  // Areas are shares: a common factor does nothing.
  EXPECT_EQ(make(good, {2, 2, 2}).xyz_from_process, make(good, {1, 1, 1}).xyz_from_process);
  EXPECT_THROW((void)make(good, {1, 0, 1}), InputError);
  EXPECT_THROW((void)make(good, {1, std::nan(""), 1}), InputError);
  Matrix3 dark = good;
  dark[4] = -0.1;
  EXPECT_THROW((void)make(dark, {1, 1, 1}), InputError);
  Matrix3 broken = good;
  broken[0] = std::nan("");
  EXPECT_THROW((void)make(broken, {1, 1, 1}), InputError);
  EXPECT_THROW((void)make({1, 1, 1, 1, 1, 1, 1, 1, 1}, {1, 1, 1}), InputError);
}

}  // namespace
}  // namespace reseau
