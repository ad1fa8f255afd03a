#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace reseau::coolscan {

inline constexpr std::uint16_t kNikonVendorId = 0x04B0;

// What the pages of a unit do not say. Everything else is taken from the pages.
struct Model {
  std::string_view product;  // as in INQUIRY
  std::string_view trade_name;
  std::uint16_t product_id = 0;  // USB
  bool infrared = false;
};

// Every model that this driver knows; udev/60-reseau.rules lists the same product ids.
[[nodiscard]] std::span<const Model> models();

// nullptr when unknown.
[[nodiscard]] const Model* model_by_usb_id(std::uint16_t vendor_id, std::uint16_t product_id);
[[nodiscard]] const Model* model_by_product(std::string_view product);

}  // namespace reseau::coolscan
