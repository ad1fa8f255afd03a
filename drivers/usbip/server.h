#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "drivers/usbip/exported_device.h"
#include "drivers/usbip/listen_socket.h"

namespace reseau::usbip {

// Serves one device to one client at a time, and the list of devices to anybody, until it is
// stopped. A client that breaks the protocol, or goes away, loses its connection and nothing else
// happens. All in the calling thread; borrows everything. `say` hears of clients that come and go.
// Throws std::system_error when the machine cannot wait for connections any more.
void serve(const ListenSocket& listener, ExportedDevice& device, const std::stop_token& stop,
           const std::function<void(const std::string&)>& say);

}  // namespace reseau::usbip
