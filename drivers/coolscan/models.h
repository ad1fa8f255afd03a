#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace reseau::coolscan {

inline constexpr std::uint16_t kNikonVendorId = 0x04B0;

// Where a model differs from what the family's rules and its own pages say. Each field names its
// source in models.cpp.
struct Errata {
  // No flags in the control byte of a command.
  bool zero_control = false;
  // MODE SELECT without a block descriptor.
  bool short_mode_select = false;
  // Pages D1 and E1 do not exist: depths 8 and deepest_bits, one line, one reading.
  bool only_addresses = false;
  // Bits of a sample where the page says more than is delivered; 0 = as the page says.
  int deepest_bits = 0;
  // GET WINDOW gives all windows or none.
  bool all_windows_only = false;
  // Lines of odd width and 8 bits have no filling byte.
  bool odd_colours = false;
  // An exposure for infrared that was metered is multiplied by this before the scan.
  double infrared_factor = 1.0;
  // Frames of a strip holder that have hung the unit; a sentence for the person.
  std::string_view frame_warning{};
};

// What the pages of a unit do not say. Everything else is taken from the pages.
struct Model {
  std::string_view product;  // as in INQUIRY
  std::string_view trade_name;
  std::uint16_t product_id = 0;  // USB; 0: parallel SCSI or FireWire
  bool infrared = false;
  Errata errata;
};

// Every model that this driver knows; udev/60-reseau.rules lists the same product ids.
[[nodiscard]] std::span<const Model> models();

// nullptr when unknown.
[[nodiscard]] const Model* model_by_usb_id(std::uint16_t vendor_id, std::uint16_t product_id);
[[nodiscard]] const Model* model_by_product(std::string_view product);

}  // namespace reseau::coolscan
