#include "drivers/sim/wire.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/usb_error.h"

namespace reseau::sim {
namespace {

constexpr std::uint8_t kPhaseQuery = 0xd0;
constexpr std::uint8_t kStatusRequest = 0x06;

// What a person reads is what a real unit's failure would say.
DeviceError wire_error(DeviceError::Kind kind, const std::string& what, Endpoint endpoint) {
  return {kind, transfer_error(status_of(kind), endpoint, 0).what(),
          "simulated unit, endpoint " + std::to_string(endpoint) + ": " + what};
}

int packet_bytes_of(const SimSpec& spec) {
  constexpr int kFullSpeedPacket = 64;
  return spec.unit.full_speed ? kFullSpeedPacket : unit_model(spec.model).packet_bytes();
}

// A unit has one CDB length per opcode group; anything else is no command.
bool is_cdb(ByteView data) { return data.size() == 6 || data.size() == 10; }

}  // namespace

SimulatedUsb::SimulatedUsb(const SimSpec& spec)
    : faults_(spec.unit), unit_(spec, packet_bytes_of(spec)) {
  identity_.vendor_id = 0x04b0;
  identity_.product_id = unit_.model().product_id;
  identity_.bcd_device = unit_.model().bcd_device;
  identity_.max_packet_bytes = packet_bytes_of(spec);
  if (spec.unit.stale_bytes > 0) {
    answer(Bytes(static_cast<std::size_t>(spec.unit.stale_bytes), 0x00));
  }
}

void SimulatedUsb::count_transfer(Endpoint endpoint) {
  ++n_transfers_;
  if (endpoint != kBulkOut && endpoint != kBulkIn) {
    throw wire_error(DeviceError::Kind::kStall, "The scanner has no such endpoint.", endpoint);
  }
  if (faults_.unplug_after > 0 && n_transfers_ > faults_.unplug_after) {
    throw wire_error(DeviceError::Kind::kDisconnected, "The simulated scanner was unplugged.",
                     endpoint);
  }
  bool& halted = halted_[endpoint == kBulkIn ? 1 : 0];
  if (faults_.stall_after > 0 && n_transfers_ == faults_.stall_after) halted = true;
  if (faults_.timeout_after > 0 && n_transfers_ == faults_.timeout_after) {
    throw wire_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                     endpoint);
  }
  if (halted) {
    throw wire_error(DeviceError::Kind::kStall, "The simulated scanner halted a transfer.",
                     endpoint);
  }
}

void SimulatedUsb::bulk_out(Endpoint endpoint, std::span<const std::byte> data,
                            Duration /*timeout*/) {
  if (data.empty()) return;
  count_transfer(endpoint);
  if (endpoint != kBulkOut) {
    throw wire_error(DeviceError::Kind::kStall, "The endpoint only sends.", endpoint);
  }
  const ByteView bytes(reinterpret_cast<const std::uint8_t*>(data.data()), data.size());
  if (unit_.model().hates_status_request && bytes.size() == 1 && bytes[0] == kStatusRequest) {
    silent_ = true;
  }
  if (silent_) return;
  switch (state_) {
    case State::kIdle:
      // Short packets are dropped here: a late 06, or a query nobody asked for.
      if (!is_cdb(bytes)) return;
      ++n_commands_;
      lost_ = unit_.model().loses_busy_commands && faults_.lost_commands > 0 &&
              n_commands_ % faults_.lost_commands == 0;
      if (!lost_) reply_ = unit_.command(bytes);
      state_ = State::kCommand;
      return;
    case State::kCommand:
      if (lost_) {
        // The query came before the firmware had taken the command; later ones get no answer.
        answer({kPhaseBusy});
        state_ = State::kIdle;
        return;
      }
      if (bytes.size() == 1 && bytes[0] == kPhaseQuery) {
        query_phase();
      } else {
        answer({kPhaseBusy});
        state_ = State::kIdle;
      }
      return;
    case State::kDataOut:
      take_data(bytes);
      return;
  }
}

