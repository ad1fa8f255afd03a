#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::pieusb {

inline constexpr std::size_t kTagBytes = 2;

// Index of a line's colour by its tag, two times R, G, B or I; -1 for anything else.
[[nodiscard]] int channel_of_tag(ByteView line);

// Lines of single colours in, rows of all colours out, whatever order the unit sends them in. A
// pass whose first line is blue was read with the carriage coming back: its rows are turned round,
// which takes the whole pass in memory. Thread-bound.
class LineSorter {
 public:
  // Lines of width_px samples of 1 or 2 bytes; n_channels 3 or 4.
  LineSorter(int width_px, int n_rows, int n_channels, int bytes_per_sample);

  [[nodiscard]] std::size_t line_bytes() const { return line_bytes_; }
  // One line with its tag. Throws DeviceError for a colour that was not asked for, for more lines
  // of one colour than there are rows, and when one colour runs far ahead of another.
  void add(ByteView line);
  // Rows that can be taken, in the order of the film.
  [[nodiscard]] int rows_ready() const;
  // The next row, [channel][pixel], full scale 65535; 8-bit samples times 257. rows_ready() > 0.
  [[nodiscard]] std::vector<std::uint16_t> take();
  // Rows not yet taken.
  [[nodiscard]] int rows_left() const { return n_rows_ - taken_; }
  [[nodiscard]] bool bottom_up() const { return bottom_up_; }

 private:
  std::size_t width_;
  int n_rows_, n_channels_, bytes_per_sample_;
  std::size_t line_bytes_;
  bool direction_known_ = false, bottom_up_ = false;
  std::array<int, 4> seen_{};  // lines per colour
  int taken_ = 0;
  std::deque<std::vector<std::uint16_t>> rows_;  // from row taken_ of the wire on
};

}  // namespace reseau::pieusb
