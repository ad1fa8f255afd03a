#include "drivers/coolscan/record_layout.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

namespace reseau::coolscan {
namespace {

RecordLayout layout_of(int width_px, int n_colours, int bits, int packet_bytes) {
  RecordLayout layout;
  layout.width_px = width_px;
  layout.n_colours = n_colours;
  layout.bits = bits;
  layout.padding = computed_padding(layout, packet_bytes);
  return layout;
}

std::size_t line_bytes(int width_px, int n_colours, int bits, int packet_bytes) {
  return layout_of(width_px, n_colours, bits, packet_bytes).record_bytes();
}

// LS-5000 interface specification, image data; recorded sessions of LS-40 and LS-5000.
TEST(RecordLayout, FillsWholePackets) {
  EXPECT_EQ(line_bytes(3946, 4, 16, 512), 31744U);
  EXPECT_EQ(line_bytes(3946, 4, 14, 512), 31744U);
  EXPECT_EQ(line_bytes(3946, 3, 16, 512), 24064U);
  EXPECT_EQ(line_bytes(281, 4, 16, 512), 2560U);
  EXPECT_EQ(line_bytes(96, 3, 16, 512), 1024U);
  EXPECT_EQ(line_bytes(2870, 3, 8, 64), 8640U);
  EXPECT_EQ(line_bytes(287, 4, 12, 64), 2304U);
  EXPECT_EQ(line_bytes(287, 3, 12, 64), 1728U);
  EXPECT_EQ(line_bytes(64, 4, 16, 512), 512U) << "a line of whole packets has no padding";
  EXPECT_EQ(line_bytes(3946, 4, 16, 0), 31568U) << "a link without packets has none";
}

TEST(RecordLayout, MakesOdd8BitColoursEven) {
  EXPECT_EQ(layout_of(2871, 3, 8, 64).padding.colour_before_bytes, 1);
  EXPECT_EQ(layout_of(2870, 3, 8, 64).padding.colour_before_bytes, 0);
  EXPECT_EQ(layout_of(2871, 3, 12, 64).padding.colour_before_bytes, 0);
  RecordLayout odd;
  odd.width_px = 2671;
  odd.n_colours = 4;
  odd.bits = 8;
  odd.padding = computed_padding(odd, 0, /*even_colours=*/false);
  EXPECT_EQ(odd.record_bytes(), 4U * 2671U) << "LS-30, LS-2000";
}

TEST(RecordLayout, TwoLinesAndFourReadingsMakeTheRecordedSize) {
  RecordLayout layout;
  layout.width_px = 3946;
  layout.n_colours = 4;
  layout.sensor_lines = 2;
  layout.readings = 4;
  layout.padding = computed_padding(layout, 512);
  EXPECT_EQ(layout.padding.line_after_bytes, 0x0184);
  EXPECT_EQ(layout.padding.infrared_after_bytes, 0x00B0);
  EXPECT_EQ(layout.reading_bytes(0), 63136U + 352U);
  EXPECT_EQ(layout.reading_bytes(3), 47352U + 776U);
  EXPECT_EQ(layout.record_bytes(), 207872U);
}

TEST(RecordLayout, ScalesToFullScaleReversibly) {
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

// Names colour, film line, pixel, reading and sensor line in every sample.
std::uint32_t pattern(int colour, int line, int pixel, int reading, int sensor_line) {
  return static_cast<std::uint32_t>(colour * 7919 + line * 104729 + pixel * 31 + reading * 8 +
                                    sensor_line * 257);
}

// Writes one block as a unit would, from the description of the wire alone; garbage in the pads.
Bytes wire_block(const RecordLayout& l, int first_line, std::mt19937& random) {
  Bytes bytes;
  const auto garbage = [&](int n) {
    for (int i = 0; i < n; ++i) bytes.push_back(std::byte(random() & 0xFF));
  };
  const std::uint32_t full = (1U << l.bits) - 1;
  for (int position = 0; position < l.gap; ++position) {
    for (int reading = 0; reading < l.readings; ++reading) {
      garbage(l.padding.line_before_bytes * l.sensor_lines);
      const bool infrared = l.n_colours == 4 && reading == 0;
      const int n_colours = l.n_colours == 4 && reading > 0 ? 3 : l.n_colours;
      for (int colour = 0; colour < n_colours; ++colour) {
        garbage(l.padding.colour_before_bytes);
        for (int i = l.width_px - 1; i >= 0; --i) {  // mirrored on the wire
          for (int s = 0; s < l.sensor_lines; ++s) {
            const int line = first_line + s * l.gap + position;
            const std::uint32_t v = pattern(colour, line, i, reading, s) & full;
            if (l.bits > 8) bytes.push_back(std::byte(v >> 8));
            bytes.push_back(std::byte(v & 0xFF));
          }
        }
        garbage(l.padding.colour_after_bytes);
      }
      const bool own = infrared && l.readings > 1 && l.padding.infrared_after_bytes.has_value();
      garbage((own ? *l.padding.infrared_after_bytes : l.padding.line_after_bytes) *
              l.sensor_lines);
    }
  }
  return bytes;
}

void expect_found(const RecordLayout& l, int left, int width, std::mt19937& random) {
  const int first_line = static_cast<int>(random() % 1000);
  const Bytes block = wire_block(l, first_line, random);
  ASSERT_EQ(block.size(), l.block_bytes());
  const BlockDecoder decoder(l, left, width);
  std::vector<std::uint16_t> out(decoder.block_samples());
  decoder.decode(block, out);
  const std::uint32_t full = (1U << l.bits) - 1;
  for (int line = 0; line < l.lines_per_block(); ++line) {
    for (int colour = 0; colour < l.n_colours; ++colour) {
      for (int x = 0; x < width; ++x) {
        std::uint32_t sum = 0, n = 0;
        for (int r = 0; r < (colour == 3 ? 1 : l.readings); ++r, ++n) {
          sum += full_scale_16(pattern(colour, first_line + line, left + x, r, line / l.gap) & full,
                               l.bits);
        }
        const auto at = static_cast<std::size_t>((line * l.n_colours + colour) * width + x);
        ASSERT_EQ(out[at], (sum + n / 2) / n)
            << "line " << line << " colour " << colour << " x " << x;
      }
    }
  }
}

TEST(RecordLayout, FindsEverySampleOfAnyMode) {
  std::mt19937 random(20261124);
  const auto pick = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
  };
  for (int round = 0; round < 600; ++round) {
    static constexpr int kBits[] = {8, 10, 12, 14, 16};
    RecordLayout l;
    l.width_px = pick(1, 61);
    l.n_colours = pick(3, 4);
    l.bits = kBits[pick(0, 4)];
    l.sensor_lines = pick(1, 3);
    l.gap = l.sensor_lines == 1 ? 1 : pick(1, 6);
    l.readings = pick(0, 2) == 0 ? pick(2, 16) : 1;
    l.padding = {pick(0, 2), pick(0, 2), pick(0, 9), pick(0, 63), 0, 0, std::nullopt};
    if (l.readings > 1 && pick(0, 1) == 1) l.padding.infrared_after_bytes = pick(0, 63);
    SCOPED_TRACE("round " + std::to_string(round));
    const int left = pick(0, l.width_px - 1);
    expect_found(l, left, pick(1, l.width_px - left), random);
  }
}

TEST(RecordLayout, FindsEverySampleOfTheRecordedSizes) {
  std::mt19937 random(7);
  struct Case {
    int width_px, n_colours, bits, packet_bytes, sensor_lines, gap, readings;
    std::size_t block_bytes;
  };
  for (const Case& c : {Case{3946, 4, 16, 512, 1, 1, 1, 31744},
                        {3946, 3, 14, 512, 1, 1, 1, 24064},
                        {281, 4, 16, 512, 1, 1, 1, 2560},
                        {96, 3, 16, 512, 1, 1, 1, 1024},
                        {2870, 3, 8, 64, 1, 1, 1, 8640},
                        {287, 4, 12, 64, 1, 1, 1, 2304},
                        {3946, 4, 16, 512, 2, 1, 4, 207872},
                        {3946, 4, 16, 512, 2, 1, 1, 63488},
                        {1001, 4, 16, 0, 3, 12, 1, 288288},
                        {500, 4, 16, 0, 3, 6, 2, 126000}}) {
    RecordLayout l;
    l.width_px = c.width_px;
    l.n_colours = c.n_colours;
    l.bits = c.bits;
    l.sensor_lines = c.sensor_lines;
    l.gap = c.gap;
    l.readings = c.readings;
    l.padding = computed_padding(l, c.packet_bytes);
    EXPECT_EQ(l.block_bytes(), c.block_bytes);
    expect_found(l, 0, l.width_px, random);
  }
}

TEST(RecordLayout, CorrectsASensorLineBeforeItAverages) {
  RecordLayout l;
  l.width_px = 1;
  l.n_colours = 3;
  l.sensor_lines = 2;
  l.readings = 2;
  LineTables tables(3, std::vector<std::vector<std::uint16_t>>(2));
  std::vector<std::uint16_t> square(65536);
  for (std::size_t v = 0; v < square.size(); ++v) {
    square[v] = static_cast<std::uint16_t>(v * v / 65535);
  }
  tables[1][1] = square;  // green, second line
  Bytes block;
  for (const int reading : {0, 1}) {
    for (int colour = 0; colour < 3; ++colour) {
      for (int s = 0; s < 2; ++s) {
        const int v = reading == 0 ? 1000 : 3000;
        block.push_back(std::byte(v >> 8));
        block.push_back(std::byte(v & 0xFF));
      }
    }
  }
  std::vector<std::uint16_t> out(6);
  BlockDecoder(l, 0, 1, tables).decode(block, out);
  EXPECT_EQ(out, (std::vector<std::uint16_t>{2000, 2000, 2000, 2000, (15 + 137 + 1) / 2, 2000}));
}

}  // namespace
}  // namespace reseau::coolscan
