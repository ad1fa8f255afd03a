// Where there is no réseau, none is found: fifty pictures each of nature, textures, halftones and
// fabrics.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/reconstruct/reconstruct.h"
#include "tests/support/no_screen_pictures.h"

namespace reseau {
namespace {

constexpr int kSide = 320;

void expect_none(test::NoScreen kind, int first, int end) {
  for (int i = first; i < end; ++i) {
    const test::NoScreenPicture picture = test::no_screen_picture(kind, i, kSide);
    const Registration found = register_screen(picture.source, {}, {}, {});
    EXPECT_FALSE(found.found) << picture.name << " was taken for a " << found.screen
                              << ", confidence " << found.confidence << ", explained "
                              << found.explained;
    if (found.found) continue;
    EXPECT_EQ(found.screen, "none") << picture.name;
    EXPECT_FALSE(found.reason.empty()) << picture.name;
    EXPECT_GT(found.none_probability, 0.5) << picture.name;
    EXPECT_LE(found.none_probability + found.runner_up_probability, 1 + 1e-9) << picture.name;
  }
}

TEST(NoScreen, TwoOfEachKind) {
  for (const auto kind : {test::NoScreen::kNature, test::NoScreen::kTexture,
                          test::NoScreen::kHalftone, test::NoScreen::kFabric}) {
    expect_none(kind, 0, 2);
  }
}

TEST(NoScreenSweep, Nature) { expect_none(test::NoScreen::kNature, 2, 52); }
TEST(NoScreenSweep, Textures) { expect_none(test::NoScreen::kTexture, 2, 52); }
TEST(NoScreenSweep, Halftones) { expect_none(test::NoScreen::kHalftone, 2, 52); }
TEST(NoScreenSweep, Fabrics) { expect_none(test::NoScreen::kFabric, 2, 52); }

}  // namespace
}  // namespace reseau
