// A simulated unit as a USB device for any program: SANE on a machine with the kernel's vhci-hcd,
// or whatever else speaks USB/IP (Linux kernel documentation, usbip_protocol).
#pragma once

#include <functional>
#include <stop_token>
#include <string>

namespace reseau {

struct ExportOptions {
  std::string device_name;  // "sim:ls5000?frames=6"
  // "tcp:127.0.0.1:3240", "tcp:3240" (this computer only), "tcp:0" (a free port), "unix:/path"
  std::string listen;
};

struct ExportTalk {
  // Once connections are taken: where, with the port that was taken, and what is exported.
  std::function<void(const std::string& address, const std::string& description)> ready;
  // Clients that come, go or break the protocol.
  std::function<void(const std::string& sentence)> note;
};

// Exports the unit under bus id 1-1 until it is stopped, in the calling thread. Throws InputError
// for a name or an address that cannot be understood, std::system_error for an address that cannot
// be had.
void export_unit(const ExportOptions& options, const ExportTalk& talk, const std::stop_token& stop);

}  // namespace reseau
