#include "drivers/scsi/nikon_usb_scsi.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

using namespace std::chrono_literals;

// LS-5000 interface specification, USB descriptors.
constexpr Endpoint kOut = 0x01;
constexpr Endpoint kIn = 0x82;
constexpr std::byte kPhaseQuery{0xD0};
constexpr std::size_t kStatusBytes = 8;

enum Phase : std::uint8_t { kStatus = 1, kDataOut = 2, kDataIn = 3, kBusy = 4 };

constexpr std::size_t kMaxTransferBytes = 128 * 1024;
constexpr int kMaxAttempts = 3;
constexpr Duration kBusyPoll = 5ms;
// Nikon Scan on an LS-40: the time between command and query grows by 2 ms after each "busy", and
// a query without an answer is given up after 7 s.
constexpr Duration kQueryDelayStep = 2ms;
constexpr Duration kMaxQueryDelay = 20ms;
constexpr Duration kLostCommand = 7s;
// Eight stale bytes of a process that died were cleared this way on an LS-50.
constexpr Duration kDrainTimeout = 200ms;
constexpr std::size_t kMaxDrainBytes = 1024 * 1024;

ScsiReply reply_of(ByteView status) {
  ScsiReply reply;
  reply.good = u8_at(status, 0) == 0x00;
  const std::uint8_t flags = u8_at(status, 1);
  reply.sense = {static_cast<std::uint8_t>(flags & 0x0F), u8_at(status, 2), u8_at(status, 3),
                 u8_at(status, 4), (flags & 0x20) != 0};
  return reply;
}

// The status "less data than asked for", where it came in place of data: alone in its packet.
std::optional<ScsiReply> early_status(ByteView came, std::size_t packet_bytes) {
  if (came.size() % packet_bytes != kStatusBytes) return std::nullopt;
  const ByteView status = came.last(kStatusBytes);
  if (load_be(status, 0, 4) != 0x022B4B00 || load_be(status, 5, 3) != 0) return std::nullopt;
  return reply_of(status);
}

DeviceError out_of_step(const Cdb& cdb, const std::string& what) {
  return {DeviceError::Kind::kProtocol,
          "The scanner's answers are out of step with the commands. Start again; if it happens "
          "again, switch the scanner off, wait ten seconds and switch it on.",
          cdb.describe() + ": " + what};
}

}  // namespace

NikonUsbScsi::NikonUsbScsi(UsbTransport& usb, Clock& clock)
    : usb_(usb),
      clock_(clock),
      max_packet_bytes_(static_cast<std::size_t>(usb.identity().max_packet_bytes)),
      query_delay_(full_speed() ? kQueryDelayStep : Duration(0)),
      packet_(max_packet_bytes_) {
  CHECK(max_packet_bytes_ >= kStatusBytes && kMaxTransferBytes % max_packet_bytes_ == 0);
}

ScsiReply NikonUsbScsi::command(const Cdb& cdb, Duration timeout) {
  return transact(cdb, {}, {}, timeout);
}

ScsiReply NikonUsbScsi::send(const Cdb& cdb, ByteView out, Duration timeout) {
  return transact(cdb, out, {}, timeout);
}

ScsiReply NikonUsbScsi::receive(const Cdb& cdb, std::span<std::byte> in, Duration timeout) {
  return transact(cdb, {}, in, timeout);
}

ScsiReply NikonUsbScsi::transact(const Cdb& cdb, ByteView out, std::span<std::byte> in,
                                 Duration timeout) {
  const TimePoint until = clock_.now() + timeout;
  for (int attempt = 1;; ++attempt) {
    const bool last = attempt == kMaxAttempts;
    try {
      return transact_once(cdb, out, in, until);
    } catch (const CommandLost&) {
      if (last) throw out_of_step(cdb, "busy, then no answer, three times");
    } catch (const DeviceError& error) {
      if (error.kind() == DeviceError::Kind::kDisconnected) throw;
      // A unit that still waits for the data of a broken command takes the next one for it.
      if (attempt > 1) reset();
      resynchronise();
      if (last || !cdb.repeatable() || clock_.now() >= until) throw;
    }
  }
}

ScsiReply NikonUsbScsi::transact_once(const Cdb& cdb, ByteView out, std::span<std::byte> in,
                                      TimePoint until) {
  usb_.bulk_out(kOut, cdb.bytes(), remaining(until));
  const std::uint8_t phase = query_phase(cdb, until);
  std::size_t received = 0;
  // The unit decides the phase: a command that fails answers "status" although it names a length.
  if (phase == kDataOut && !out.empty()) {
    usb_.bulk_out(kOut, out, remaining(until));
  } else if (phase == kDataIn && !in.empty()) {
    const DataPhase data = read_data(cdb, in, until);
    if (data.status) return *data.status;
    received = data.received;
  } else if (phase != kStatus) {
    throw out_of_step(cdb, "phase " + std::to_string(int{phase}));
  }
  ScsiReply reply = read_status(cdb, until);
  reply.received = received;
  if (reply.good && received != in.size()) throw out_of_step(cdb, "good status without data");
  return reply;
}

