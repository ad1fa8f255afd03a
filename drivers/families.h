// The families of scanners: which driver a unit on the bus belongs to.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "drivers/open_as.h"
#include "drivers/scanner.h"
#include "drivers/usb/libusb_transport.h"
#include "drivers/usb/replay_transport.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// Empty for a unit that no driver knows. A USB id that several models share names them all.
[[nodiscard]] std::string trade_name_of(std::uint16_t vendor_id, std::uint16_t product_id);

// Units on the bus that a driver knows. Opens nothing.
[[nodiscard]] std::vector<UsbDeviceInfo> list_known_units();

// The driver of the unit's family; throws what its constructor throws.
[[nodiscard]] std::unique_ptr<Scanner> open_family(std::unique_ptr<UsbTransport> usb,
                                                   std::shared_ptr<Clock> clock, OpenAs open_as);

// Names commands for people, of whichever family.
[[nodiscard]] ReplayTransport::Decoder command_decoder();

}  // namespace reseau
