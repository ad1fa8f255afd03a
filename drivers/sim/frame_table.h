// Where the frames of a strip are: data types 8E (perforations), 8F (frames) and 88 (rectangles),
// and how the table steers the film. Source: LS-5000 interface specification, strip film; recorded
// Nikon Scan session.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/sim/sense.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

struct FrameRecord {
  std::uint32_t address = 0;  // top of the frame
  std::uint32_t perforation = 0, pattern = 0, pulse = 0;

  // Where these three counts put the film: 108 pulses to a perforation.
  [[nodiscard]] std::uint32_t film_position(std::uint32_t pulse_px) const {
    return pulse_px * (108 * perforation + pulse + 22 * pattern);
  }
};

class FrameTable {
 public:
  // As before any thumbnail: capacity frames at the nominal pitch, 8 perforations each.
  FrameTable(const UnitModel& model, int capacity, std::uint32_t frame_height);

  // Replies with the six-byte header of the data type.
  [[nodiscard]] Bytes frames_reply() const;
  // swapped: the quirk that the first two header bytes change places unless 9 bytes are asked for.
  [[nodiscard]] Bytes perforations_reply(bool swapped) const;
  // Data of SEND 8F.
  [[nodiscard]] Sense set_frames(ByteView data);
  // Data of SEND 88, rectangles of frames, and what READ 88 gives back. On strip film they are kept
  // and steer nothing.
  [[nodiscard]] Sense set_rectangles(ByteView data);
  [[nodiscard]] Bytes rectangles_reply() const;
  // A thumbnail of n_lines was taken of a film that is film_length units long.
  void index(int n_lines, std::uint32_t film_length);

  [[nodiscard]] bool contains(std::uint32_t address) const;
  // Where the film stands when a window begins at this address: a table sent by the host moves it
  // by its perforation counts, the table of power on does not.
  [[nodiscard]] std::uint32_t film_position(std::uint32_t address) const;

 private:
  [[nodiscard]] std::optional<FrameRecord> frame_of(std::uint32_t address) const;
  std::vector<FrameRecord> frames_;
  Bytes rectangles_;  // empty: none were sent
  int capacity_;
  std::uint32_t height_, pulse_px_, step_px_;
  bool from_host_ = false;
  std::vector<std::uint32_t> line_positions_;  // one per counted thumbnail line
};

}  // namespace reseau::sim
