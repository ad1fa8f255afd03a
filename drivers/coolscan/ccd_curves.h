// The lines of a sensor that has several answer the same light a little differently, which shows as
// banding. A unit measures the difference at start-up (data type 91); the host takes it off.
// Source: LS-5000 interface specification, CCD curves; recorded Nikon Scan session.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::coolscan {

// Page E3.
struct CurvePage {
  int n_types = 0, n_points = 0;
  bool operator==(const CurvePage&) const = default;
};
// Absent when the page is missing or says that there are no curves.
[[nodiscard]] std::optional<CurvePage> parse_curve_page(ByteView page);

// The curves of one colour. Immutable.
class CcdCurves {
 public:
  // `data` with its 6-byte head. Absent when it is too short for lines, types and points, or when a
  // curve does not rise.
  [[nodiscard]] static std::optional<CcdCurves> parse(ByteView data, const CurvePage& page,
                                                      int sensor_lines);

  // What the first line would have read where `sensor_line` reads an index: 65536 entries, or none
  // for the first line. Through the common number of a point, straight between points, unchanged
  // below the first, in proportion above the last. type: from a cooperation record of type 7,
  // UNVERIFIED(counted from 0); one that does not exist is the first.
  [[nodiscard]] std::vector<std::uint16_t> table(int sensor_line, int type) const;

 private:
  CcdCurves(int n_types, int n_points) : n_types_(n_types), n_points_(n_points) {}
  [[nodiscard]] const std::uint16_t* curve(int sensor_line, int type) const {
    const int index = (sensor_line * n_types_ + type) * n_points_;
    return points_.data() + static_cast<std::size_t>(index);
  }
  int n_types_, n_points_;
  std::vector<std::uint16_t> points_;  // [line][type][point]
};

// Red, green, blue, infrared; absent where the unit has none.
using CurveSet = std::array<std::optional<CcdCurves>, 4>;

}  // namespace reseau::coolscan
