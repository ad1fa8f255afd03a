#include "drivers/pieusb/models.h"

#include <algorithm>
#include <array>

namespace reseau::pieusb {
namespace {

// Source: configuration file and tables of SANE's pieusb backend.
constexpr Dialect kCommon{};

// Source: s6stkurz/reflecta-rps-7200, docs/protocol.md (nine captures of CyberView, one unit).
constexpr Dialect kRps{.state_bytes = 13,
                       .gain_bytes = 123,
                       .sends_percentages = false,
                       .calibrates_in_own_pass = true,
                       .mask_before_scan = true,
                       .reports_film = true,
                       .light = 6};

constexpr std::array kModels = {
    Model{0x30, "crystalscan7200", "Reflecta CrystalScan 7200", 0x0145, Transport::kNone, 7200,
          kCommon},
    Model{0x36, "proscan7200", "Reflecta ProScan 7200", 0x0145, Transport::kNone, 7200, kCommon},
    Model{0x47, "proscan10t", "Reflecta ProScan 10T", 0x0145, Transport::kNone, 10000, kCommon},
    Model{0x2E, "crystalscan3600", "Reflecta CrystalScan 3600", 0x0145, Transport::kNone, 3600,
          kCommon},
    Model{0x3A, "digitdia6000", "Reflecta DigitDia 6000 (Braun PowerSlide 5000)", 0x0142,
          Transport::kSlideMagazine, 5000, kCommon},
    Model{0x2F, "digitdia5000", "Reflecta DigitDia 4000 or 5000", 0x0142, Transport::kSlideMagazine,
          3600, kCommon},
    Model{0x31, "rps7200", "Reflecta RPS 7200", 0x0144, Transport::kFilmStrip, 3600, kRps},
};

}  // namespace

std::span<const Model> models() { return kModels; }

const Model* model_by_number(int number) {
  const auto* const found = std::find_if(kModels.begin(), kModels.end(),
                                         [&](const Model& m) { return m.number == number; });
  return found == kModels.end() ? nullptr : &*found;
}

bool is_known_usb_id(std::uint16_t vendor_id, std::uint16_t product_id) {
  return vendor_id == kGenesysVendorId &&
         std::any_of(kModels.begin(), kModels.end(),
                     [&](const Model& m) { return m.product_id == product_id; });
}

}  // namespace reseau::pieusb
