#include "capture/cli/units.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau::cli {
namespace {

TEST(Units, TheUnitMayBeWrittenOrLeftOut) {
  EXPECT_EQ(parse_dpi("--resolution", "4000"), 4000);
  EXPECT_EQ(parse_dpi("--resolution", "4000dpi"), 4000);
  EXPECT_EQ(parse_dpi("--resolution", "4000 dpi"), 4000);
  EXPECT_DOUBLE_EQ(parse_mm("-l", "12.5mm"), 12.5);
  EXPECT_DOUBLE_EQ(parse_mm("-l", "1.25cm"), 12.5);
  EXPECT_DOUBLE_EQ(parse_mm("-l", "0.5in"), 12.7);
  EXPECT_DOUBLE_EQ(parse_mm("-l", "7"), 7);
  EXPECT_DOUBLE_EQ(parse_us("--red-exposure", "800us"), 800);
  EXPECT_DOUBLE_EQ(parse_us("--red-exposure", "1.5ms"), 1500);
  EXPECT_EQ(parse_count("--depth", "14", 1, 16), 14);
}

TEST(Units, WhatCannotBeUnderstoodIsRefusedWithTheOptionsName) {
  for (const char* text :
       {"", "dpi", "4000mm", "-5", "0", "1e9", "nan", "inf", "40.5", "4000dpi2", "0x40"}) {
    try {
      static_cast<void>(parse_dpi("--resolution", text));
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("--resolution")) << text;
    }
  }
  EXPECT_THROW(static_cast<void>(parse_mm("-l", "nanmm")), InputError);
  EXPECT_THROW(static_cast<void>(parse_count("--depth", "17", 1, 16)), InputError);
  EXPECT_THROW(static_cast<void>(parse_count("--depth", "8bit", 1, 16)), InputError);
}

TEST(Units, YesAndNo) {
  EXPECT_TRUE(parse_yes_no("--infrared", "yes"));
  EXPECT_FALSE(parse_yes_no("--infrared", "no"));
  EXPECT_THROW(static_cast<void>(parse_yes_no("--infrared", "perhaps")), InputError);
}

}  // namespace
}  // namespace reseau::cli
