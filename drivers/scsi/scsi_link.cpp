#include "drivers/scsi/scsi_link.h"

#include <utility>

#include "drivers/scsi/nikon_usb_scsi.h"

namespace reseau {

ScsiLink usb_scsi_link(std::unique_ptr<UsbTransport> usb, Clock& clock) {
  const std::shared_ptr<UsbTransport> shared = std::move(usb);
  constexpr int kHighSpeedPacket = 512;
  const UsbIdentity& identity = shared->identity();
  ScsiLink link;
  link.keeps = shared;
  link.device = std::make_unique<NikonUsbScsi>(*shared, clock);
  link.serial = identity.serial;
  link.packet_bytes = identity.max_packet_bytes;
  link.description =
      identity.max_packet_bytes >= kHighSpeedPacket ? "USB, high speed" : "USB, full speed";
  return link;
}

}  // namespace reseau
