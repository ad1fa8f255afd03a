// Lines with tags into rows, and shading, by patterns that encode colour, row and pixel.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/pieusb/line_sorter.h"
#include "drivers/pieusb/shading.h"

namespace reseau::pieusb {
namespace {

constexpr char kTags[] = {'R', 'G', 'B', 'I'};

int sample_of(int channel, int row, int x) { return 1 + channel * 10000 + row * 100 + x; }

Bytes line_of(int channel, int row, int width, int bytes_per_sample = 2) {
  Bytes line = bytes_of({kTags[channel], kTags[channel]});
  for (int x = 0; x < width; ++x) {
    append_le(line, static_cast<std::size_t>(bytes_per_sample),
              static_cast<std::uint64_t>(sample_of(channel, row, x)));
  }
  return line;
}

void expect_row(LineSorter& sorter, int row, int width, int n_channels) {
  ASSERT_GT(sorter.rows_ready(), 0);
  const std::vector<std::uint16_t> samples = sorter.take();
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(width * n_channels));
  for (int c = 0; c < n_channels; ++c) {
    for (int x = 0; x < width; ++x) {
      ASSERT_EQ(samples[static_cast<std::size_t>(c * width + x)], sample_of(c, row, x));
    }
  }
}

TEST(LineSorter, SortsByTagWhateverTheOrder) {
  std::mt19937 random(3);
  for (const int width : {1, 2, 7, 31}) {
    for (const int n_channels : {3, 4}) {
      constexpr int kRows = 40;
      LineSorter sorter(width, kRows, n_channels, 2);
      std::array<int, 4> next{};
      int taken = 0;
      sorter.add(line_of(0, next[0]++, width));
      while (taken < kRows) {
        const auto c = static_cast<int>(random() % static_cast<unsigned>(n_channels));
        if (next[static_cast<std::size_t>(c)] < kRows) {
          sorter.add(line_of(c, next[static_cast<std::size_t>(c)]++, width));
        }
        while (sorter.rows_ready() > 0) expect_row(sorter, taken++, width, n_channels);
      }
      EXPECT_EQ(sorter.rows_left(), 0);
    }
  }
}

TEST(LineSorter, APassThatBeginsWithBlueIsTurnedRound) {
  LineSorter sorter(5, 20, 4, 2);
  for (int row = 19; row >= 0; --row) {
    for (const int c : {2, 3, 1, 0}) {
      EXPECT_EQ(sorter.rows_ready(), 0);
      sorter.add(line_of(c, row, 5));
    }
  }
  EXPECT_TRUE(sorter.bottom_up());
  EXPECT_EQ(sorter.rows_ready(), 20);
  for (int row = 0; row < 20; ++row) expect_row(sorter, row, 5, 4);
}

TEST(LineSorter, EightBitsFillTheScale) {
  LineSorter sorter(3, 1, 3, 1);
  for (const char tag : {'R', 'G', 'B'}) sorter.add(bytes_of({tag, tag, 0, 128, 255}));
  const std::vector<std::uint16_t> row = sorter.take();
  EXPECT_EQ(row[0], 0);
  EXPECT_EQ(row[1], 128 * 257);
  EXPECT_EQ(row[2], 65535);
}

TEST(LineSorter, RefusesWhatIsOutOfStep) {
  LineSorter sorter(2, 2, 3, 2);
  EXPECT_THROW(sorter.add(bytes_of({'R', 'G', 0, 0, 0, 0})), DeviceError);
  EXPECT_THROW(sorter.add(bytes_of({'I', 'I', 0, 0, 0, 0})), DeviceError) << "not asked for";
  sorter.add(line_of(0, 0, 2));
  sorter.add(line_of(0, 1, 2));
  EXPECT_THROW(sorter.add(line_of(0, 2, 2)), DeviceError) << "more lines than rows";
  LineSorter endless(1, 100000, 3, 2);
  EXPECT_THROW(
      {
        for (int row = 0; row < 100000; ++row) endless.add(bytes_of({'R', 'R', 0, 0}));
      },
      DeviceError)
      << "one colour alone must not fill the memory";
}

constexpr int kWidth = 12;

double true_gain(int c, int x) { return 0.7 + 0.02 * x + 0.05 * c; }
double true_dark(int x) { return 150 + 3 * x; }

Bytes calibration(bool dark, bool infrared) {
  Bytes lines;
  for (int pass = dark ? 0 : 1; pass < 2; ++pass) {
    for (int i = 0; i < 9; ++i) {
      for (int c = 0; c < (infrared ? 4 : 3); ++c) {
        Bytes line = bytes_of({kTags[c], kTags[c]});
        for (int x = 0; x < kWidth; ++x) {
          const double value = true_dark(x) + (pass == 0 ? 0 : 47000 * true_gain(c, x));
          append_le(line, 2, static_cast<std::uint64_t>(std::lround(value)));
        }
        lines.insert(lines.end(), line.begin(), line.end());
      }
    }
  }
  return lines;
}

TEST(PieShading, TellsDarkFromLightByLevel) {
  const ShadingReference both = reference_of(calibration(true, false), kWidth);
  EXPECT_EQ(both.n_dark[0], 9);
  EXPECT_EQ(both.n_light[0], 9);
  EXPECT_TRUE(both.light[3].empty());
  const ShadingReference light = reference_of(calibration(false, true), kWidth);
  EXPECT_EQ(light.n_dark[0], 0);
  EXPECT_EQ(light.n_light[3], 9);
}

TEST(PieShading, AnEvenFieldComesOutEven) {
  const std::vector<int> used{1, 2, 3, 5, 7, 8, 9, 11};
  const auto width = static_cast<int>(used.size());
  const Shading shading(reference_of(calibration(true, false), kWidth), used, width);
  for (const double light : {0.0, 0.1, 0.5, 0.9}) {
    std::vector<std::uint16_t> row;
    for (int c = 0; c < 4; ++c) {
      for (const int x : used) {
        row.push_back(static_cast<std::uint16_t>(
            std::lround(true_dark(x) + light * 47000 * true_gain(c, x))));
      }
    }
    const std::vector<std::uint16_t> before = row;
    shading.apply(row, 4);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto first = row.begin() + static_cast<std::ptrdiff_t>(c * used.size());
      const auto [low, high] = std::minmax_element(first, first + width);
      EXPECT_LE(*high - *low, 3) << "light " << light;
    }
    EXPECT_TRUE(std::equal(row.begin() + 3 * width, row.end(), before.begin() + 3 * width))
        << "infrared was not calibrated";
  }
}

