// Every command of the family, encoded. Pure; numbers: drivers/pieusb/README.md, *Protocol*.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/bytes.h"
#include "drivers/scsi/cdb.h"

namespace reseau::pieusb {

enum class Op : std::uint8_t {
  kTestUnitReady = 0x00,
  kRequestSense = 0x03,
  kRead = 0x08,
  kWrite = 0x0A,
  kGetParameters = 0x0F,
  kInquiry = 0x12,
  kModeSelect = 0x15,
  kCopy = 0x18,
  kModeSense = 0x1A,
  kScan = 0x1B,
  kSlide = 0xD1,
  kSetScanHead = 0xD2,
  kReadGain = 0xD7,
  kWriteGain = 0xDC,
  kReadState = 0xDD,
  kVendorE7 = 0xE7,
};

inline constexpr std::size_t kSenseBytes = 14;
inline constexpr std::size_t kParameterBytes = 18;
inline constexpr std::size_t kCalibrationInfoBytes = 32;

// A command whose length field holds `length`: bytes, lines of a READ, or the flag of SCAN.
[[nodiscard]] Cdb command_of(Op op, int length = 0);
[[nodiscard]] inline Op op_of(const Cdb& cdb) { return static_cast<Op>(cdb.opcode()); }
[[nodiscard]] int length_of(const Cdb& cdb);

// "READ, 63 lines [08 00 00 00 3F 00]": for logs and errors of maintainers.
[[nodiscard]] std::string describe(const Cdb& cdb);

// Corners in pixels of the unit's highest resolution, both inside.
struct ScanFrame {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool operator==(const ScanFrame&) const = default;
};

enum class Quality : std::uint16_t {
  kNone = 0,
  kSkipShading = 0x0008,   // no calibration lines: use the calibration that the unit holds
  kFastInfrared = 0x0080,  // the infrared plane has the scan's resolution
  kCalibrateNow = 0x0800,
};

struct Mode {
  int dpi = 0;
  bool infrared = false;  // in the same pass as red, green and blue
  int depth_bits = 16;    // 8 or 16
  std::uint16_t quality = 0;
};

// Exposures are steps of the unit's timer, red green blue infrared.
struct GainOffset {
  std::array<std::uint16_t, 4> exposure{};
  std::array<std::uint8_t, 4> offset{};
  std::array<std::uint8_t, 4> gain{};
  std::uint8_t light = 4;
  bool infrared = false;
};

// Payloads of WRITE.
[[nodiscard]] Bytes scan_frame_data(const ScanFrame& frame);
[[nodiscard]] Bytes filter_percentage_data(int sub_command, int filter);  // 13 or 14; 100 %
[[nodiscard]] Bytes prepare_calibration_info_data();
[[nodiscard]] Bytes confirm_frame_data();  // sub-command 17

[[nodiscard]] Bytes mode_data(const Mode& mode);
[[nodiscard]] Bytes gain_data(const GainOffset& gain);

enum class SlideAction : std::uint8_t {
  kNext = 0x04,
  kPrevious = 0x05,
  kInitialise = 0x10,
};
[[nodiscard]] Bytes slide_data(SlideAction action);

}  // namespace reseau::pieusb
