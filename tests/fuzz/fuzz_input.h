#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/bytes.h"

namespace reseau::fuzz {

inline ByteView view(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const std::byte*>(data), size};
}

}  // namespace reseau::fuzz
