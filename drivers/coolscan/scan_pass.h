#pragma once

#include <cstdint>
#include <vector>

#include "drivers/coolscan/ccd_curves.h"
#include "drivers/coolscan/record_layout.h"
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
  int sensor_lines = 1;                      // that take part; above 1: multi-line mode
  int gap = 1;                               // delivered lines from one of them to the next
  int crop_left_px = 0, crop_width_px = 0;   // delivered pixels of the un-mirrored line
  int crop_top_lines = 0, crop_n_lines = 0;  // delivered lines of the window
};

// What the link and the unit ask of a reader.
struct PassRules {
  int packet_bytes = 0;       // of the link, 0 without packets
  bool even_colours = true;   // a filling byte in 8-bit lines of odd width
  bool whole_records = true;  // a READ has to end where a record ends
};

// One pass, red, green, blue and infrared together: opened by the constructor, read in whole
// records, never read past its end. If it is destroyed before it is drained, the scan stays open in
// the unit and Unit::abort_open_scan() ends it. Thread-bound; borrows the unit.
class ScanPass {
 public:
  // Sets the windows, runs SCAN and waits until data is there. Throws DeviceError.
  ScanPass(Unit& unit, const PassSpec& spec, const PassRules& rules, const CurveSet& curves);

  // Lines still to come.
  [[nodiscard]] int lines_left() const { return lines_left_; }
  // Writes a READ's worth of lines, [line][colour][pixel], to the front of samples; returns how
  // many, 0 at the end only. samples grows to what is needed and never shrinks. Fewer lines than
  // promised come of a thumbnail whose film ended.
  int read(std::vector<std::uint16_t>& samples);

 private:
  void set_windows(const PassSpec& spec, const std::vector<Colour>& colours);
  [[nodiscard]] static BlockDecoder decoder_for(const PassSpec& spec, const PassRules& rules,
                                                const CurveSet& curves,
                                                const std::vector<CooperationRecord>& records);
  std::vector<CooperationRecord> open(const PassSpec& spec);
  int read_records();

  Unit& unit_;
  PassRules rules_;
  bool is_thumbnail_;
  BlockDecoder decoder_;
  int lines_left_;        // to deliver
  int skip_lines_ = 0;    // of the wire, before the first to deliver
  int records_left_ = 0;  // of the wire
  bool first_read_ = true;
  Bytes buffer_;
};

}  // namespace reseau::coolscan
