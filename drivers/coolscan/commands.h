// Every command that the driver sends, as pure functions: CDBs and their data, no device.
// Source: LS-5000 interface specification, commands; checked against a recorded Nikon Scan session
// (tests/replay).
#pragma once

#include <array>
#include <cstdint>

#include "drivers/bytes.h"
#include "drivers/scsi/cdb.h"

namespace reseau::coolscan {

// Window ids, which are also the colour codes of READ and SEND.
enum class Colour : std::uint8_t { kDefault = 0, kRed = 1, kGreen = 2, kBlue = 3, kInfrared = 9 };
inline constexpr std::array kColours = {Colour::kRed, Colour::kGreen, Colour::kBlue,
                                        Colour::kInfrared};

enum class DataType : std::uint8_t {
  kImage = 0x00,
  kLookUpTable = 0x03,
  kCooperation = 0x87,
  kFrameRectangles = 0x88,
  kWhiteBalanceExposure = 0x8C,
  kPerforations = 0x8E,
  kFrameTable = 0x8F,
  kCcdCurves = 0x91,
};

// Operations of SET PARAMETER, EXECUTE, GET PARAMETER.
enum class Operation : std::uint8_t {
  kInitialise = 0x80,  // as at power on
  kReturnToOrigin = 0x81,
  kAutofocus = 0xA0,    // X, Y address [optical px]
  kUnloadTimer = 0xB4,  // seconds, on or off
  kMoveFocus = 0xC1,    // position
  kUnload = 0xD0,
  kLoad = 0xD1,
};

// Two values of a parameter block.
struct Parameters {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
  bool operator==(const Parameters&) const = default;
};

inline constexpr std::size_t kInquiryBytes = 36;
inline constexpr std::size_t kPageHeadBytes = 4;
inline constexpr std::size_t kDataHeadBytes = 6;   // before data types 80 and up
inline constexpr std::size_t kParameterBytes = 9;  // what Nikon Scan sends
inline constexpr std::size_t kWindowBytes = 58;    // header 8, descriptor 50

[[nodiscard]] Cdb test_unit_ready();
[[nodiscard]] Cdb inquiry();
[[nodiscard]] Cdb inquiry_page(std::uint8_t page, std::size_t n_bytes);
[[nodiscard]] Cdb reserve_unit();
[[nodiscard]] Cdb release_unit();
[[nodiscard]] Cdb send_diagnostic();
[[nodiscard]] Cdb abort_scan();
[[nodiscard]] Cdb execute();

// Sets how many units of a window make an inch; only 1200 and the maximum resolution are taken.
[[nodiscard]] Cdb mode_select();
[[nodiscard]] Bytes mode_select_data(int units_per_inch);
// The short form, without a block descriptor.
[[nodiscard]] Cdb short_mode_select();
[[nodiscard]] Bytes short_mode_select_data(int units_per_inch);

[[nodiscard]] Cdb set_window();
[[nodiscard]] Cdb get_window(Colour colour);
// All windows; n_bytes as their length field says, 8 at first.
[[nodiscard]] Cdb get_all_windows(std::size_t n_bytes);
[[nodiscard]] Cdb scan(std::size_t n_windows);
[[nodiscard]] Bytes scan_data(const std::vector<Colour>& colours);

// Element size code of READ and SEND, fixed per data type; images: 0 one byte, 1 two bytes.
[[nodiscard]] int element_code(DataType type, int bytes_per_sample);
[[nodiscard]] Cdb read(DataType type, Colour colour, int element, std::size_t n_bytes);
[[nodiscard]] Cdb send(DataType type, Colour colour, int element, std::size_t n_bytes);
// Length of the data that follows a 6-byte head of data types 80 and up.
[[nodiscard]] std::size_t data_length(ByteView head);

[[nodiscard]] Cdb set_parameter(Operation operation);
[[nodiscard]] Cdb get_parameter(Operation operation);
[[nodiscard]] Bytes parameter_data(const Parameters& parameters);
[[nodiscard]] Parameters decode_parameters(ByteView block);

// A look-up table that changes nothing: entries 0 … 2^in_bits - 1 scaled to out_bits, big-endian.
[[nodiscard]] Bytes identity_table(int in_bits, int out_bits);

}  // namespace reseau::coolscan
