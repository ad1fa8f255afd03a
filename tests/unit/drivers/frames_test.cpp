#include "drivers/coolscan/frames.h"

#include <gtest/gtest.h>

#include "drivers/coolscan/frame_finder.h"
#include "drivers/coolscan/plan.h"
#include "tests/unit/drivers/units.h"

namespace reseau::coolscan {
namespace {

TEST(Frames, AddressesFollowThePerforations) {
  // Recorded: 756 * perforation + 7 * (pulse + 22 * pattern); of an LS-40 540 and 5.
  EXPECT_EQ(address_of({8, 3, 5}, 4000), 756 * 8 + 7 * (5 + 22 * 3));
  EXPECT_EQ(address_of({8, 3, 5}, 2900), 540 * 8 + 5 * (5 + 22 * 3));
  for (int address = 0; address < 40000; address += 7) {
    const FilmCount count = count_at(address, 4000);
    ASSERT_EQ(address_of(count, 4000), address);
    ASSERT_LT(count.pulse, 22);
    ASSERT_LT(count.pattern * 22 + count.pulse, 108);
  }
}

TEST(Frames, AMovedFrameKeepsAddressAndCountTogether) {
  const FrameRecord frame{5959, {8, 0, 0}};
  for (int step = -20; step <= 20; ++step) {
    const int by_px = static_cast<int>(step * 0.25 * 4000 / 25.4);
    const FrameRecord there = moved(frame, by_px, 4000);
    EXPECT_NEAR(there.address_px, 5959 + by_px, 3.5) << step;
    EXPECT_EQ(address_of(there.count, 4000), there.address_px);
  }
  EXPECT_EQ(moved(frame, -100000, 4000).address_px, 0);
}

TEST(Frames, OnlyTheMovedFrameMovesAndStaysOnTheFilm) {
  UnitDescription unit = ls5000_strip();
  unit.strip = {{0, {0, 0, 0}}, {5959, {8, 0, 0}}, {11918, {16, 0, 0}}};
  ScanRequest request;
  request.frame = 2;
  request.frame_offset_mm = 0.25;
  const ScanPlan plan = negotiate(request, unit).plan;
  EXPECT_NEAR(plan.frame_offset_px, 39.4, 4);
  EXPECT_EQ(plan.y_origin_px, 5959 + plan.frame_offset_px);
  request.frame = 3;
  request.frame_offset_mm = 0;
  EXPECT_EQ(negotiate(request, unit).plan.y_origin_px, 11918);
  request.frame = 1;
  request.frame_offset_mm = -3;
  const Negotiated first = negotiate(request, unit);
  EXPECT_EQ(first.plan.y_origin_px, 0);
  ASSERT_EQ(first.adjusted.size(), 1U);
  EXPECT_EQ(first.adjusted[0].field, "frame offset");
}

TEST(Frames, TheTableGoesBackAsItCame) {
  const std::vector<FrameRecord> frames = {{700, {0, 4, 12}}, {6659, {8, 3, 7}}};
  const Bytes data = frame_table_data(frames);
  ASSERT_EQ(data.size(), 4U + 16U);
  EXPECT_EQ(load_be(data, 0, 2), 8U * 2 + 2);
  Bytes reply = bytes_of({0x8F, 0, 0, 0, 0, 20});
  reply.insert(reply.end(), data.begin(), data.end());
  EXPECT_EQ(parse_frame_table(reply), frames);
  reply.resize(reply.size() - 1);
  EXPECT_EQ(parse_frame_table(reply).size(), 1U) << "what does not fit is left out";
}

TEST(Frames, PerforationsAreReadBehindTheirEightBytes) {
  // The first two bytes of the head are swapped; 4n + 1, then the size of a record.
  Bytes data = bytes_of({0x00, 0x8E, 0,    0, 0, 16, 0,    0, 13, 4,  //
                         0,    0,    0x80, 0, 0, 0,  0x80, 6, 0,  1, 0x01, 2});
  const auto places = parse_perforations(data, 4000);
  ASSERT_TRUE(places);
  EXPECT_EQ(*places, (std::vector<int>{0, 42, 756 + 7 * 24}));
  EXPECT_FALSE(parse_perforations(bytes_of({0x00, 0x8E, 0, 0, 0, 4, 0, 0, 1, 4}), 4000));
  for (std::size_t i = 10; i < data.size(); ++i) data[i] = std::byte{0};
  EXPECT_FALSE(parse_perforations(data, 4000)) << "zeros, as a user saw them";
}

TEST(Frames, RectanglesCountThemselves) {
  const Bytes data = frame_rectangle_data({{518, 2236, 8964, 13176}});
  ASSERT_EQ(data.size(), 20U);
  EXPECT_EQ(load_be(data, 0, 2), 20U);
  EXPECT_EQ(load_be(data, 4, 4), 2236U);
  EXPECT_EQ(load_be(data, 8, 4), 518U);
  EXPECT_EQ(load_be(data, 12, 4), 2236U + 13176 - 1);
  EXPECT_EQ(load_be(data, 16, 4), 518U + 8964 - 1);
}

// A strip of frames whose wind is not the raster's, gaps of three lines.
TEST(Frames, AreFoundWhereTheyAreOnTheFilm) {
  constexpr int kWidth = 96, kLines = 800;
  const std::vector<int> tops = {4, 147, 291, 433, 580};
  std::vector<std::uint16_t> samples(std::size_t{kLines} * 3 * kWidth, 60000);
  for (const int top : tops) {
    for (int line = top; line < top + 136; ++line) {
      for (int i = 0; i < 3 * kWidth; ++i) {
        samples[static_cast<std::size_t>(line * 3 * kWidth + i)] =
            static_cast<std::uint16_t>(3000 + (i * 7919 + line * 131) % 40000);
      }
    }
  }
  const std::vector<FoundFrame> found = find_frames({samples, kWidth, kLines}, 141.9, 5);
  ASSERT_EQ(found.size(), 5U);
  for (std::size_t k = 0; k < tops.size(); ++k) {
    EXPECT_NEAR(found[k].top_line, tops[k], 6) << k;
  }
}

TEST(Frames, WithoutAnyContrastNothingIsClaimed) {
  const std::vector<std::uint16_t> samples(std::size_t{400} * 3 * 96, 30000);
  EXPECT_TRUE(find_frames({samples, 96, 400}, 142, 3).empty());
}

}  // namespace
}  // namespace reseau::coolscan
