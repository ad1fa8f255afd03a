#include "drivers/pieusb/bridge.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/never.h"
#include "drivers/pieusb/replies.h"
#include "drivers/pieusb/sense.h"

namespace reseau::pieusb {
namespace {

using namespace std::chrono_literals;

// Ports and requests of the bridge. Source: SANE's pieusb backend.
constexpr std::uint8_t kSizePort = 0x82, kStatusPort = 0x84, kCommandPort = 0x85;
constexpr std::uint8_t kControlPort = 0x87, kDataPort = 0x88;
constexpr std::uint8_t kWriteType = 0x40, kReadType = 0xC0;
constexpr std::uint8_t kPortRequest = 0x0C, kBlockRequest = 0x04;
constexpr std::uint8_t kScsiMode = 0xE0;

constexpr Duration kControlTimeout = 5s;
constexpr Duration kBulkTimeout = 30s;
constexpr Duration kModePause = 3ms;
constexpr Duration kBusyPoll = 20ms;
constexpr Duration kAgainPause = 1s;
constexpr int kAttempts = 3;

// False for commands whose second sending would do something else than the first.
bool repeatable(const Cdb& cdb) {
  switch (op_of(cdb)) {
    case Op::kRead:
    case Op::kScan:
    case Op::kSlide:
    case Op::kRequestSense:
      return false;
    default:
      return true;
  }
}

bool worth_repeating(const DeviceError& error) {
  return error.kind() == DeviceError::Kind::kTimeout || error.kind() == DeviceError::Kind::kStall ||
         error.kind() == DeviceError::Kind::kProtocol;
}

DeviceError silent_unit(const std::string& detail) {
  return {DeviceError::Kind::kTimeout,
          "The scanner has not finished a command in time. Switch it off, wait ten seconds, switch "
          "it on again and repeat the scan.",
          detail};
}

}  // namespace

PieBridge::PieBridge(UsbTransport& usb, Clock& clock)
    : usb_(usb),
      clock_(clock),
      bulk_in_(usb.identity().bulk_in),
      max_packet_bytes_(static_cast<std::size_t>(usb.identity().max_packet_bytes)),
      staging_(kMaxBulkBytes) {}

ScsiReply PieBridge::command(const Cdb& cdb, Duration timeout) {
  return transact(cdb, {}, {}, timeout);
}

ScsiReply PieBridge::send(const Cdb& cdb, ByteView out, Duration timeout) {
  return transact(cdb, out, {}, timeout);
}

ScsiReply PieBridge::receive(const Cdb& cdb, std::span<std::byte> in, Duration timeout) {
  return transact(cdb, {}, in, timeout);
}

ScsiReply PieBridge::transact(const Cdb& cdb, ByteView out, std::span<std::byte> in,
                              Duration timeout) {
  if (const char* const why = why_never(cdb, out, in.size())) {
    throw DeviceError(DeviceError::Kind::kRefused,
                      "The program was about to send the scanner a command that can harm it, and "
                      "did not. Please report this with a recording (--record).",
                      describe(cdb) + ": " + why);
  }
  const TimePoint until = clock_.now() + timeout;
  for (int attempt = 1;; ++attempt) {
    const bool last = attempt == kAttempts;
    try {
      const ScsiReply reply = transact_once(cdb, out, in, until);
      const bool unknown = !reply.good && reply.sense == kUnknownSense;
      const bool lost = reply.good && reply.received < in.size();
      if ((!unknown && !lost) || last || !repeatable(cdb)) return reply;
    } catch (const DeviceError& error) {
      const bool again = !may_have_acted_ || repeatable(cdb);
      if (last || !again || !worth_repeating(error) || clock_.now() >= until) {
        if (error.kind() != DeviceError::Kind::kTimeout) throw;
        throw silent_unit(describe(cdb) + ", " + error.detail());
      }
    }
    resynchronise();
  }
}

ScsiReply PieBridge::transact_once(const Cdb& cdb, ByteView out, std::span<std::byte> in,
                                   TimePoint until) {
  while (true) {
    may_have_acted_ = false;
    select_commands();
    write_port(kCommandPort, cdb.bytes().first(5));
    may_have_acted_ = out.empty();
    write_port(kCommandPort, cdb.bytes().last(1));
    std::uint8_t status = wait_status(until, cdb);
    if (status == static_cast<std::uint8_t>(PortStatus::kGood) && !out.empty()) {
      write_port(kCommandPort, out.first(out.size() - 1));
      may_have_acted_ = true;
      write_port(kCommandPort, out.last(1));
      status = wait_status(until, cdb);
    }
    ScsiReply reply;
    const bool offered = status == static_cast<std::uint8_t>(PortStatus::kDataReady) && !in.empty();
    if (offered) {
      reply.received = read_data(in);
      status = wait_status(until, cdb);
    }
    switch (static_cast<PortStatus>(status)) {
      case PortStatus::kGood:
        if (offered || in.empty()) return reply;
        break;
      case PortStatus::kCheck:
        reply.good = false;
        reply.sense = request_sense();
        return reply;
      case PortStatus::kAgain:
        // Not taken: the whole command comes again.
        if (clock_.now() + kAgainPause >= until) throw silent_unit(describe(cdb));
        clock_.sleep_for(kAgainPause);
        continue;
      default:
        break;
    }
    throw DeviceError(DeviceError::Kind::kHardware,
                      "The scanner's USB side gave up a command. Switch the scanner off, wait ten "
                      "seconds, switch it on again and repeat the scan.",
                      describe(cdb) + ", status " + std::to_string(status));
  }
}

void PieBridge::select_commands() {
  static constexpr std::array kKnock{std::byte{0xFF}, std::byte{0xAA},     std::byte{0x55},
                                     std::byte{0x00}, std::byte{0xFF},     std::byte{0x87},
                                     std::byte{0x78}, std::byte{kScsiMode}};
  static constexpr std::array kStrobe{std::byte{0x05}, std::byte{0x04}};
  static constexpr std::array kIdle{std::byte{0xFF}};
  // One that broke off in the middle may have left the bridge waiting for its rest.
  for (int n = std::exchange(out_of_step_, false) ? 2 : 1; n > 0; --n) {
    write_port(kDataPort, kKnock);
    clock_.sleep_for(kModePause);
    write_port(kControlPort, kStrobe);
    write_port(kDataPort, kIdle);
  }
}

void PieBridge::write_port(std::uint8_t port, std::span<const std::byte> data) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    usb_.control_out({kWriteType, kPortRequest, port, 0}, data.subspan(i, 1), kControlTimeout);
  }
}

