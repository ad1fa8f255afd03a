// Bytes as the wire carries them: big-endian fields in plain vectors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace reseau::sim {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

inline void put8(Bytes& to, std::uint32_t v) { to.push_back(static_cast<std::uint8_t>(v)); }
inline void put16(Bytes& to, std::uint32_t v) {
  put8(to, v >> 8 & 0xff);
  put8(to, v & 0xff);
}
inline void put24(Bytes& to, std::uint32_t v) {
  put8(to, v >> 16 & 0xff);
  put16(to, v & 0xffff);
}
inline void put32(Bytes& to, std::uint32_t v) {
  put16(to, v >> 16);
  put16(to, v & 0xffff);
}
inline void append(Bytes& to, ByteView from) { to.insert(to.end(), from.begin(), from.end()); }

// The caller has checked that the field lies inside.
[[nodiscard]] inline std::uint32_t get16(ByteView from, std::size_t at) {
  return static_cast<std::uint32_t>(from[at]) << 8 | from[at + 1];
}
[[nodiscard]] inline std::uint32_t get24(ByteView from, std::size_t at) {
  return static_cast<std::uint32_t>(from[at]) << 16 | get16(from, at + 1);
}
[[nodiscard]] inline std::uint32_t get32(ByteView from, std::size_t at) {
  return get16(from, at) << 16 | get16(from, at + 2);
}
inline void set16(Bytes& in, std::size_t at, std::uint32_t v) {
  in[at] = static_cast<std::uint8_t>(v >> 8 & 0xff);
  in[at + 1] = static_cast<std::uint8_t>(v & 0xff);
}
inline void set32(Bytes& in, std::size_t at, std::uint32_t v) {
  set16(in, at, v >> 16);
  set16(in, at + 2, v & 0xffff);
}

// Hex digits, blanks allowed between bytes. For tables in this folder only.
[[nodiscard]] inline Bytes from_hex(std::string_view text) {
  const auto digit = [](char c) {
    return c <= '9' ? static_cast<std::uint32_t>(c - '0')
                    : static_cast<std::uint32_t>((c | 0x20) - 'a') + 10;
  };
  Bytes result;
  for (std::size_t i = 0; i + 1 < text.size();) {
    if (text[i] == ' ') {
      ++i;
      continue;
    }
    put8(result, digit(text[i]) << 4 | digit(text[i + 1]));
    i += 2;
  }
  return result;
}

}  // namespace reseau::sim
