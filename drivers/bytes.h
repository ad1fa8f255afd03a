// Numbers in byte strings. Callers have checked the length; every function is reentrant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "core/base/check.h"

namespace reseau {

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;

[[nodiscard]] inline std::uint8_t u8_at(ByteView bytes, std::size_t offset) {
  CHECK(offset < bytes.size());
  return std::to_integer<std::uint8_t>(bytes[offset]);
}

// n bytes, 1 to 8, most significant first.
[[nodiscard]] inline std::uint64_t load_be(ByteView bytes, std::size_t offset, std::size_t n) {
  CHECK(n <= 8 && n <= bytes.size() && offset <= bytes.size() - n);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < n; ++i) value = value << 8 | u8_at(bytes, offset + i);
  return value;
}

// n bytes, 1 to 8, least significant first.
[[nodiscard]] inline std::uint64_t load_le(ByteView bytes, std::size_t offset, std::size_t n) {
  CHECK(n <= 8 && n <= bytes.size() && offset <= bytes.size() - n);
  std::uint64_t value = 0;
  for (std::size_t i = n; i-- > 0;) value = value << 8 | u8_at(bytes, offset + i);
  return value;
}

inline void store_be(std::span<std::byte> bytes, std::size_t offset, std::size_t n,
                     std::uint64_t value) {
  CHECK(n <= 8 && n <= bytes.size() && offset <= bytes.size() - n);
  for (std::size_t i = n; i-- > 0; value >>= 8) bytes[offset + i] = std::byte(value & 0xFF);
}

inline void append_le(Bytes& bytes, std::size_t n, std::uint64_t value) {
  for (std::size_t i = 0; i < n; ++i, value >>= 8) bytes.push_back(std::byte(value & 0xFF));
}

[[nodiscard]] inline Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  bytes.reserve(values.size());
  for (const int value : values) bytes.push_back(std::byte(value));
  return bytes;
}

// "12 00 00 00 24 80"; longer than max_bytes ends in "… (n bytes)".
[[nodiscard]] inline std::string hex_of(ByteView bytes, std::size_t max_bytes = 32) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (std::size_t i = 0; i < bytes.size() && i < max_bytes; ++i) {
    if (i > 0) text += ' ';
    text += kDigits[u8_at(bytes, i) >> 4];
    text += kDigits[u8_at(bytes, i) & 15];
  }
  if (bytes.size() > max_bytes) text += " … (" + std::to_string(bytes.size()) + " bytes)";
  return text;
}

}  // namespace reseau
