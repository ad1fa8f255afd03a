#include "drivers/coolscan/line_layout.h"

#include <random>

#include <gtest/gtest.h>

namespace reseau::coolscan {
namespace {

int line_bytes(int width_px, int n_colours, int bits, int max_packet_bytes) {
  LineLayout layout{width_px, n_colours, bits, {}};
  layout.padding = computed_padding(width_px, n_colours, bits, max_packet_bytes);
  return layout.line_bytes();
}

// LS-5000 interface specification, image data; recorded sessions of LS-40 and LS-5000.
TEST(LineLayout, FillsWholePackets) {
  EXPECT_EQ(line_bytes(3946, 4, 16, 512), 31744);
  EXPECT_EQ(line_bytes(3946, 4, 14, 512), 31744);
  EXPECT_EQ(line_bytes(3946, 3, 16, 512), 24064);
  EXPECT_EQ(line_bytes(281, 4, 16, 512), 2560);
  EXPECT_EQ(line_bytes(96, 3, 16, 512), 1024);
  EXPECT_EQ(line_bytes(2870, 3, 8, 64), 8640);
  EXPECT_EQ(line_bytes(287, 4, 12, 64), 2304);
  EXPECT_EQ(line_bytes(287 - 1, 3, 12, 64), 1728);
  EXPECT_EQ(line_bytes(64, 4, 16, 512), 512) << "a line of whole packets has no padding";
}

TEST(LineLayout, MakesOdd8BitColoursEven) {
  EXPECT_EQ(computed_padding(2871, 3, 8, 64).colour_before_bytes, 1);
  EXPECT_EQ(computed_padding(2870, 3, 8, 64).colour_before_bytes, 0);
  EXPECT_EQ(computed_padding(2871, 3, 12, 64).colour_before_bytes, 0);
}

TEST(LineLayout, ScalesToFullScaleReversibly) {
  EXPECT_EQ(full_scale_16(0xFF, 8), 0xFFFF);
  EXPECT_EQ(full_scale_16(0x3FFF, 14), 0xFFFF);
  EXPECT_EQ(full_scale_16(0x7FFF, 14), 0xFFFF) << "above full scale";
  for (const int bits : {8, 10, 12, 14, 16}) {
    const std::uint32_t full = (1U << bits) - 1;
    for (std::uint32_t v = 0; v <= full; ++v) {
      const std::uint32_t back = (full_scale_16(v, bits) * full + 32767U) / 65535U;
      ASSERT_EQ(back, v) << bits << " bits";
    }
  }
}

// A pattern that names colour, line and pixel in every sample, garbage in every pad.
TEST(LineLayout, FindsEverySampleAtAnyWidthDepthPaddingAndCrop) {
  std::mt19937 random(20261122);
  const auto pick = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(random);
  };
  for (int round = 0; round < 500; ++round) {
    static constexpr int kBits[] = {8, 12, 14, 16};
    LineLayout layout{pick(1, 97), pick(3, 4), kBits[pick(0, 3)], {}};
    layout.padding = {pick(0, 2), pick(0, 2), pick(0, 9), pick(0, 511), 0, 0};
    const std::uint32_t full = (1U << layout.bits) - 1;
    const int line_number = pick(0, 999);
    const auto sample = [&](int colour, int x) {
      return static_cast<std::uint32_t>(colour * 7919 + line_number * 104729 + x * 31) & full;
    };
    Bytes line;
    const auto garbage = [&](int n) {
      for (int i = 0; i < n; ++i) line.push_back(std::byte(pick(0, 255)));
    };
    garbage(layout.padding.line_before_bytes);
    for (int colour = 0; colour < layout.n_colours; ++colour) {
      garbage(layout.padding.colour_before_bytes);
      for (int i = 0; i < layout.width_px; ++i) {
        const std::uint32_t v = sample(colour, layout.width_px - 1 - i);  // mirrored on the wire
        if (layout.bits > 8) line.push_back(std::byte(v >> 8));
        line.push_back(std::byte(v & 0xFF));
      }
      garbage(layout.padding.colour_after_bytes);
    }
    garbage(layout.padding.line_after_bytes);
    ASSERT_EQ(line.size(), static_cast<std::size_t>(layout.line_bytes()));

    const int left = pick(0, layout.width_px - 1);
    const int width = pick(1, layout.width_px - left);
    std::vector<std::uint16_t> out(static_cast<std::size_t>(layout.n_colours * width));
    decode_line(layout, line, left, width, out);
    for (int colour = 0; colour < layout.n_colours; ++colour) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ(out[static_cast<std::size_t>(colour * width + x)],
                  full_scale_16(sample(colour, left + x), layout.bits))
            << "round " << round << " colour " << colour << " x " << x;
      }
    }
  }
}

}  // namespace
}  // namespace reseau::coolscan
