#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>

#include "core/base/check.h"
#include "drivers/bytes.h"

namespace reseau {

// A SCSI command descriptor block of 6 or 10 bytes. Immutable, plain value.
class Cdb {
 public:
  Cdb(std::initializer_list<int> bytes) : size_(bytes.size()) {
    CHECK(size_ == 6 || size_ == 10);
    std::size_t i = 0;
    for (const int value : bytes) bytes_[i++] = std::byte(value);
  }
  // From a recording; the size must be 6 or 10.
  explicit Cdb(ByteView bytes) : size_(bytes.size()) {
    CHECK(size_ == 6 || size_ == 10);
    std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  }

  [[nodiscard]] ByteView bytes() const { return ByteView(bytes_).first(size_); }
  [[nodiscard]] std::uint8_t opcode() const { return std::to_integer<std::uint8_t>(bytes_[0]); }
  // False for commands whose second sending would do something else than the first: image READ
  // moves on, SCAN and EXECUTE start a motion.
  [[nodiscard]] bool repeatable() const {
    const bool image_read = opcode() == 0x28 && bytes_[2] == std::byte{0};
    return !image_read && opcode() != 0x1B && opcode() != 0xC1;
  }
  // The same with another control byte, the last one.
  [[nodiscard]] Cdb with_control(std::uint8_t control) const {
    Cdb other = *this;
    other.bytes_[size_ - 1] = std::byte{control};
    return other;
  }
  // "READ image, 130560 bytes [28 00 …]": for logs and errors of maintainers.
  [[nodiscard]] std::string describe() const;

 private:
  std::array<std::byte, 10> bytes_{};
  std::size_t size_;
};

}  // namespace reseau
