#pragma once

#include <memory>
#include <string>

#include "drivers/scsi/scsi_device.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// One SCSI unit with what it stands on and what the link itself knows of it. Move-only.
struct ScsiLink {
  std::shared_ptr<void> keeps;  // dies after the device
  std::unique_ptr<ScsiDevice> device;
  std::string serial;
  std::string description;  // "USB, high speed"
  int packet_bytes = 0;     // data comes in whole packets of this size; 0: any length
};

// A link through Nikon's wrapper over a claimed interface that borrows the clock.
[[nodiscard]] ScsiLink usb_scsi_link(std::unique_ptr<UsbTransport> usb, Clock& clock);

// Says that a SCSI unit, not a USB one, is behind the link: no packets.
inline void as_scsi(ScsiLink& link) {
  link.packet_bytes = 0;
  link.description = "SCSI";
}

}  // namespace reseau