void SimulatedUsb::query_phase() {
  if (reply_.busy_phases > 0) {
    --reply_.busy_phases;
    answer({kPhaseBusy});
    return;
  }
  switch (reply_.next) {
    case CommandReply::Next::kStatus:
      answer({kPhaseStatus});
      answer_status(reply_.sense);
      return;
    case CommandReply::Next::kDataIn:
      answer({kPhaseDataIn});
      answer_data(std::move(reply_.in));
      // UNVERIFIED(no recording shows it): a reply that is short and fills its last packet is
      // ended by an empty one.
      if (reply_.sense.ili &&
          (answers_.empty() ||
           answers_.back().bytes.size() % static_cast<std::size_t>(identity_.max_packet_bytes) ==
               0)) {
        answer({});
      }
      answer_status(reply_.sense);
      return;
    case CommandReply::Next::kDataOut:
      answer({kPhaseDataOut});
      out_data_.clear();
      state_ = State::kDataOut;
      return;
  }
}

void SimulatedUsb::take_data(ByteView data) {
  append(out_data_, data);
  if (out_data_.size() < reply_.out_bytes) return;
  out_data_.resize(reply_.out_bytes);
  answer_status(unit_.data_out(out_data_));
}

void SimulatedUsb::answer_data(Bytes bytes) {
  const std::size_t line = reply_.line_bytes;
  if (!unit_.model().line_per_transfer || line == 0) {
    if (!bytes.empty()) answer(std::move(bytes));
    return;
  }
  for (std::size_t at = 0; at < bytes.size(); at += line) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto n = static_cast<std::ptrdiff_t>(std::min(line, bytes.size() - at));
    answers_.push_back({Bytes(begin, begin + n), 0, true});
  }
}

void SimulatedUsb::answer_status(const Sense& sense) {
  auto block = sense.status_block();
  if (faults_.garbage_after > 0 && ++n_statuses_ == faults_.garbage_after) {
    block = {0x5a, 0xff, 0xa5, 0x7e, 0x81, 0x3c, 0xc3, 0x99};
  }
  answer(Bytes(block.begin(), block.end()));
  state_ = State::kIdle;
}

std::size_t SimulatedUsb::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                  Duration /*timeout*/) {
  count_transfer(endpoint);
  if (endpoint != kBulkIn) {
    throw wire_error(DeviceError::Kind::kStall, "The endpoint only receives.", endpoint);
  }
  const bool silent = silent_ || (faults_.silent_after > 0 && n_transfers_ > faults_.silent_after);
  if (silent || answers_.empty()) {
    throw wire_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                     endpoint);
  }
  std::size_t room = buffer.size();
  if (faults_.fragment_bytes > 0) {
    room = std::min(room, static_cast<std::size_t>(faults_.fragment_bytes));
  }
  std::size_t received = 0;
  while (received < room && !answers_.empty()) {
    Answer& head = answers_.front();
    const std::size_t left = head.bytes.size() - head.sent;
    const std::size_t n = std::min(room - received, left);
    const auto* from = reinterpret_cast<const std::byte*>(head.bytes.data() + head.sent);
    std::copy_n(from, n, buffer.data() + received);
    received += n;
    head.sent += n;
    const auto packet = static_cast<std::size_t>(identity_.max_packet_bytes);
    if (head.sent < head.bytes.size()) {
      if (head.sent % packet == 0) break;
      // The host's buffer ended inside a packet; the rest of that packet is lost.
      head.sent = std::min(head.bytes.size(), (head.sent / packet + 1) * packet);
      if (head.sent == head.bytes.size()) answers_.pop_front();
      throw wire_error(DeviceError::Kind::kProtocol,
                       "The simulated scanner sent more than was asked for.", endpoint);
    }
    const bool short_packet =
        head.bytes.size() % packet != 0 || head.bytes.empty() || head.ends_transfer;
    answers_.pop_front();
    if (short_packet) break;
  }
  const bool cut = faults_.short_after > 0 && n_transfers_ == faults_.short_after;
  return cut ? received / 2 : received;
}

void SimulatedUsb::clear_halt(Endpoint endpoint) { halted_[endpoint == kBulkIn ? 1 : 0] = false; }

void SimulatedUsb::reset() {
  answers_.clear();
  state_ = State::kIdle;
  halted_ = {};
}

}  // namespace reseau::sim
