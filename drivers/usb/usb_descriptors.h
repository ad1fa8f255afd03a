// The identity of a unit as the standard USB requests that ask for it, so that a recording carries
// it the way a capture of any program does.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "drivers/usb/usb_capture.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

using UsbSetup = std::array<std::byte, 8>;

struct ControlExchange {
  UsbSetup setup{};
  Bytes data;
};

// GET_DESCRIPTOR of device, configuration and, when there is one, the serial string.
[[nodiscard]] std::vector<ControlExchange> describe_identity(const UsbIdentity& identity);

// Takes what one control transfer tells about a unit; leaves the rest as it is. Anything that is
// not a descriptor, or a broken one, changes nothing.
void learn_identity(const UsbTransfer& control, UsbIdentity& identity);

// Setup packet of a request that moves that many bytes.
[[nodiscard]] UsbSetup setup_of_request(const ControlRequest& request, std::size_t n_bytes);
// Whether a setup packet is a request of the unit's own, not one of the standard's.
[[nodiscard]] bool is_vendor_request(const UsbSetup& setup);

[[nodiscard]] UsbSetup clear_halt_setup(Endpoint endpoint);
// SET_CONFIGURATION, which is what the kernel sends after it reset a device.
[[nodiscard]] UsbSetup reset_setup();

}  // namespace reseau
