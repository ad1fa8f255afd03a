#pragma once

#include <memory>
#include <string>

#include "drivers/usb/usb_transport.h"

namespace reseau {

// What to do to one bulk or control transfer.
struct Fault {
  enum class Kind {
    kStall,       // fails once, before the unit sees it
    kTimeout,     // likewise
    kShort,       // an IN transfer loses its second half; an OUT transfer arrives whole
    kDisconnect,  // this transfer and every later one fail
  };
  Kind kind = Kind::kStall;
  long transfer = 0;  // counted from 0 over bulk and control calls
};

// "stall@120". Throws InputError that names the kinds.
[[nodiscard]] Fault parse_fault(const std::string& text);

// Fails one transfer of another transport. Thread-bound.
class FaultTransport final : public UsbTransport {
 public:
  FaultTransport(std::unique_ptr<UsbTransport> inner, Fault fault);

  [[nodiscard]] const UsbIdentity& identity() const override { return inner_->identity(); }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override;
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;
  void annotate(std::string_view phase) override { inner_->annotate(phase); }

  // Bulk and control transfers asked for so far, failed ones included.
  [[nodiscard]] long n_transfers() const { return n_transfers_; }

 private:
  // True when this transfer shall be cut; throws when it shall fail.
  bool strike(Endpoint endpoint, std::size_t asked_bytes);
  void check_connected(Endpoint endpoint) const;

  std::unique_ptr<UsbTransport> inner_;
  Fault fault_;
  long n_transfers_ = 0;
};

}  // namespace reseau
