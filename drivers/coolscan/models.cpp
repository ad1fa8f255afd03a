#include "drivers/coolscan/models.h"

namespace reseau::coolscan {
namespace {

// LS-30, LS-2000: control byte 00, short MODE SELECT, no filling bytes, 10 bits of an LS-30 that
// says 12: what a driver that works on them does. UNVERIFIED(no dump of their pages D1, E1 exists).
constexpr Errata kFirstGeneration{.zero_control = true,
                                  .short_mode_select = true,
                                  .only_addresses = true,
                                  .deepest_bits = 12,
                                  .odd_colours = true};
constexpr Errata kLs30{.zero_control = true,
                       .short_mode_select = true,
                       .only_addresses = true,
                       .deepest_bits = 10,
                       .odd_colours = true};
// Nikon Scan on an LS-40: infrared times 0.9 before the final pass.
constexpr Errata kLs40{.infrared_factor = 0.9};
// Reported by users of an LS-8000 with the FH-835S.
constexpr Errata kLs8000{
    .frame_warning =
        "An LS-8000 has hung while scanning frames 5, 6, 11 and 12 of the strip "
        "holder FH-835S. If it does, switch it off for ten seconds."};
// Measured on an LS-9000: GET WINDOW for one window is refused with 05/24/00.
constexpr Errata kLs9000{.all_windows_only = true};

// Ids: LS-5000 interface specification, USB descriptors; LS-50 and LS-40 firmware. The SCSI and
// FireWire models have none.
constexpr Model kModels[] = {
    {"COOLSCANIII", "Nikon Coolscan III (LS-30)", 0, true, kLs30},
    {"LS-2000", "Nikon Super Coolscan 2000", 0, true, kFirstGeneration},
    {"LS-40 ED", "Nikon Coolscan IV ED", 0x4000, true, kLs40},
    {"LS-50 ED", "Nikon Coolscan V ED", 0x4001, true, {}},
    {"LS-4000 ED", "Nikon Super Coolscan 4000 ED", 0, true, {}},
    {"LS-5000 ED", "Nikon Super Coolscan 5000 ED", 0x4002, true, {}},
    {"LS-8000 ED", "Nikon Super Coolscan 8000 ED", 0, true, kLs8000},
    {"LS-9000 ED", "Nikon Super Coolscan 9000 ED", 0, true, kLs9000},
};

}  // namespace

std::span<const Model> models() { return kModels; }

const Model* model_by_usb_id(std::uint16_t vendor_id, std::uint16_t product_id) {
  if (vendor_id != kNikonVendorId || product_id == 0) return nullptr;
  for (const Model& model : kModels) {
    if (model.product_id == product_id) return &model;
  }
  return nullptr;
}

const Model* model_by_product(std::string_view product) {
  for (const Model& model : kModels) {
    if (model.product == product) return &model;
  }
  return nullptr;
}

}  // namespace reseau::coolscan
