// USB/IP on the wire: requests parsed, replies encoded. All numbers are big-endian. Source: Linux
// kernel documentation, usbip_protocol.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::usbip {

inline constexpr std::uint16_t kVersion = 0x0111;
// Longest transfer that is taken or answered [bytes]; drivers ask for far less.
inline constexpr std::uint32_t kMaxTransferBytes = 16 * 1024 * 1024;

// What a client sees of a device before it attaches.
struct DeviceSummary {
  std::string path, bus_id;  // at most 255 and 31 characters
  std::uint32_t bus = 1, device = 2;
  std::uint32_t speed = 3;  // 1 low, 2 full, 3 high
  std::uint16_t vendor_id = 0, product_id = 0, bcd_device = 0;
  std::uint8_t device_class = 0xFF, subclass = 0xFF, protocol = 0xFF;
  std::uint8_t configuration = 1, n_configurations = 1, n_interfaces = 1;
};

struct DeviceListRequest {};
struct ImportRequest {
  std::string bus_id;
};
// An operation that this server does not know, or another version of the protocol.
struct UnknownRequest {
  std::uint16_t code = 0;
};
struct SubmitRequest {
  std::uint32_t sequence = 0;
  std::uint32_t device_id = 0;
  bool in = false;
  std::uint32_t endpoint = 0;
  std::uint32_t flags = 0;
  std::uint32_t length = 0;     // asked for, or of `data`
  std::uint32_t n_packets = 0;  // as sent; only isochronous transfers have any
  std::array<std::byte, 8> setup{};
  Bytes data;  // OUT
};
struct UnlinkRequest {
  std::uint32_t sequence = 0;
  std::uint32_t device_id = 0;
  std::uint32_t unlink_sequence = 0;
};
using Request =
    std::variant<DeviceListRequest, ImportRequest, UnknownRequest, SubmitRequest, UnlinkRequest>;

// The end of a transfer, or of an attempt to take one back.
struct Completion {
  bool unlink = false;
  std::uint32_t sequence = 0;
  std::int32_t status = 0;        // 0 or a negative errno
  std::uint32_t moved_bytes = 0;  // of a transfer
  std::uint32_t n_packets = 0;    // as submitted
  Bytes data;                     // IN
};

// Cuts a byte stream into requests: operations first, transfers once attached. Thread-bound.
class RequestReader {
 public:
  void feed(ByteView bytes) { buffer_.insert(buffer_.end(), bytes.begin(), bytes.end()); }
  // Absent until a whole request is there. Throws InputError for bytes that are no request; the
  // stream cannot be read on after that.
  [[nodiscard]] std::optional<Request> next();
  // From the next request on there are transfers.
  void attach() { attached_ = true; }
  [[nodiscard]] bool attached() const { return attached_; }

 private:
  [[nodiscard]] std::optional<Request> next_operation();
  [[nodiscard]] std::optional<Request> next_transfer();
  void drop(std::size_t n);

  Bytes buffer_;
  std::size_t begin_ = 0;  // of what was not read yet
  bool attached_ = false;
};

[[nodiscard]] Bytes encode_device_list(const std::vector<DeviceSummary>& devices);
// Without a device: refused.
[[nodiscard]] Bytes encode_import(const std::optional<DeviceSummary>& device);
// The answer to an operation that is not known.
[[nodiscard]] Bytes encode_refusal(std::uint16_t code);
void append_completion(const Completion& completion, Bytes& to);

}  // namespace reseau::usbip
