// Replies of a unit, parsed. Pure. Whatever bytes come: a value or a DeviceError (kProtocol) that
// says what is wrong, never a crash. Multi-byte fields are little-endian.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/bytes.h"
#include "drivers/pieusb/commands.h"
#include "drivers/scsi/sense.h"

namespace reseau::pieusb {

struct Inquiry {
  std::string vendor, product, revision, firmware;
  int model_number = 0;
  int max_dpi = 0;
  int max_width_px = 0, max_height_px = 0;  // at max_dpi; of the scan area where that is smaller
  bool infrared = false, one_pass = false;
  std::vector<int> depths_bits;  // those of whole bytes, ascending
  bool index_format = false;
  bool confirms_frame = false;             // wants sub-command 17
  int min_exposure = 0, max_exposure = 0;  // 0 = not said
  ScanFrame area;
};
// The first five bytes of INQUIRY: how long the whole is.
[[nodiscard]] std::size_t inquiry_length(ByteView head);
[[nodiscard]] Inquiry parse_inquiry(ByteView bytes);

struct State {
  int frame = 0;  // of the transport, from 0
  bool warming_up = false;
  bool no_film = false;  // where the model reports film
};
[[nodiscard]] State parse_state(ByteView bytes, bool reports_film);

struct GainReference {
  std::array<std::uint16_t, 4> exposure{};
  std::array<std::uint8_t, 4> offset{}, gain{};
};
[[nodiscard]] GainReference parse_gain(ByteView bytes);

// Lines that a calibration has per kind, and their width.
struct CalibrationInfo {
  int n_lines = 0;  // of all entries
  int width_px = 0;
};
[[nodiscard]] CalibrationInfo parse_calibration_info(ByteView bytes);

struct ScanParameters {
  int width_px = 0;
  int n_lines = 0;
  int line_bytes = 0;  // of one colour, without its tag
};
[[nodiscard]] ScanParameters parse_parameters(ByteView bytes);

[[nodiscard]] Sense parse_sense(ByteView bytes);

// Indices of the sensor's pixels that a scan uses, ascending.
[[nodiscard]] std::vector<int> parse_mask(ByteView bytes);

}  // namespace reseau::pieusb
