#include "drivers/usb/usb_transport.h"

#include <cerrno>

#include "drivers/usb/usb_error.h"

namespace reseau {

void UsbTransport::control_out(const ControlRequest& /*request*/, std::span<const std::byte> data,
                               Duration /*timeout*/) {
  throw transfer_error(EPIPE, kControlOut, data.size());
}

std::size_t UsbTransport::control_in(const ControlRequest& /*request*/, std::span<std::byte> buffer,
                                     Duration /*timeout*/) {
  throw transfer_error(EPIPE, kControlIn, buffer.size());
}

}  // namespace reseau
