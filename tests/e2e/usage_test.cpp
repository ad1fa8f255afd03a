// What the program says about itself, and what it refuses before it does anything.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/reseau_run.h"

namespace reseau::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class HelpE2e : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(HelpE2e, BeginsWithTwoExamplesAndEndsWithTheExitCodes) {
  auto arguments = GetParam();
  arguments.push_back("--help");
  const ProcessResult result = reseau(arguments);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, StartsWith("Examples:\n  reseau "));
  EXPECT_THAT(result.out, HasSubstr("\n  reseau "));
  EXPECT_THAT(result.out, AllOf(HasSubstr("Exit codes:"), HasSubstr("  65  "), HasSubstr("  75  "),
                                HasSubstr(" 130  ")));
}

INSTANTIATE_TEST_SUITE_P(
    Verbs, HelpE2e,
    ::testing::Values(std::vector<std::string>{}, std::vector<std::string>{"list"},
                      std::vector<std::string>{"doctor"}, std::vector<std::string>{"scan"},
                      std::vector<std::string>{"reconstruct"}, std::vector<std::string>{"register"},
                      std::vector<std::string>{"compare"}, std::vector<std::string>{"replay"},
                      std::vector<std::string>{"simulate"}, std::vector<std::string>{"colour"},
                      std::vector<std::string>{"colour", "list"},
                      std::vector<std::string>{"colour", "show"},
                      std::vector<std::string>{"colour", "compare"},
                      std::vector<std::string>{"colour", "apply"},
                      std::vector<std::string>{"paper"}));

class UsageE2e : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(UsageE2e, IsSixtyFourWithASentence) {
  const ProcessResult result = reseau(GetParam());
  EXPECT_EQ(result.exit_code, 64) << result.err;
  EXPECT_THAT(result.err, StartsWith("reseau: "));
  EXPECT_EQ(result.out, "");
}

INSTANTIATE_TEST_SUITE_P(
    Wrong, UsageE2e,
    ::testing::Values(
        std::vector<std::string>{}, std::vector<std::string>{"dance"},
        std::vector<std::string>{"scan", "--no-such-option"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--resolution", "many"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--depth", "99"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--infrared=perhaps"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "-x", "-3mm", "-n"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--focus", "210", "--autofocus=yes"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000?nonsense=1", "-n"},
        std::vector<std::string>{"scan", "-d", "sim:brownie", "-n"},
        std::vector<std::string>{"scan", "-d", "perhaps", "-n"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--primaries", "nobodys", "-n"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--space", "cmyk", "-n"},
        std::vector<std::string>{"scan", "-d", "sim:ls5000", "--white", "nan", "-n"},
        std::vector<std::string>{"reconstruct"}, std::vector<std::string>{"compare", "one.exr"},
        std::vector<std::string>{"simulate", "colour=red", "-o", "/nowhere/x.tif"},
        std::vector<std::string>{"colour", "show", "nobodys"}));

TEST(UsageE2eJson, AnErrorIsAnEvent) {
  const ProcessResult result = reseau({"scan", "--no-such-option", "--json"});
  EXPECT_EQ(result.exit_code, 64);
  const auto errors = events_of(json_lines(result.out), "error");
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0]["code"], "usage");
  EXPECT_TRUE(errors[0]["message"].is_string());
  EXPECT_TRUE(errors[0]["try"].is_string());
}

TEST(ListE2e, NamesTheSimulatedUnit) {
  const ProcessResult text = reseau({"list"});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("sim:ls5000"));
  const ProcessResult json = reseau({"list", "--json"});
  const auto object = nlohmann::json::parse(json.out);
  EXPECT_EQ(object["schema"], "reseau-list/1");
  EXPECT_FALSE(object["devices"].empty());
}

TEST(DoctorE2e, LooksAtDevicesAndPlacesAndNamesRemedies) {
  const TempDir dir;
  const ProcessResult result = reseau({"doctor", "-o", dir.path(), "--json"});
  const auto object = nlohmann::json::parse(result.out);
  EXPECT_EQ(object["schema"], "reseau-doctor/1");
  bool place = false;
  for (const auto& finding : object["findings"]) {
    place = place || finding["what"] == "folder for scans";
    if (finding["level"] == "problem") {
      EXPECT_NE(finding["try"], "") << finding;
    }
  }
  EXPECT_TRUE(place);
  EXPECT_EQ(result.exit_code, object["healthy"].get<bool>() ? 0 : 9);
}

TEST(DoctorE2e, AFolderThatIsAFileIsAProblem) {
  const TempDir dir;
  write_bytes(dir / "file", "x");
  const ProcessResult result = reseau({"doctor", "-o", dir / "file"});
  EXPECT_EQ(result.exit_code, 9);
  EXPECT_THAT(result.out, HasSubstr("is no folder"));
}

TEST(TalkE2e, QuietAndJsonAndPipes) {
  const TempDir dir;
  const ProcessResult quiet =
      reseau({"simulate", "width_px=64", "height_px=64", "-o", dir / "a.tif", "--quiet"});
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(quiet.out, (dir / "a.tif").string() + "\n");
  ProcessOptions no_color;
  no_color.environment = {"NO_COLOR=1"};
  const ProcessResult plain =
      reseau({"simulate", "width_px=64", "height_px=64", "-o", dir / "b.tif"}, no_color);
  EXPECT_EQ(plain.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(plain.err.find('\r'), std::string::npos);
}

}  // namespace
}  // namespace reseau::testing