std::uint8_t NikonUsbScsi::query_phase(const Cdb& cdb, TimePoint until) {
  if (query_delay_ > Duration(0)) clock_.sleep_for(query_delay_);
  bool was_busy = false;
  for (;;) {
    usb_.bulk_out(kOut, {&kPhaseQuery, 1}, remaining(until));
    // After "busy" a missing answer means that the command was not taken, at any speed: one that
    // follows a query which never arrived is taken for the query.
    const Duration patience =
        full_speed() || was_busy ? std::min(kLostCommand, remaining(until)) : remaining(until);
    std::size_t n = 0;
    try {
      n = usb_.bulk_in(kIn, packet_, patience);
    } catch (const DeviceError& error) {
      if (was_busy && error.kind() == DeviceError::Kind::kTimeout && clock_.now() < until) {
        throw CommandLost{};
      }
      throw;
    }
    if (n != 1) throw out_of_step(cdb, "a phase of " + std::to_string(n) + " bytes");
    const std::uint8_t phase = u8_at(packet_, 0);
    if (phase != kBusy) return phase;
    was_busy = true;
    if (full_speed()) query_delay_ = std::min(query_delay_ + kQueryDelayStep, kMaxQueryDelay);
    if (clock_.now() >= until) {
      throw DeviceError(DeviceError::Kind::kTimeout,
                        "The scanner stays busy and does not take the command. Switch it off, wait "
                        "ten seconds and switch it on again.",
                        cdb.describe() + ": busy until the deadline");
    }
    clock_.sleep_for(kBusyPoll);
  }
}

NikonUsbScsi::DataPhase NikonUsbScsi::read_data(const Cdb& cdb, std::span<std::byte> in,
                                                TimePoint until) {
  std::size_t done = 0;
  while (done < in.size()) {
    const std::size_t missing = in.size() - done;
    const std::size_t packets = (missing + max_packet_bytes_ - 1) / max_packet_bytes_;
    const std::size_t ask = std::min(packets * max_packet_bytes_, kMaxTransferBytes);
    if (staging_.size() < ask) staging_.resize(ask);
    const std::size_t n = usb_.bulk_in(kIn, std::span(staging_).first(ask), remaining(until));
    const ByteView came = std::span(staging_).first(n);
    // A short transfer is not the end of the data, unless it ends with a status that says so. An
    // empty one stands before such a status where the data filled its packets.
    const std::optional<ScsiReply> early =
        n < missing ? early_status(came, max_packet_bytes_) : std::nullopt;
    if (early || n == 0) {
      const std::size_t used = n == 0 ? 0 : n - kStatusBytes;
      std::copy_n(staging_.begin(), used, in.begin() + static_cast<std::ptrdiff_t>(done));
      ScsiReply status = early ? *early : read_status(cdb, until);
      if (status.good || !status.sense.short_read) {
        throw out_of_step(cdb, "data ended after " + std::to_string(done) + " bytes");
      }
      status.received = done + used;
      return {status.received, status};
    }
    // The last packet may be padded to its full size; its tail is dropped.
    const std::size_t used = std::min(n, missing);
    std::copy_n(staging_.begin(), used, in.begin() + static_cast<std::ptrdiff_t>(done));
    done += used;
  }
  return {done, std::nullopt};
}

ScsiReply NikonUsbScsi::read_status(const Cdb& cdb, TimePoint until) {
  const std::size_t n = usb_.bulk_in(kIn, packet_, remaining(until));
  if (n < kStatusBytes) throw out_of_step(cdb, "a status of " + std::to_string(n) + " bytes");
  const std::uint8_t status = u8_at(packet_, 0);
  if (status != 0x00 && status != 0x02) {
    throw out_of_step(cdb, "status " + hex_of(std::span(packet_).first(kStatusBytes)));
  }
  return reply_of(ByteView(packet_).first(kStatusBytes));
}

void NikonUsbScsi::resynchronise() {
  try {
    usb_.clear_halt(kIn);
    usb_.clear_halt(kOut);
    std::vector<std::byte> stale(16 * max_packet_bytes_);
    for (std::size_t drained = 0; drained < kMaxDrainBytes;) {
      const std::size_t n = usb_.bulk_in(kIn, stale, kDrainTimeout);
      if (n == 0) return;
      drained += n;
    }
  } catch (const DeviceError&) {
    // A timeout says that the pipe is empty; any other failure shows at the next command.
  }
}

void NikonUsbScsi::reset() {
  try {
    usb_.reset();
  } catch (const DeviceError&) {
    // The next command tells whether the unit is still there.
  }
}

Duration NikonUsbScsi::remaining(TimePoint until) const {
  return std::max(until - clock_.now(), Duration(1ms));
}

}  // namespace reseau
