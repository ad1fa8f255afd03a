#include "core/line/memory_line_source.h"

#include <gtest/gtest.h>

namespace reseau {
namespace {

TEST(MemoryLineSource, ReadsWholeLinesInCanonicalLayout) {
  LineFormat format;
  format.width_px = 2;
  format.n_lines = 2;
  format.channels = {Channel::kRed, Channel::kInfrared};
  const MemoryLineSource source(format, {1, 2, 3, 4, 5, 6, 7, 8});
  std::vector<std::uint16_t> line(4);
  source.read(1, 1, line);
  EXPECT_EQ(line, (std::vector<std::uint16_t>{5, 6, 7, 8}));
  EXPECT_EQ(source.wait_committed(2, {}), 2);
}

}  // namespace
}  // namespace reseau
