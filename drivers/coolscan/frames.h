// Where the frames lie: data types 8E, 8F and 88, page C8, and the arithmetic between film
// addresses and perforations. Source: LS-5000 and LS-9000 interface specifications; recorded Nikon
// Scan session. Pure, reentrant.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::coolscan {

// A place of a strip in the unit's own counts: perforation, then 22 * pattern + pulse pulses past
// it. A perforation is 108 pulses, a pulse is 7 address units at 4000 dpi and 5 at 2900 dpi.
struct FilmCount {
  int perforation = 0, pattern = 0, pulse = 0;
  bool operator==(const FilmCount&) const = default;
};
[[nodiscard]] int units_per_pulse(int max_dpi);
[[nodiscard]] int address_of(const FilmCount& count, int max_dpi);
// The count at or before an address; addresses below 0 count as 0.
[[nodiscard]] FilmCount count_at(int address_px, int max_dpi);

// One record of data type 8F: SET WINDOW finds the frame by the address, the count is what moves
// the film.
struct FrameRecord {
  int address_px = 0;
  FilmCount count;
  bool operator==(const FrameRecord&) const = default;
};

inline constexpr std::size_t kMaxFrames = 40;

// `data` with its 6-byte head; what does not fit is left out.
[[nodiscard]] std::vector<FrameRecord> parse_frame_table(ByteView data);
// Without head, as SEND takes it. 1 to kMaxFrames records.
[[nodiscard]] Bytes frame_table_data(const std::vector<FrameRecord>& frames);
// The record moved along the film, to the nearest pulse, address and count together.
[[nodiscard]] FrameRecord moved(const FrameRecord& frame, int by_px, int max_dpi);

// Data type 8E with its 6-byte head: where the film stood at each thumbnail line [address]. Absent
// when it is empty or does not rise, which some units answer. The list ends with the perforations.
[[nodiscard]] std::optional<std::vector<int>> parse_perforations(ByteView data, int max_dpi);

// A frame of a holder, in optical pixels. height 0: not measured.
struct FrameRectangle {
  int left_px = 0, top_px = 0, width_px = 0, height_px = 0;
  bool operator==(const FrameRectangle&) const = default;
};
// Page C8.
[[nodiscard]] std::vector<FrameRectangle> parse_frame_page(ByteView page);
// Data of SEND 88: top, left, bottom, right, inclusive.
[[nodiscard]] Bytes frame_rectangle_data(const std::vector<FrameRectangle>& frames);

}  // namespace reseau::coolscan
