#include "drivers/usb/replay_fault.h"

#include <cerrno>

#include "core/base/error.h"
#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

bool begins_command(std::span<const std::byte> data) {
  return data.size() == 6 || data.size() == 10;
}

}  // namespace

void ReplayFault::bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) {
  if (data.empty()) return;
  const bool command = begins_command(data);
  if (recovering_) {
    if (!command) return;  // into the void, as to a unit that waits for a command
    recovering_ = false;
    if (in_command_) replay_->to_last_command();
  }
  if (command) in_command_ = false;
  strike(endpoint, data.size());
  replay_->bulk_out(endpoint, data, timeout);
  in_command_ = true;
}

std::size_t ReplayFault::bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) {
  if (recovering_) throw transfer_error(ETIMEDOUT, endpoint, buffer.size());
  const bool cut = strike(endpoint, buffer.size());
  const std::size_t n = replay_->bulk_in(endpoint, buffer, timeout);
  recovering_ = cut;
  return cut ? n / 2 : n;
}

void ReplayFault::clear_halt(Endpoint endpoint) {
  if (!recovering_) replay_->clear_halt(endpoint);
}

void ReplayFault::reset() {
  if (!recovering_) replay_->reset();
}

bool ReplayFault::strike(Endpoint endpoint, std::size_t asked_bytes) {
  const long transfer = n_transfers_++;
  const bool gone = fault_.kind == Fault::Kind::kDisconnect && transfer >= fault_.transfer;
  if (gone) throw transfer_error(ENODEV, endpoint, asked_bytes);
  if (transfer != fault_.transfer) return false;
  if (fault_.kind == Fault::Kind::kShort) return (endpoint & 0x80) != 0;
  recovering_ = true;
  throw transfer_error(fault_.kind == Fault::Kind::kStall ? EPIPE : ETIMEDOUT, endpoint,
                       asked_bytes);
}

}  // namespace reseau
