// Cooperation records (data type 87): what a unit asks of the host before it scans.
// Source: LS-5000 interface specification, READ; recorded Nikon Scan session.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::coolscan {

// Types 1 (build the thumbnails), 2 (average the readings), 4 (register the sensor lines).
struct LineRecord {
  int type = 0;
  int line_bytes = 0;  // without padding; type 2 of an LS-5000 gives the pixel count instead
  int n_lines = 0;
  int bits = 0;
  int lines_per_image = 0;
  int readings = 0;
  int registration_gap = 0;
  bool operator==(const LineRecord&) const = default;
};

// Type 6: padding to remove. Bytes around each colour of a line and around all colours of a line,
// lines above and below the image. A field whose flag is not set is 0.
struct PaddingRecord {
  int colour_before_bytes = 0, colour_after_bytes = 0;
  int line_before_bytes = 0, line_after_bytes = 0;
  int top_lines = 0, bottom_lines = 0;
  // Of several readings, after the one that also has infrared: in place of line_after_bytes.
  std::optional<int> infrared_after_bytes;
  bool operator==(const PaddingRecord&) const = default;
};

// Type 7: correct with the CCD curves, which one-line passes do not need.
struct CurveRecord {
  std::vector<int> curve_types;  // red, green, blue, grey, cyan, magenta, yellow, black
  bool operator==(const CurveRecord&) const = default;
};

using CooperationRecord = std::variant<LineRecord, PaddingRecord, CurveRecord>;

// `data` with its 6-byte head. Absent for a type that is not known or a record that is too short.
[[nodiscard]] std::optional<CooperationRecord> parse_cooperation(ByteView data);

}  // namespace reseau::coolscan
