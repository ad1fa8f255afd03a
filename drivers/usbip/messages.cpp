#include "drivers/usbip/messages.h"

#include <algorithm>

#include "core/base/error.h"

namespace reseau::usbip {
namespace {

constexpr std::uint16_t kRequestBit = 0x8000;
constexpr std::uint16_t kImport = 0x0003, kDeviceList = 0x0005;
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitReply = 3, kUnlinkReply = 4;
constexpr std::size_t kOperationBytes = 8, kBusIdBytes = 32, kPathBytes = 256;
constexpr std::size_t kTransferHeadBytes = 48;
// Both mean that a transfer is not isochronous.
constexpr std::uint32_t kNoPackets = 0xFFFFFFFF;

void append_be(Bytes& bytes, std::size_t n, std::uint64_t value) {
  for (std::size_t i = n; i-- > 0;) bytes.push_back(std::byte(value >> (8 * i) & 0xFF));
}

void append_text(Bytes& bytes, std::size_t n, const std::string& text) {
  for (std::size_t i = 0; i < n; ++i) {
    bytes.push_back(i + 1 < n && i < text.size() ? static_cast<std::byte>(text[i]) : std::byte{0});
  }
}

void append_operation(Bytes& bytes, std::uint16_t code, std::uint32_t status) {
  append_be(bytes, 2, kVersion);
  append_be(bytes, 2, code);
  append_be(bytes, 4, status);
}

void append_summary(Bytes& bytes, const DeviceSummary& device) {
  append_text(bytes, kPathBytes, device.path);
  append_text(bytes, kBusIdBytes, device.bus_id);
  append_be(bytes, 4, device.bus);
  append_be(bytes, 4, device.device);
  append_be(bytes, 4, device.speed);
  append_be(bytes, 2, device.vendor_id);
  append_be(bytes, 2, device.product_id);
  append_be(bytes, 2, device.bcd_device);
  for (const std::uint8_t value :
       {device.device_class, device.subclass, device.protocol, device.configuration,
        device.n_configurations, device.n_interfaces}) {
    append_be(bytes, 1, value);
  }
}

std::uint32_t be32(ByteView bytes, std::size_t offset) {
  return static_cast<std::uint32_t>(load_be(bytes, offset, 4));
}

}  // namespace

std::optional<Request> RequestReader::next() {
  return attached_ ? next_transfer() : next_operation();
}

void RequestReader::drop(std::size_t n) {
  begin_ += n;
  if (begin_ == buffer_.size()) {
    buffer_.clear();
    begin_ = 0;
  } else if (begin_ > buffer_.size() / 2) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
}

std::optional<Request> RequestReader::next_operation() {
  const ByteView bytes = ByteView(buffer_).subspan(begin_);
  if (bytes.size() < kOperationBytes) return std::nullopt;
  const auto version = static_cast<std::uint16_t>(load_be(bytes, 0, 2));
  const auto code = static_cast<std::uint16_t>(load_be(bytes, 2, 2));
  if (version != kVersion ||
      (code != (kRequestBit | kDeviceList) && code != (kRequestBit | kImport))) {
    drop(kOperationBytes);
    return UnknownRequest{code};
  }
  if (code == (kRequestBit | kDeviceList)) {
    drop(kOperationBytes);
    return DeviceListRequest{};
  }
  if (bytes.size() < kOperationBytes + kBusIdBytes) return std::nullopt;
  ImportRequest request;
  for (std::size_t i = 0; i < kBusIdBytes; ++i) {
    const char c = static_cast<char>(u8_at(bytes, kOperationBytes + i));
    if (c == '\0') break;
    request.bus_id += c;
  }
  drop(kOperationBytes + kBusIdBytes);
  return request;
}

std::optional<Request> RequestReader::next_transfer() {
  const ByteView bytes = ByteView(buffer_).subspan(begin_);
  if (bytes.size() < kTransferHeadBytes) return std::nullopt;
  const std::uint32_t command = be32(bytes, 0);
  if (command == kUnlink) {
    UnlinkRequest request{be32(bytes, 4), be32(bytes, 8), be32(bytes, 20)};
    drop(kTransferHeadBytes);
    return request;
  }
  if (command != kSubmit) {
    throw InputError("A USB/IP client sent command " + std::to_string(command) +
                     ", which does not exist.");
  }
  SubmitRequest request;
  request.sequence = be32(bytes, 4);
  request.device_id = be32(bytes, 8);
  const std::uint32_t direction = be32(bytes, 12);
  request.in = direction == 1;
  request.endpoint = be32(bytes, 16);
  request.flags = be32(bytes, 20);
  request.length = be32(bytes, 24);
  request.n_packets = be32(bytes, 32);
  std::copy_n(bytes.begin() + 40, request.setup.size(), request.setup.begin());
  if (direction > 1 || request.endpoint > 15 || request.length > kMaxTransferBytes ||
      (request.n_packets != 0 && request.n_packets != kNoPackets)) {
    throw InputError("A USB/IP client sent a transfer that no scanner has: endpoint " +
                     std::to_string(request.endpoint) + ", " + std::to_string(request.length) +
                     " bytes.");
  }
  const std::size_t payload = request.in ? 0 : request.length;
  if (bytes.size() < kTransferHeadBytes + payload) return std::nullopt;
  const ByteView data = bytes.subspan(kTransferHeadBytes, payload);
  request.data.assign(data.begin(), data.end());
  drop(kTransferHeadBytes + payload);
  return request;
}

Bytes encode_device_list(const std::vector<DeviceSummary>& devices) {
  Bytes bytes;
  append_operation(bytes, kDeviceList, 0);
  append_be(bytes, 4, devices.size());
  for (const DeviceSummary& device : devices) {
    append_summary(bytes, device);
    for (int i = 0; i < device.n_interfaces; ++i) {
      for (const std::uint8_t value :
           {device.device_class, device.subclass, device.protocol, std::uint8_t{0}}) {
        append_be(bytes, 1, value);
      }
    }
  }
  return bytes;
}

Bytes encode_import(const std::optional<DeviceSummary>& device) {
  Bytes bytes;
  append_operation(bytes, kImport, device ? 0 : 1);
  if (device) append_summary(bytes, *device);
  return bytes;
}

Bytes encode_refusal(std::uint16_t code) {
  Bytes bytes;
  append_operation(bytes, static_cast<std::uint16_t>(code & ~kRequestBit), 1);
  return bytes;
}

void append_completion(const Completion& completion, Bytes& to) {
  append_be(to, 4, completion.unlink ? kUnlinkReply : kSubmitReply);
  append_be(to, 4, completion.sequence);
  append_be(to, 4, 0);  // device, direction and endpoint are not told in replies
  append_be(to, 4, 0);
  append_be(to, 4, 0);
  append_be(to, 4, static_cast<std::uint32_t>(completion.status));
  append_be(to, 4, completion.unlink ? 0 : completion.moved_bytes);
  append_be(to, 4, 0);
  append_be(to, 4, completion.unlink ? 0 : completion.n_packets);
  append_be(to, 4, 0);
  append_be(to, 8, 0);
  to.insert(to.end(), completion.data.begin(), completion.data.end());
}

}  // namespace reseau::usbip
