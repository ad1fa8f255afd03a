// Numbers of the pcapng file format that reader and writer share (draft-ietf-opsawg-pcapng).
#pragma once

#include <cstdint>

namespace reseau::pcapng {

inline constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;
inline constexpr std::uint32_t kInterface = 1;
inline constexpr std::uint32_t kSimplePacket = 3;
inline constexpr std::uint32_t kEnhancedPacket = 6;
inline constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
inline constexpr std::uint16_t kOptionEnd = 0;
inline constexpr std::uint16_t kOptionComment = 1;
inline constexpr std::uint16_t kOptionApplication = 4;
inline constexpr std::uint16_t kOptionTimeResolution = 9;

}  // namespace reseau::pcapng
