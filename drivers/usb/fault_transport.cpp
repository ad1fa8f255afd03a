#include "drivers/usb/fault_transport.h"

#include <cerrno>
#include <charconv>
#include <utility>

#include "drivers/usb/usb_error.h"

namespace reseau {

Fault parse_fault(const std::string& text) {
  static constexpr std::pair<std::string_view, Fault::Kind> kKinds[] = {
      {"stall", Fault::Kind::kStall},
      {"timeout", Fault::Kind::kTimeout},
      {"short", Fault::Kind::kShort},
      {"disconnect", Fault::Kind::kDisconnect},
  };
  const std::size_t at = text.find('@');
  if (at != std::string::npos) {
    Fault fault;
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data() + at + 1, end, fault.transfer);
    if (parsed.ec == std::errc() && parsed.ptr == end && fault.transfer >= 0) {
      for (const auto& [name, kind] : kKinds) {
        if (text.compare(0, at, name) != 0) continue;
        fault.kind = kind;
        return fault;
      }
    }
  }
  throw InputError("The fault \"" + text +
                   "\" cannot be understood. Write stall@N, timeout@N, short@N or disconnect@N, "
                   "with the number of the USB transfer that shall fail.");
}

FaultTransport::FaultTransport(std::unique_ptr<UsbTransport> inner, Fault fault)
    : inner_(std::move(inner)), fault_(fault) {}

void FaultTransport::bulk_out(Endpoint endpoint, std::span<const std::byte> data,
                              Duration timeout) {
  strike(endpoint, data.size());
  inner_->bulk_out(endpoint, data, timeout);
}

std::size_t FaultTransport::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                    Duration timeout) {
  const bool cut = strike(endpoint, buffer.size());
  const std::size_t n = inner_->bulk_in(endpoint, buffer, timeout);
  return cut ? n / 2 : n;
}

void FaultTransport::control_out(const ControlRequest& request, std::span<const std::byte> data,
                                 Duration timeout) {
  strike(kControlOut, data.size());
  inner_->control_out(request, data, timeout);
}

std::size_t FaultTransport::control_in(const ControlRequest& request, std::span<std::byte> buffer,
                                       Duration timeout) {
  const bool cut = strike(kControlIn, buffer.size());
  const std::size_t n = inner_->control_in(request, buffer, timeout);
  return cut ? n / 2 : n;
}

void FaultTransport::clear_halt(Endpoint endpoint) {
  check_connected(endpoint);
  inner_->clear_halt(endpoint);
}

void FaultTransport::reset() {
  check_connected(0);
  inner_->reset();
}

void FaultTransport::check_connected(Endpoint endpoint) const {
  if (fault_.kind == Fault::Kind::kDisconnect && n_transfers_ > fault_.transfer) {
    throw transfer_error(ENODEV, endpoint, 0);
  }
}

bool FaultTransport::strike(Endpoint endpoint, std::size_t asked_bytes) {
  const long transfer = n_transfers_++;
  check_connected(endpoint);
  if (transfer != fault_.transfer) return false;
  switch (fault_.kind) {
    case Fault::Kind::kStall:
      throw transfer_error(EPIPE, endpoint, asked_bytes);
    case Fault::Kind::kTimeout:
      throw transfer_error(ETIMEDOUT, endpoint, asked_bytes);
    case Fault::Kind::kDisconnect:
      throw transfer_error(ENODEV, endpoint, asked_bytes);
    case Fault::Kind::kShort:
      return true;
  }
  return false;
}

}  // namespace reseau
