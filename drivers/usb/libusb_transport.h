// Units on the bus, through libusb-1.0.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/usb/usb_transport.h"

namespace reseau {

struct UsbDeviceInfo {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial;  // from sysfs; empty when the unit has none
  std::string node;    // "/dev/bus/usb/001/004"
  std::string speed;   // "USB, full speed"
};

// Devices of one vendor. Opens none of them, needs no permission. Empty when there is no bus.
[[nodiscard]] std::vector<UsbDeviceInfo> list_usb_devices(std::uint16_t vendor_id);

// The first device with these ids, and with this serial unless it is empty; interface 0 claimed,
// configuration 1 set when the unit has none. Throws DeviceError (kDisconnected when there is no
// such unit, kBusy when another program holds it), std::system_error for a missing permission.
[[nodiscard]] std::unique_ptr<UsbTransport> open_libusb(std::uint16_t vendor_id,
                                                        std::uint16_t product_id,
                                                        const std::string& serial);

}  // namespace reseau
