#include "drivers/usbip/description.h"

#include <algorithm>

namespace reseau::usbip {
namespace {

constexpr int kInterfaceDescriptor = 4, kEndpointDescriptor = 5;
constexpr int kVendorClass = 0xFF;
constexpr int kFullSpeedPacket = 64, kHighSpeedPacket = 512;
constexpr int kEnglish = 0x0409;
constexpr std::size_t kMaxCharacters = 126;

Bytes device_descriptor(const DeviceDescription& device) {
  Bytes bytes = bytes_of({18, kDeviceDescriptor});
  append_le(bytes, 2, device.bcd_usb);
  for (int i = 0; i < 3; ++i) append_le(bytes, 1, kVendorClass);
  append_le(bytes, 1, static_cast<std::uint64_t>(device.control_packet_bytes));
  append_le(bytes, 2, device.vendor_id);
  append_le(bytes, 2, device.product_id);
  append_le(bytes, 2, device.bcd_device);
  append_le(bytes, 1, device.manufacturer.empty() ? 0 : 1);
  append_le(bytes, 1, device.product.empty() ? 0 : 2);
  append_le(bytes, 1, device.serial.empty() ? 0 : 3);
  append_le(bytes, 1, 1);
  return bytes;
}

Bytes qualifier_descriptor(const DeviceDescription& device) {
  Bytes bytes = bytes_of({10, kQualifierDescriptor});
  append_le(bytes, 2, device.bcd_usb);
  for (int i = 0; i < 3; ++i) append_le(bytes, 1, kVendorClass);
  append_le(bytes, 1, static_cast<std::uint64_t>(device.control_packet_bytes));
  append_le(bytes, 1, 1);
  append_le(bytes, 1, 0);
  return bytes;
}

Bytes configuration_descriptor(const DeviceDescription& device, std::uint8_t type,
                               bool high_speed) {
  const std::size_t n_endpoints = device.endpoints.size();
  Bytes bytes = bytes_of({9, type});
  append_le(bytes, 2, 9 + 9 + 7 * n_endpoints);
  for (const int value : {1, 1, 0}) append_le(bytes, 1, static_cast<std::uint64_t>(value));
  append_le(bytes, 1, device.attributes);
  append_le(bytes, 1, device.max_power);
  for (const int value : {9, kInterfaceDescriptor, 0, 0, static_cast<int>(n_endpoints),
                          kVendorClass, kVendorClass, kVendorClass, 0}) {
    append_le(bytes, 1, static_cast<std::uint64_t>(value));
  }
  for (const EndpointDescription& endpoint : device.endpoints) {
    const int bulk = high_speed ? kHighSpeedPacket : kFullSpeedPacket;
    append_le(bytes, 1, 7);
    append_le(bytes, 1, kEndpointDescriptor);
    append_le(bytes, 1, endpoint.address);
    append_le(bytes, 1, endpoint.interrupt ? 3 : 2);
    append_le(bytes, 2,
              static_cast<std::uint64_t>(endpoint.packet_bytes > 0 ? endpoint.packet_bytes : bulk));
    append_le(bytes, 1, endpoint.interval);
  }
  return bytes;
}

std::optional<Bytes> string_descriptor(const DeviceDescription& device, std::uint8_t index) {
  if (index == 0) {
    Bytes bytes = bytes_of({4, kStringDescriptor});
    append_le(bytes, 2, kEnglish);
    return bytes;
  }
  const std::string none;
  const std::string& text = index == 1   ? device.manufacturer
                            : index == 2 ? device.product
                            : index == 3 ? device.serial
                                         : none;
  if (text.empty()) return std::nullopt;
  const std::size_t n = std::min(text.size(), kMaxCharacters);
  Bytes bytes = bytes_of({static_cast<int>(2 + 2 * n), kStringDescriptor});
  for (std::size_t i = 0; i < n; ++i) append_le(bytes, 2, static_cast<std::uint8_t>(text[i]));
  return bytes;
}

}  // namespace

std::optional<Bytes> descriptor(const DeviceDescription& device, std::uint8_t type,
                                std::uint8_t index) {
  if (type == kStringDescriptor) return string_descriptor(device, index);
  if (index != 0) return std::nullopt;
  switch (type) {
    case kDeviceDescriptor:
      return device_descriptor(device);
    case kConfigurationDescriptor:
      return configuration_descriptor(device, type, device.high_speed);
    case kQualifierDescriptor:
      if (!device.high_speed) return std::nullopt;
      return qualifier_descriptor(device);
    case kOtherSpeedDescriptor:
      if (!device.high_speed) return std::nullopt;
      return configuration_descriptor(device, type, !device.high_speed);
    default:
      return std::nullopt;
  }
}

}  // namespace reseau::usbip
