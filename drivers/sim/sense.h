// The status block that ends every command, and the codes the simulated units use. Source: LS-5000
// interface specification, sense tables; recorded Nikon Scan session; LS-50 firmware 1.02.
#pragma once

#include <array>
#include <cstdint>

namespace reseau::sim {

// Key, additional code, qualifier, and Nikon's fourth code (TSC). key 0 is good.
struct Sense {
  std::uint8_t key = 0, asc = 0, ascq = 0, tsc = 0;
  bool ili = false;  // fewer data than asked for

  [[nodiscard]] bool good() const { return key == 0; }
  [[nodiscard]] std::array<std::uint8_t, 8> status_block() const {
    if (good()) return {};
    const auto flags = static_cast<std::uint8_t>(key | (ili ? 0x20 : 0));
    return {0x02, flags, asc, ascq, tsc, 0, 0, 0};
  }
  bool operator==(const Sense&) const = default;
};

inline constexpr Sense kGood{};
inline constexpr Sense kRounded{0x01, 0x37, 0x00};
inline constexpr Sense kOutOfFocus{0x01, 0x61, 0x02, 0x01};
inline constexpr Sense kOperationRuns{0x02, 0x04, 0x01, 0x00};
inline constexpr Sense kFilmMoves{0x02, 0x04, 0x01, 0x01};
inline constexpr Sense kOperationFailed{0x02, 0x04, 0x02};
inline constexpr Sense kNotInitialised{0x02, 0x05, 0x00};
inline constexpr Sense kNoMedium{0x02, 0x3a, 0x00, 0x01};
inline constexpr Sense kNoSlide{0x02, 0x3a, 0x00, 0x00};
inline constexpr Sense kNoAdapter{0x02, 0x04, 0x03, 0x00};
inline constexpr Sense kJammed{0x04, 0x15, 0x01, 0x00};
inline constexpr Sense kListLength{0x05, 0x1a, 0x00};
inline constexpr Sense kBadOpcode{0x05, 0x20, 0x00};
inline constexpr Sense kBadCdb{0x05, 0x24, 0x00};
inline constexpr Sense kBadLun{0x05, 0x25, 0x00};
inline constexpr Sense kBadParameter{0x05, 0x26, 0x00};
inline constexpr Sense kBadComposition{0x05, 0x26, 0x02};
inline constexpr Sense kBadSequence{0x05, 0x2c, 0x00};
inline constexpr Sense kBadCombination{0x05, 0x2c, 0x02};
inline constexpr Sense kSavingParameters{0x05, 0x39, 0x00};
inline constexpr Sense kMediumChanged{0x06, 0x28, 0x00, 0x01};
inline constexpr Sense kPowerOn{0x06, 0x29, 0x00};
inline constexpr Sense kInquiryChanged{0x06, 0x3f, 0x03};
inline constexpr Sense kNotSelfConfigured{0x0b, 0x3e, 0x00};
inline constexpr Sense kLessData{0x0b, 0x4b, 0x00, 0x00, true};

}  // namespace reseau::sim
