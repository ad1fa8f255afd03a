// The physical boundary to one claimed USB interface. Behind it stand libusb, a recording, a
// replay, a fault injector, or a simulated unit; the code above cannot tell which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/base/clock.h"

namespace reseau {

// Endpoint address as in the descriptor: 0x01 bulk OUT, 0x82 bulk IN.
using Endpoint = std::uint8_t;

struct UsbIdentity {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial;  // string descriptor, empty when the unit has none
  std::uint16_t bcd_device = 0;
  int max_packet_bytes = 512;  // of the bulk endpoints: 512 at high speed, 64 at full speed
  Endpoint bulk_in = 0x82;     // of interface 0
};

// The fields of a control transfer's setup packet but its length (USB 2.0, 9.3). Bit 7 of `type`
// is the direction and has to be that of the call.
struct ControlRequest {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  bool operator==(const ControlRequest&) const = default;
};

// Thread-bound: one thread uses it at a time. Every failure is a DeviceError whose kind is
// kTimeout, kStall, kDisconnected or kProtocol.
class UsbTransport {
 public:
  virtual ~UsbTransport() = default;
  [[nodiscard]] virtual const UsbIdentity& identity() const = 0;
  // Sends all bytes or throws. An empty span sends nothing.
  virtual void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) = 0;
  // One transfer: returns how many bytes came, at most buffer.size(); a short read is a value.
  virtual std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) = 0;
  // Control transfers of the unit's own (vendor) requests on endpoint 0; at most 65535 bytes.
  // A unit that knows none, which is what stands here, stalls them.
  virtual void control_out(const ControlRequest& request, std::span<const std::byte> data,
                           Duration timeout);
  // Returns how many bytes came, at most buffer.size(); a short answer is a value.
  virtual std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                                 Duration timeout);
  virtual void clear_halt(Endpoint endpoint) = 0;
  virtual void reset() = 0;
  // Names what the following transfers are for ("focus", "exposure pass 2"). A recording keeps it,
  // a replay reports it with a mismatch, everything else ignores it.
  virtual void annotate(std::string_view /*phase*/) {}
};

}  // namespace reseau
