#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace reseau::pieusb {

// Genesys Logic, whose chip bridges USB to the scanner.
inline constexpr std::uint16_t kGenesysVendorId = 0x05E3;

// How a unit moves film.
enum class Transport { kNone, kSlideMagazine, kFilmStrip };

// Habits that no reply of a unit tells. Two dialects are known: that of the units that SANE's
// backend was written for, and that of the RPS 7200 as its vendor's program drives it.
struct Dialect {
  int state_bytes = 12;                 // of READ STATE
  int gain_bytes = 103;                 // of READ GAIN/OFFSET
  bool sends_percentages = true;        // exposure and highlight of each filter before a scan
  bool calibrates_in_own_pass = false;  // MODE quality 0800; otherwise lines come before the image
  bool mask_before_scan = false;        // COPY goes before SCAN, not after it
  bool reports_film = false;            // READ STATE [8] says whether film is there
  int light = 4;                        // byte of WRITE GAIN/OFFSET
};

// What the replies of a unit do not say. Everything else is taken from INQUIRY.
struct Model {
  int number = 0;        // INQUIRY [116-117]
  std::string_view key;  // of the simulated unit: "rps7200"
  std::string_view trade_name;
  std::uint16_t product_id = 0;  // USB; several models share one
  Transport transport = Transport::kNone;
  int native_dpi = 0;  // above it odd and even columns are displaced, or the reference does not fit
  Dialect dialect;
};

// Every model that this driver knows; udev/60-reseau.rules lists the same product ids.
[[nodiscard]] std::span<const Model> models();

// nullptr when unknown.
[[nodiscard]] const Model* model_by_number(int number);
// Whether a unit with these ids may be one of the family.
[[nodiscard]] bool is_known_usb_id(std::uint16_t vendor_id, std::uint16_t product_id);

}  // namespace reseau::pieusb
