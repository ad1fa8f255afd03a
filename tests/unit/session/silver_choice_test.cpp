#include "capture/session/silver_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

std::string refusal(const std::string& word) {
  try {
    static_cast<void>(parse_silver_choice(word));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SilverChoice, WordsAndReceiptsAreRead) {
  EXPECT_FALSE(parse_silver_choice("infrared").ignore_infrared);
  EXPECT_TRUE(parse_silver_choice("rgb").ignore_infrared);
  EXPECT_FALSE(parse_silver_choice("rgb").weights.has_value());
  const test::TempDir dir;
  test::write_bytes(dir / "r.json",
                    R"({"reconstruction":{"silver_from_rgb":{"weights":[0.6,0.4,1.1],)"
                    R"("offset":0.002}}})");
  const SilverChoice choice = parse_silver_choice(dir / "r.json");
  ASSERT_TRUE(choice.weights.has_value());
  EXPECT_EQ(choice.weights->weights, (std::array{0.6, 0.4, 1.1}));
  EXPECT_EQ(choice.weights->offset, 0.002);
  EXPECT_EQ(choice.learned_on, "r.json");
}

TEST(SilverChoice, RefusesWhatTellsNoWeights) {
  const test::TempDir dir;
  const auto with = [&dir](const std::string& text) {
    test::write_bytes(dir / "r.json", text);
    return refusal(dir / "r.json");
  };
  for (const char* text :
       {"{", "{}", R"({"reconstruction":null})", R"({"reconstruction":{"silver_from_rgb":null}})",
        R"({"reconstruction":{"silver_from_rgb":{"weights":[1,2]}}})",
        R"({"reconstruction":{"silver_from_rgb":{"weights":[1,2,"x"]}}})",
        R"({"reconstruction":{"silver_from_rgb":{"weights":[1,2,1e9]}}})",
        R"({"reconstruction":{"silver_from_rgb":{"weights":[1,2,3],"offset":"y"}}})"}) {
    EXPECT_THAT(with(text), testing::HasSubstr("tells no weights")) << text;
  }
  EXPECT_THAT(refusal("no-such-word"), testing::HasSubstr("is not understood"));
  EXPECT_THAT(with("hello"), testing::HasSubstr("TIFF"));
}

}  // namespace
}  // namespace reseau
