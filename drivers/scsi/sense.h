#pragma once

#include <cstdint>
#include <string>

#include "core/base/error.h"

namespace reseau {

enum class SenseKey : std::uint8_t {
  kGood = 0x0,
  kRecovered = 0x1,
  kNotReady = 0x2,
  kMedium = 0x3,
  kHardware = 0x4,
  kIllegalRequest = 0x5,
  kUnitAttention = 0x6,
  kHostAction = 0x9,  // vendor specific: the host shall read data type 87 and repeat SCAN
  kAborted = 0xB,
};

// What a unit says of the command it just ended. A value, not an error.
// Source: LS-5000 interface specification, sense data; the fourth code is Nikon's own.
struct Sense {
  std::uint8_t key = 0;
  std::uint8_t asc = 0;
  std::uint8_t ascq = 0;
  std::uint8_t tsc = 0;
  bool short_read = false;  // less data came than the READ asked for

  [[nodiscard]] bool is(SenseKey k) const { return key == static_cast<std::uint8_t>(k); }
  [[nodiscard]] bool is(int key_, int asc_, int ascq_) const {
    return key == key_ && asc == asc_ && ascq == ascq_;
  }
  [[nodiscard]] bool no_medium() const { return key == 2 && asc == 0x3A; }
  [[nodiscard]] bool out_of_focus() const { return is(1, 0x61, 2); }
  // "02/3A/00:01"
  [[nodiscard]] std::string code() const;
  bool operator==(const Sense&) const = default;
};

// A whole sentence for the person at the bench, with the code in brackets.
[[nodiscard]] std::string sentence_of(const Sense& sense);

// The error that stands for it. `operation` goes into detail(): usually Cdb::describe().
[[nodiscard]] DeviceError sense_error(const Sense& sense, const std::string& operation);

}  // namespace reseau
