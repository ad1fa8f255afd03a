// The USB side of a simulated unit: command, phase, data and status as bulk transfers. Source:
// LS-5000 interface specification, USB transport; LS-50 firmware 1.02.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

#include "drivers/sim/sim_spec.h"
#include "drivers/sim/unit.h"
#include "drivers/sim/wire_bytes.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::sim {

inline constexpr Endpoint kBulkOut = 0x01;
inline constexpr Endpoint kBulkIn = 0x82;

// Phase byte.
inline constexpr std::uint8_t kPhaseStatus = 0x01;
inline constexpr std::uint8_t kPhaseDataOut = 0x02;
inline constexpr std::uint8_t kPhaseDataIn = 0x03;
inline constexpr std::uint8_t kPhaseBusy = 0x04;

// Thread-bound. Timeouts are never waited for: an IN transfer with nothing to send fails at once.
class SimulatedUsb final : public UsbTransport {
 public:
  // Throws InputError for an unknown model.
  explicit SimulatedUsb(const SimSpec& spec);

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;

 private:
  enum class State {
    kIdle,     // waits for a command
    kCommand,  // has one, waits for the phase query
    kDataOut,  // waits for the data of a command
  };
  // One answer on its way to the host, cut into packets.
  struct Answer {
    Bytes bytes;
    std::size_t sent = 0;
    bool ends_transfer = false;
  };

  void count_transfer(Endpoint endpoint);
  void query_phase();
  void take_data(ByteView data);
  void answer(Bytes bytes) { answers_.push_back({std::move(bytes), 0, false}); }
  void answer_data(Bytes bytes);
  void answer_status(const Sense& sense);

  UnitSpec faults_;
  Unit unit_;
  UsbIdentity identity_;
  State state_ = State::kIdle;
  CommandReply reply_;
  Bytes out_data_;
  std::deque<Answer> answers_;
  std::int64_t n_transfers_ = 0, n_statuses_ = 0, n_commands_ = 0;
  bool lost_ = false;             // the command was not taken
  bool silent_ = false;           // for good
  std::array<bool, 2> halted_{};  // OUT, IN
};

}  // namespace reseau::sim
