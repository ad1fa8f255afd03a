#pragma once

#include <string>

#include "drivers/bytes.h"
#include "drivers/coolscan/plan.h"

namespace reseau::coolscan {

// "06 C1…", blanks are ignored.
inline Bytes from_hex(const std::string& text) {
  Bytes bytes;
  std::string digits;
  for (const char c : text) {
    if (c != ' ') digits += c;
  }
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// Pages as units send them (LS-5000: recorded Nikon Scan session with a strip adapter; mount
// variant of it; LS-50: firmware 1.02; LS-40: page C1 of a unit with a mount adapter).
inline const std::string kC1Ls5000Strip =
    "06C10053 03 003D 000F 0000 0100 01 01 00 03 31 0FA0 0FA0 005A 00000000 00000000 00000000 "
    "00000F6A 0FA0 0FA0 005A 0003D1A6 00000000 00000000 00001747 00001747 00000000 0061 0061 28 28 "
    "0000 0143 0000 10 0F6A 01 02";
inline const std::string kC1Ls5000Mount =
    "06C10053 03 003D 000F 0000 0100 01 01 00 03 22 0FA0 0FA0 005A 00000000 00000000 00000000 "
    "00000F6A 0FA0 0FA0 005A 00001695 00000000 00000000 00001696 00000000 00000000 0000 0000 01 01 "
    "0000 0143 0000 10 0F6A 01 02";
inline const std::string kC1Ls50 =
    "06C10053 03 003A 000F 0000 0040 01 01 00 01 31 0FA0 0FA0 005A 00000000 00000000 00000000 "
    "00000F6A 0FA0 0FA0 005A 00000000 00000000 00000000 00001747 00001747 00000000 0061 0061 06 00 "
    "0000 0143 0000 0E 0F6A 00 01";
inline const std::string kC1Ls40 =
    "06C10051 03 003A 000F 0000 0040 01 01 00 01 22 0B54 0B54 005A 00000000 00000000 00000000 "
    "00000B36 0B54 0B54 005A 0000106A 00000000 00000000 0000106B 00000000 00000000 0000 0000 01 01 "
    "0000 0143 0000 0C 0B36";
inline const std::string kD1Ls5000 =
    "06D10018 03 52 42 46 20 43 20 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
inline const std::string kD1Ls50 =
    "06D10018 03 46 02 46 20 43 12 00 00 00 40 09 04 00000001 03FFFFFF 00 00 00";
inline const std::string kE1Ls5000 =
    "06E10023 83 0C 80 B0 90 DA 7B 00 00 00 00 00 00 00 10 00 0300 0000 0100 1900 0300 4500 0000 "
    "0000 0C 04 00";
inline const std::string kE1Ls50 =
    "06E10023 81 04 8C 90 90 DA 73 00 0E 0E 00 00 00 00 0E 00 0300 0000 0100 1900 0300 4500 0000 "
    "0000 0C 04 00";

inline UnitDescription unit_of(const std::string& product, const std::string& c1,
                               const std::string& d1, const std::string& e1) {
  UnitDescription unit;
  unit.inquiry = {"Nikon", product, "1.03"};
  unit.infrared = true;
  unit.film_present = true;
  unit.addresses = parse_addresses(from_hex(c1));
  unit.windows = parse_window_abilities(from_hex(d1));
  unit.duties = parse_duties(from_hex(e1));
  return unit;
}

inline UnitDescription ls5000_mount() {
  return unit_of("LS-5000 ED", kC1Ls5000Mount, kD1Ls5000, kE1Ls5000);
}
inline UnitDescription ls5000_strip() {
  return unit_of("LS-5000 ED", kC1Ls5000Strip, kD1Ls5000, kE1Ls5000);
}
inline UnitDescription ls50_strip() { return unit_of("LS-50 ED", kC1Ls50, kD1Ls50, kE1Ls50); }

}  // namespace reseau::coolscan
