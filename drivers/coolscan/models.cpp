#include "drivers/coolscan/models.h"

namespace reseau::coolscan {
namespace {

// Ids: LS-5000 interface specification, USB descriptors; LS-50 and LS-40 firmware.
constexpr Model kModels[] = {
    {"LS-40 ED", "Nikon Coolscan IV ED", 0x4000, true},
    {"LS-50 ED", "Nikon Coolscan V ED", 0x4001, true},
    {"LS-5000 ED", "Nikon Super Coolscan 5000 ED", 0x4002, true},
};

}  // namespace

std::span<const Model> models() { return kModels; }

const Model* model_by_usb_id(std::uint16_t vendor_id, std::uint16_t product_id) {
  if (vendor_id != kNikonVendorId) return nullptr;
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
