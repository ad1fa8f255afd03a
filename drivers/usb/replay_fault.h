// Faults in a replay. A recording holds no recovery from them; so the pipe is silent while the
// program finds its way back, and the command that it then repeats is played again.
#pragma once

#include <memory>

#include "drivers/usb/fault_transport.h"
#include "drivers/usb/replay_transport.h"

namespace reseau {

// Of scanners behind Nikon's wrapper; transfers are counted from 0 over bulk calls, repeated ones
// included. A command that the program does not repeat ends the replay. Thread-bound.
class ReplayFault final : public UsbTransport {
 public:
  ReplayFault(std::unique_ptr<ReplayTransport> replay, Fault fault)
      : replay_(std::move(replay)), fault_(fault) {}

  [[nodiscard]] const UsbIdentity& identity() const override { return replay_->identity(); }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;
  void annotate(std::string_view phase) override { replay_->annotate(phase); }

 private:
  // True when this transfer shall be cut; throws when it shall fail.
  bool strike(Endpoint endpoint, std::size_t asked_bytes);

  std::unique_ptr<ReplayTransport> replay_;
  Fault fault_;
  long n_transfers_ = 0;
  bool recovering_ = false;  // the fault struck, and the program has not begun a command since
  bool in_command_ = false;  // some of the struck command was played
};

}  // namespace reseau