TEST(PieShading, FullScaleStaysFullScale) {
  const std::vector<int> used{0, 1, 2};
  const Shading shading(reference_of(calibration(true, false), kWidth), used, 3);
  std::vector<std::uint16_t> row(9, 65535);
  shading.apply(row, 3);
  for (const std::uint16_t v : row) EXPECT_EQ(v, 65535);
}

TEST(PieShading, ADeadColumnTakesItsNeighbours) {
  Bytes lines = calibration(true, false);
  const std::size_t stride = 2 + 2 * kWidth;
  for (std::size_t at = 0; at < lines.size(); at += stride) {
    lines[at + 2 + 2 * 4] = lines[at + 3 + 2 * 4] = std::byte{0};
  }
  std::vector<int> used(kWidth);
  for (int i = 0; i < kWidth; ++i) used[static_cast<std::size_t>(i)] = i;
  const Shading shading(reference_of(lines, kWidth), used, kWidth);
  EXPECT_EQ(shading.n_weak(), 3);
  std::vector<std::uint16_t> row(3 * kWidth, 20000);
  shading.apply(row, 3);
  EXPECT_NEAR(row[4], (row[3] + row[5]) / 2, 400);
}

TEST(PieShading, ALampThatIsOffIsSaid) {
  Bytes dark;
  for (const char tag : {'R', 'G', 'B'}) {
    dark.push_back(std::byte(tag));
    dark.push_back(std::byte(tag));
    for (int x = 0; x < kWidth; ++x) append_le(dark, 2, 170);
  }
  EXPECT_THROW((void)reference_of(dark, kWidth), DeviceError);
  EXPECT_THROW((void)reference_of({}, kWidth), DeviceError);
}

TEST(PieShading, AnyMaskAndAnyWidthWork) {
  std::mt19937 random(11);
  const ShadingReference reference = reference_of(calibration(true, true), kWidth);
  for (int round = 0; round < 500; ++round) {
    std::vector<int> used;
    for (int i = -2; i < kWidth + 2; ++i) {
      if (random() % 2 == 0) used.push_back(i);
    }
    const int width = 1 + static_cast<int>(random() % 40);
    const Shading shading(reference, used, width);
    std::vector<std::uint16_t> row(static_cast<std::size_t>(4 * width), 12345);
    shading.apply(row, 4);
    for (const std::uint16_t v : row) ASSERT_TRUE(v > 5000 && v < 30000);
  }
}

}  // namespace
}  // namespace reseau::pieusb
