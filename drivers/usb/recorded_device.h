// Which device of a capture is the scanner.
#pragma once

#include <cstdint>
#include <filesystem>

#include "drivers/usb/usb_capture.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

struct RecordedDevice {
  std::uint16_t bus = 0;
  std::uint8_t device = 0;
  UsbIdentity identity;  // what its descriptors say
};

// A command of Nikon's wrapper, to which a phase query belongs.
[[nodiscard]] bool is_scsi_command(const UsbTransfer& transfer);
// A byte for a port of a PIE bridge.
[[nodiscard]] bool writes_bridge_port(const UsbTransfer& transfer);
// Ports of such a bridge: the sequence that opens the command port, and the port itself.
inline constexpr std::uint8_t kBridgeKnockPort = 0x88, kBridgeCommandPort = 0x85;

// Looks for the first device that is sent commands, among others that share the bus. Throws
// InputError when there is none, std::system_error when the file cannot be opened.
[[nodiscard]] RecordedDevice find_recorded_device(const std::filesystem::path& path);

}  // namespace reseau
