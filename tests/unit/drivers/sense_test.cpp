#include "drivers/scsi/sense.h"

#include <gtest/gtest.h>

namespace reseau {
namespace {

Sense sense(int key, int asc, int ascq, int tsc = 0) {
  return {static_cast<std::uint8_t>(key), static_cast<std::uint8_t>(asc),
          static_cast<std::uint8_t>(ascq), static_cast<std::uint8_t>(tsc), false};
}

TEST(Sense, NamesTheCodeInBrackets) {
  EXPECT_EQ(sentence_of(sense(2, 0x3A, 0, 1)),
            "No film is in the scanner. Put film in. [02/3A/00:01]");
}

TEST(Sense, TellsTheSlideFeederFromTheMissingFilm) {
  EXPECT_EQ(sentence_of(sense(2, 0x3A, 0, 0)), "The slide feeder is empty. Fill it. [02/3A/00:00]");
}

TEST(Sense, EveryKeyHasASentenceThatEndsAsOne) {
  for (int key = 0; key < 16; ++key) {
    for (const int asc : {0x00, 0x04, 0x2C, 0x3A, 0x53, 0x60, 0x80}) {
      const std::string text = sentence_of(sense(key, asc, 0));
      EXPECT_TRUE(text.starts_with("The ") || text.starts_with("No ") || text.starts_with("A ") ||
                  text.starts_with("Film ") || text.starts_with("Another "))
          << text;
      EXPECT_NE(text.find(". ["), std::string::npos) << text;
    }
  }
}

TEST(Sense, BecomesAnErrorOfTheRightKind) {
  using Kind = DeviceError::Kind;
  EXPECT_EQ(sense_error(sense(2, 0x3A, 0, 1), "x").kind(), Kind::kNoMedium);
  EXPECT_EQ(sense_error(sense(2, 0x04, 1, 1), "x").kind(), Kind::kBusy);
  EXPECT_EQ(sense_error(sense(2, 0x04, 2), "x").kind(), Kind::kHardware);
  EXPECT_EQ(sense_error(sense(4, 0x62, 0), "x").kind(), Kind::kHardware);
  EXPECT_EQ(sense_error(sense(5, 0x24, 0), "x").kind(), Kind::kRefused);
  EXPECT_EQ(sense_error(sense(0xB, 0x4B, 0), "x").kind(), Kind::kHardware);
  EXPECT_EQ(sense_error(sense(2, 0x3A, 0, 1), "TEST UNIT READY").detail(),
            "TEST UNIT READY → 02/3A/00:01");
}

}  // namespace
}  // namespace reseau
