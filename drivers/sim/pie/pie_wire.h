// The USB side of a simulated PIE unit: the ports of its bridge. Source: as pie_model.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/sim/pie/pie_unit.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::sim::pie {

// Thread-bound. Timeouts are never waited for: a transfer with nothing to say fails at once.
class PieUsb final : public UsbTransport {
 public:
  PieUsb(const PieModel& model, const SimSpec& spec);

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override;
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;

 private:
  void count_transfer(Endpoint endpoint);
  void write_port(int port, std::uint8_t value);
  void knock(int port, std::uint8_t value);
  void take_command_byte(std::uint8_t value);
  void execute();
  [[nodiscard]] bool short_now() const;  // this transfer loses half of what it moves

  UnitSpec faults_;
  PieUnit unit_;
  UsbIdentity identity_;
  std::int64_t n_transfers_ = 0;
  int n_statuses_ = 0;
  bool halted_ = false;  // the bulk pipe; every request waits for it in vain
  std::size_t n_knocks_ = 0;
  std::uint8_t knocked_mode_ = 0;
  bool selected_ = false;  // the command port listens
  Bytes cdb_, out_;
  std::size_t out_wanted_ = 0;
  std::uint8_t status_ = 0;
  int busy_left_ = 0;
  Bytes in_;
  std::size_t in_sent_ = 0, announced_ = 0;
  bool silent_ = false;
};

}  // namespace reseau::sim::pie
