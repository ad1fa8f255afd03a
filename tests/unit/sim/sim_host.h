// The least a host does: one command after the other, raw bytes in and out.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "drivers/sim/simulated_unit.h"
#include "drivers/sim/wire.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

inline std::string to_hex(ByteView bytes) {
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text.push_back(kDigits[byte >> 4]);
    text.push_back(kDigits[byte & 15]);
  }
  return text;
}

struct Exchange {
  int phase = 0;
  Bytes data;
  std::string status;  // 16 hex digits
};

class SimHost {
 public:
  explicit SimHost(std::string_view name) : usb_(open_simulated_unit(name)) {}

  [[nodiscard]] UsbTransport& usb() { return *usb_; }

  void out(ByteView bytes) {
    usb_->bulk_out(kBulkOut, std::as_bytes(std::span(bytes)), Duration(1000));
  }
  Bytes in(std::size_t room) {
    Bytes buffer(room);
    const std::size_t n =
        usb_->bulk_in(kBulkIn, std::as_writable_bytes(std::span(buffer)), Duration(1000));
    buffer.resize(n);
    return buffer;
  }

  // in_bytes: how much the CDB asks for.
  Exchange run(std::string_view cdb, std::size_t in_bytes = 0, ByteView data = {},
               bool send_06 = false) {
    Exchange e;
    out(from_hex(cdb));
    do {
      out(Bytes{0xd0});
      e.phase = in(1).at(0);
    } while (e.phase == kPhaseBusy);
    if (e.phase == kPhaseDataIn) {
      // A short transfer: the unit has less than was asked for.
      while (e.data.size() < in_bytes) {
        const std::size_t left = in_bytes - e.data.size();
        const Bytes part = in(left);
        append(e.data, part);
        if (part.size() < left) break;
      }
    }
    if (e.phase == kPhaseDataOut) out(data);
    if (send_06) out(Bytes{0x06});
    e.status = to_hex(in(8));
    return e;
  }
  Exchange send(std::string_view cdb, std::string_view hex) { return run(cdb, 0, from_hex(hex)); }
  std::string status(std::string_view cdb) { return run(cdb).status; }
  std::string test_unit_ready() { return status("000000000000"); }
  // Polls until the unit is ready; returns how often it was busy.
  int wait_ready() {
    for (int n = 0; n < 1000; ++n) {
      if (test_unit_ready() == kGoodStatus) return n;
    }
    ADD_FAILURE() << "never ready";
    return -1;
  }

  static constexpr std::string_view kGoodStatus = "0000000000000000";

 private:
  std::unique_ptr<UsbTransport> usb_;
};

// A 50-byte descriptor with its header, as Nikon Scan writes it.
struct WindowList {
  int id = 1, dpi = 4000, depth = 16, composition = 5;
  std::uint32_t x = 0, y = 0, width = 3946, height = 5959;
  std::string_view bytes_40_to_44 = "00 81 01 02 02";
  std::uint32_t exposure = 0;

  [[nodiscard]] Bytes list() const {
    Bytes b = from_hex("0000000000000032");
    put8(b, static_cast<std::uint32_t>(id));
    put8(b, 0);
    put16(b, static_cast<std::uint32_t>(dpi));
    put16(b, static_cast<std::uint32_t>(dpi));
    for (const std::uint32_t v : {x, y, width, height}) put32(b, v);
    b.resize(b.size() + 3, 0);
    put8(b, static_cast<std::uint32_t>(composition));
    put8(b, static_cast<std::uint32_t>(depth));
    b.resize(b.size() + 13, 0);
    append(b, from_hex(bytes_40_to_44));
    put8(b, 0xff);
    put32(b, exposure);
    return b;
  }
};

inline constexpr std::string_view kSetWindow = "24000000000000003a80";

}  // namespace reseau::sim
