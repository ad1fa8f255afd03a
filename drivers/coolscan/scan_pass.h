#pragma once

#include <cstdint>
#include <vector>

#include "drivers/coolscan/line_layout.h"
#include "drivers/coolscan/unit.h"
#include "drivers/coolscan/window.h"
#include "drivers/metering.h"

namespace reseau::coolscan {

// What one pass over the film shall take.
struct PassSpec {
  Window window;  // of every colour; colour and exposure are filled in
  int pitch = 1;  // optical pixels per delivered pixel
  Exposures exposures{};
  bool infrared = true;
  int crop_left_px = 0, crop_width_px = 0;  // delivered pixels of the un-mirrored line
};

// One pass in the one-line mode, red, green, blue and infrared together: opened by the constructor,
// read in whole lines, never read past its end. If it is destroyed before it is drained, the scan
// stays open in the unit and Unit::abort_open_scan() ends it. Thread-bound; borrows the unit.
class ScanPass {
 public:
  // Sets the windows, runs SCAN and waits until data is there. Throws DeviceError.
  ScanPass(Unit& unit, const PassSpec& spec, int max_packet_bytes);

  // Lines still to come.
  [[nodiscard]] int lines_left() const { return lines_left_; }
  // Writes a READ's worth of lines, [line][colour][pixel], to the front of samples; returns how
  // many, 0 at the end only. samples grows to what is needed and never shrinks.
  int read(std::vector<std::uint16_t>& samples);

 private:
  void set_windows(const PassSpec& spec, const std::vector<Colour>& colours);
  void apply(const std::vector<CooperationRecord>& records, int max_packet_bytes);

  Unit& unit_;
  LineLayout layout_;
  int crop_left_px_, crop_width_px_;
  int lines_left_;
  int wire_lines_left_ = 0;  // with padding lines
  int top_lines_left_ = 0;
  bool first_read_ = true;
  Bytes buffer_;
};

}  // namespace reseau::coolscan
