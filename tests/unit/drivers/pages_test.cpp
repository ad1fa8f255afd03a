#include "drivers/coolscan/pages.h"

#include <random>

#include <gtest/gtest.h>

#include "drivers/coolscan/ccd_curves.h"
#include "drivers/coolscan/frames.h"
#include "tests/unit/drivers/units.h"

namespace reseau::coolscan {
namespace {

TEST(Pages, AddressesOfAnLs5000WithStripAdapter) {
  const AddressPage a = parse_addresses(from_hex(kC1Ls5000Strip));
  EXPECT_EQ(a.pitch_rule, PitchRule::kOneOrEven);
  EXPECT_EQ(a.max_dpi, 4000);
  EXPECT_EQ(a.min_dpi, 90);
  EXPECT_EQ(a.max_width_px, 3946);
  EXPECT_EQ(a.max_height_px, 5959);
  EXPECT_EQ(a.y_origin_max_px, 42 * 5959);
  EXPECT_EQ(a.x_origin_max_px, a.x_origin_min_px);
  EXPECT_EQ(a.frames_present, 40);
  EXPECT_EQ(a.focus_max, 323);
  EXPECT_EQ(a.converter_bits, 16);
  EXPECT_EQ(a.sensor_lines, 2);
  EXPECT_EQ(a.unread_bytes, 0U) << "every byte of the page has its field";
}

TEST(Pages, AnLs40PageEndsEarlyAndMeansOneLine) {
  const AddressPage a = parse_addresses(from_hex(kC1Ls40));
  EXPECT_EQ(a.max_dpi, 2900);
  EXPECT_EQ(a.max_height_px, 4203);
  EXPECT_EQ(a.converter_bits, 12);
  EXPECT_EQ(a.sensor_pixels, 2870);
  EXPECT_EQ(a.sensor_lines, 0) << "the page ends before it";
}

TEST(Pages, AnExtensionBitMovesEverythingBehindIt) {
  // The transfer rules of page C1 with a second byte.
  Bytes page = from_hex(kC1Ls5000Strip);
  page[3] = std::byte{0x54};
  page[4] = std::byte{0x83};
  page.insert(page.begin() + 5, std::byte{0x00});
  const AddressPage a = parse_addresses(page);
  EXPECT_EQ(a.max_width_px, 3946);
  EXPECT_EQ(a.unread_bytes, 0U);
}

TEST(Pages, NothingIsReadPastTheLengthOfThePage) {
  Bytes page = from_hex(kC1Ls5000Strip);
  page[3] = std::byte{0x24};          // up to the width
  page.resize(255, std::byte{0xFF});  // stale bytes of a transport that pads
  const AddressPage a = parse_addresses(page);
  EXPECT_EQ(a.max_width_px, 3946);
  EXPECT_EQ(a.max_height_px, 0);
  EXPECT_EQ(a.focus_max, 0);
}

TEST(Pages, AbilitiesOfBothModels) {
  const WindowPage ls5000 = parse_window_abilities(from_hex(kD1Ls5000));
  EXPECT_EQ(ls5000.depths_bits(), std::vector<int>{16});
  EXPECT_EQ(ls5000.interleavings, 0x42);
  EXPECT_EQ(ls5000.exposure_max_10ns, 0x03FFFFFFU);
  EXPECT_EQ(ls5000.unread_bytes, 0U);
  const WindowPage ls50 = parse_window_abilities(from_hex(kD1Ls50));
  EXPECT_EQ(ls50.depths_bits(), (std::vector<int>{8, 14}));
  EXPECT_EQ(ls50.interleavings, 0x02);
}

TEST(Pages, DutiesOfBothModels) {
  const DutyPage ls5000 = parse_duties(from_hex(kE1Ls5000));
  EXPECT_TRUE(ls5000.remove_padding);
  EXPECT_FALSE(ls5000.look_up_table);
  EXPECT_TRUE(ls5000.white_balance_exposure);
  EXPECT_TRUE(ls5000.frame_table);
  EXPECT_TRUE(ls5000.offers(0x80));
  EXPECT_TRUE(ls5000.offers(0xA0));
  EXPECT_TRUE(ls5000.offers(0xB4));
  EXPECT_TRUE(ls5000.offers(0xC1));
  EXPECT_TRUE(ls5000.offers(0xD0));
  EXPECT_FALSE(ls5000.offers(0xD1));
  EXPECT_EQ(ls5000.unread_bytes, 0U);
  const DutyPage ls50 = parse_duties(from_hex(kE1Ls50));
  EXPECT_TRUE(ls50.look_up_table);
  EXPECT_EQ(ls50.table_in_bits, 14);
  EXPECT_EQ(ls50.table_out_bits, 14);
}

TEST(Pages, NamesEndAtTheirZero) {
  EXPECT_EQ(parse_name_page(from_hex("06010009 08 33365374 72697000")), "36Strip");
  EXPECT_EQ(parse_name_page(from_hex("06010001 FF")), "");
}

TEST(Pages, AnyBytesAreParsedWithoutHarm) {
  std::mt19937 random(20261122);
  for (int round = 0; round < 20000; ++round) {
    Bytes page(random() % 100);
    for (std::byte& b : page) b = std::byte(random() & 0xFF);
    const AddressPage a = parse_addresses(page);
    EXPECT_GE(a.max_height_px, 0);
    EXPECT_LE(parse_window_abilities(page).depths_bits().size(), 5U);
    (void)parse_duties(page);
    (void)parse_page_list(page);
    (void)parse_name_page(page);
    for (const FrameRecord& frame : parse_frame_table(page)) EXPECT_GE(frame.address_px, 0);
    (void)parse_frame_page(page);
    (void)parse_perforations(page, 4000);
    (void)parse_curve_page(page);
  }
}

}  // namespace
}  // namespace reseau::coolscan
