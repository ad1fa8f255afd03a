// Failed transfers as DeviceErrors, in one place, so that a recorded, replayed or injected failure
// reads exactly as the live one.
#pragma once

#include <cstddef>

#include "core/base/error.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// What stands for endpoint 0 in errors and captures.
inline constexpr Endpoint kControlOut = 0x00;
inline constexpr Endpoint kControlIn = 0x80;

// `status`: a positive Linux errno, as the kernel reports it for a URB.
[[nodiscard]] DeviceError transfer_error(int status, Endpoint endpoint, std::size_t asked_bytes);

// The errno that stands for an error of that kind in a recording.
[[nodiscard]] int status_of(DeviceError::Kind kind);

}  // namespace reseau
