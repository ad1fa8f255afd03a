// A device as its standard descriptors tell it. USB 2.0 specification, chapter 9.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bytes.h"

namespace reseau::usbip {

struct EndpointDescription {
  std::uint8_t address = 0;  // with the direction bit
  bool interrupt = false;    // otherwise bulk
  int packet_bytes = 0;      // 0: as the speed of the link has it (bulk)
  std::uint8_t interval = 0;
};

// One configuration with one interface of the vendor's own class.
struct DeviceDescription {
  std::uint16_t vendor_id = 0, product_id = 0, bcd_device = 0;
  std::uint16_t bcd_usb = 0x0200;
  bool high_speed = true;
  int control_packet_bytes = 64;
  std::string manufacturer, product, serial;  // an empty one has no index
  std::uint8_t attributes = 0xC0;             // self powered
  std::uint8_t max_power = 1;                 // units of 2 mA
  std::vector<EndpointDescription> endpoints;
  // Some units vanish after a reset of their port: then a new client finds the unit as it was left,
  // with its endpoints cleared.
  bool bears_reset = true;
};

inline constexpr std::uint8_t kDeviceDescriptor = 1, kConfigurationDescriptor = 2,
                              kStringDescriptor = 3, kQualifierDescriptor = 6,
                              kOtherSpeedDescriptor = 7;

// Absent for a descriptor that the device does not have.
[[nodiscard]] std::optional<Bytes> descriptor(const DeviceDescription& device, std::uint8_t type,
                                              std::uint8_t index);

}  // namespace reseau::usbip
