#include "core/line/corrected_lines.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"

namespace reseau {
namespace {

constexpr int kWidth = 3, kLines = 2;

MemoryLineSource scan() {
  LineFormat format;
  format.width_px = kWidth;
  format.n_lines = kLines;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  std::vector<std::uint16_t> samples;
  for (int i = 0; i < kWidth * kLines * 4; ++i) {
    samples.push_back(static_cast<std::uint16_t>(1000 + 2000 * i));
  }
  return {format, samples};
}

std::vector<std::uint16_t> all_of(const LineSource& source) {
  std::vector<std::uint16_t> out(source.format().samples_per_line() * kLines);
  source.read(0, kLines, out);
  return out;
}

TEST(CorrectedLines, TakesDarkAndPixelsAway) {
  const MemoryLineSource source = scan();
  LevelCorrection correction;
  EXPECT_TRUE(correction.empty());
  EXPECT_EQ(all_of(CorrectedLines(source, correction)), all_of(source));
  correction.dark_level[1] = 100 / 65535.0;
  correction.flat_gain[1] = {1, 1.5, 0.5};
  correction.dark_level[3] = 0.5;
  const auto raw = all_of(source), now = all_of(CorrectedLines(source, correction));
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const std::size_t plane = i / kWidth % 4, x = i % kWidth;
    double expected = raw[i];
    if (plane == 1) expected = (raw[i] - 100) * correction.flat_gain[1][x];
    if (plane == 3) expected = std::max(0.0, raw[i] - 0.5 * 65535);
    EXPECT_NEAR(now[i], expected, 0.51) << i;
  }
}

TEST(CorrectedLines, GainsOfAnotherLineAreLeftOut) {
  const MemoryLineSource source = scan();
  LevelCorrection correction;
  correction.flat_gain[0] = {2, 2};
  EXPECT_FALSE(correction.fits(kWidth));
  EXPECT_EQ(all_of(CorrectedLines(source, correction)), all_of(source));
}

}  // namespace
}  // namespace reseau