std::uint8_t PieBridge::read_status() {
  // Asking twice does no harm.
  for (int attempt = 1;; ++attempt) {
    try {
      std::array<std::byte, 1> status{};
      const std::size_t n =
          usb_.control_in({kReadType, kPortRequest, kStatusPort, 0}, status, kControlTimeout);
      if (n == 1) return std::to_integer<std::uint8_t>(status[0]);
      if (attempt == kAttempts) {
        throw DeviceError(DeviceError::Kind::kProtocol,
                          "The scanner does not say how it is. Switch it off and on, then scan "
                          "again.",
                          "empty status");
      }
    } catch (const DeviceError& error) {
      if (attempt == kAttempts || !worth_repeating(error)) throw;
      resynchronise();
    }
  }
}

std::uint8_t PieBridge::wait_status(TimePoint until, const Cdb& cdb) {
  while (true) {
    const std::uint8_t status = read_status();
    if (status != static_cast<std::uint8_t>(PortStatus::kBusy)) return status;
    if (clock_.now() >= until) throw silent_unit(describe(cdb));
    clock_.sleep_for(kBusyPoll);
  }
}

void PieBridge::announce(std::size_t n_bytes) {
  Bytes size(4, std::byte{0});
  append_le(size, 4, n_bytes);
  for (int attempt = 1;; ++attempt) {
    try {
      return usb_.control_out({kWriteType, kBlockRequest, kSizePort, 0}, size, kControlTimeout);
    } catch (const DeviceError& error) {
      if (attempt == kAttempts || !worth_repeating(error)) throw;
      resynchronise();
    }
  }
}

std::size_t PieBridge::read_data(std::span<std::byte> in) {
  std::size_t received = 0;
  while (!in.empty()) {
    const auto window = in.first(std::min(in.size(), kMaxAnnouncedBytes));
    announce(window.size());
    received += read_window(window);
    if (received == 0) {
      throw DeviceError(DeviceError::Kind::kTimeout,
                        "The scanner promised data and sent none. Switch it off, wait ten seconds, "
                        "switch it on again and repeat the scan.",
                        "bulk IN");
    }
    // Even when part of it got lost, the rest of a READ has to leave the unit.
    in = in.subspan(window.size());
  }
  return received;
}

std::size_t PieBridge::read_window(std::span<std::byte> in) {
  std::size_t received = 0;
  int failures = 0;
  while (received < in.size()) {
    const std::size_t wanted = std::min(in.size() - received, kMaxBulkBytes);
    // Whole packets, so that nothing overflows.
    const std::size_t asked = std::min(
        (wanted + max_packet_bytes_ - 1) / max_packet_bytes_ * max_packet_bytes_, staging_.size());
    try {
      const std::size_t n =
          std::min(usb_.bulk_in(bulk_in_, std::span(staging_).first(asked), kBulkTimeout), wanted);
      std::copy_n(staging_.begin(), n, in.begin() + static_cast<std::ptrdiff_t>(received));
      received += n;
      if (n == 0 && ++failures > 1) break;
    } catch (const DeviceError& error) {
      if (!worth_repeating(error)) throw;
      // A bulk read that timed out leaves the pipe halted, and then every request times out too.
      resynchronise();
      if (++failures > 1) break;
    }
  }
  return received;
}

Sense PieBridge::request_sense() {
  const bool command_acted = may_have_acted_;
  Sense sense = kUnknownSense;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    try {
      may_have_acted_ = false;
      select_commands();
      const Cdb cdb = command_of(Op::kRequestSense, static_cast<int>(kSenseBytes));
      write_port(kCommandPort, cdb.bytes().first(5));
      may_have_acted_ = true;
      write_port(kCommandPort, cdb.bytes().last(1));
      const TimePoint until = clock_.now() + kBulkTimeout;
      if (wait_status(until, cdb) == static_cast<std::uint8_t>(PortStatus::kDataReady)) {
        Bytes bytes(kSenseBytes);
        if (read_data(bytes) == bytes.size()) sense = parse_sense(bytes);
        (void)wait_status(until, cdb);
      }
      break;
    } catch (const DeviceError& error) {
      if (!worth_repeating(error)) throw;
      resynchronise();
      // Reading clears it: what may have been asked for is not asked for again.
      if (may_have_acted_) break;
    }
  }
  may_have_acted_ = command_acted;
  return sense;
}

void PieBridge::resynchronise() {
  out_of_step_ = true;
  try {
    usb_.clear_halt(bulk_in_);
  } catch (const DeviceError& error) {
    if (error.kind() == DeviceError::Kind::kDisconnected) throw;
  }
}

}  // namespace reseau::pieusb
