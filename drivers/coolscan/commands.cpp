#include "drivers/coolscan/commands.h"

namespace reseau::coolscan {
namespace {

int byte_of(std::size_t value, int index) { return static_cast<int>(value >> (8 * index) & 0xFF); }

// Nikon Scan sets b7 of the control byte in INQUIRY pages, windows and READ, and nowhere else
// (recorded Nikon Scan session); without it LS-50 firmware 1.02 refuses the infrared window.
constexpr int kNikonControl = 0x80;

}  // namespace

Cdb test_unit_ready() { return {0x00, 0, 0, 0, 0, 0}; }
Cdb inquiry() { return {0x12, 0, 0, 0, kInquiryBytes, kNikonControl}; }
Cdb inquiry_page(std::uint8_t page, std::size_t n_bytes) {
  CHECK(n_bytes <= 0xFF);
  return {0x12, 1, page, 0, byte_of(n_bytes, 0), kNikonControl};
}
Cdb reserve_unit() { return {0x16, 0, 0, 0, 0, 0}; }
Cdb release_unit() { return {0x17, 0, 0, 0, 0, 0}; }
Cdb send_diagnostic() { return {0x1D, 0x04, 0, 0, 0, 0}; }
Cdb abort_scan() { return {0xC0, 0, 0, 0, 0, 0}; }
Cdb execute() { return {0xC1, 0, 0, 0, 0, 0}; }

Cdb mode_select() { return {0x15, 0x10, 0, 0, 0x14, 0}; }

Bytes mode_select_data(int units_per_inch) {
  Bytes data = bytes_of({0,    0,    0, 8,                // header
                         0,    0,    0, 0, 0, 0, 0, 1,    // block descriptor
                         0x03, 0x06, 0, 0, 0, 0, 0, 0});  // page 3
  store_be(data, 16, 2, static_cast<std::uint64_t>(units_per_inch));
  return data;
}

Cdb short_mode_select() { return {0x15, 0x10, 0, 0, 0x0C, 0}; }

Bytes short_mode_select_data(int units_per_inch) {
  Bytes data = bytes_of({0x0B, 0, 0, 0, 0x03, 0x06, 0, 0, 0, 0, 0, 0});
  store_be(data, 8, 2, static_cast<std::uint64_t>(units_per_inch));
  return data;
}

Cdb set_window() { return {0x24, 0, 0, 0, 0, 0, 0, 0, kWindowBytes, kNikonControl}; }

Cdb get_window(Colour colour) {
  return {0x25, 1, 0, 0, 0, static_cast<int>(colour), 0, 0, kWindowBytes, kNikonControl};
}

Cdb get_all_windows(std::size_t n_bytes) {
  return {
      0x25,         0, 0, 0, 0, 0, byte_of(n_bytes, 2), byte_of(n_bytes, 1), byte_of(n_bytes, 0),
      kNikonControl};
}

Cdb scan(std::size_t n_windows) { return {0x1B, 0, 0, 0, byte_of(n_windows, 0), 0}; }

Bytes scan_data(const std::vector<Colour>& colours) {
  Bytes data;
  for (const Colour colour : colours) data.push_back(static_cast<std::byte>(colour));
  return data;
}

int element_code(DataType type, int bytes_per_sample) {
  switch (type) {
    case DataType::kImage:
      return bytes_per_sample == 1 ? 0 : 1;
    case DataType::kLookUpTable:
    case DataType::kCcdCurves:
      return 1;
    case DataType::kFrameRectangles:
    case DataType::kWhiteBalanceExposure:
    case DataType::kFrameTable:
      return 3;
    case DataType::kCooperation:
    case DataType::kPerforations:
      return 0;
  }
  return 0;
}

namespace {
// READ and SEND differ in the operation and in what Nikon Scan puts into the control byte.
Cdb transfer(int operation, DataType type, Colour colour, int element, std::size_t n_bytes,
             int control) {
  CHECK(n_bytes < (1U << 24));
  return {operation,
          0,
          static_cast<int>(type),
          0,
          static_cast<int>(colour),
          element,
          byte_of(n_bytes, 2),
          byte_of(n_bytes, 1),
          byte_of(n_bytes, 0),
          control};
}
}  // namespace

Cdb read(DataType type, Colour colour, int element, std::size_t n_bytes) {
  return transfer(0x28, type, colour, element, n_bytes, kNikonControl);
}

Cdb send(DataType type, Colour colour, int element, std::size_t n_bytes) {
  return transfer(0x2A, type, colour, element, n_bytes, 0);
}

std::size_t data_length(ByteView head) { return load_be(head, 2, 4); }

Cdb set_parameter(Operation operation) {
  return {0xE0, 0, static_cast<int>(operation), 0, 0, 0, 0, 0, kParameterBytes, 0};
}

Cdb get_parameter(Operation operation) {
  return {0xE1, 0, static_cast<int>(operation), 0, 0, 0, 0, 0, kParameterBytes, 0};
}

Bytes parameter_data(const Parameters& parameters) {
  Bytes data(kParameterBytes);
  store_be(data, 1, 4, parameters.first);
  store_be(data, 5, 4, parameters.second);
  return data;
}

Parameters decode_parameters(ByteView block) {
  return {static_cast<std::uint32_t>(load_be(block, 1, 4)),
          static_cast<std::uint32_t>(load_be(block, 5, 4))};
}

Bytes identity_table(int in_bits, int out_bits) {
  CHECK(in_bits >= 1 && in_bits <= 16 && out_bits >= 1 && out_bits <= 16);
  const std::size_t n = std::size_t{1} << in_bits;
  const std::size_t last_in = n - 1;
  const std::size_t last_out = (std::size_t{1} << out_bits) - 1;
  Bytes table(2 * n);
  for (std::size_t i = 0; i < n; ++i) {
    store_be(table, 2 * i, 2, (i * last_out + last_in / 2) / last_in);
  }
  return table;
}

}  // namespace reseau::coolscan
