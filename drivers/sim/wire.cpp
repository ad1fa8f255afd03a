#include "drivers/sim/wire.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace reseau::sim {
namespace {

constexpr std::uint8_t kPhaseQuery = 0xd0;

DeviceError wire_error(DeviceError::Kind kind, const std::string& sentence, Endpoint endpoint) {
  return {kind, sentence, "simulated unit, endpoint " + std::to_string(endpoint)};
}

// A unit has one CDB length per opcode group; anything else is no command.
bool is_cdb(ByteView data) { return data.size() == 6 || data.size() == 10; }

}  // namespace

SimulatedUsb::SimulatedUsb(const SimSpec& spec) : faults_(spec.unit), unit_(spec) {
  identity_.vendor_id = 0x04b0;
  identity_.product_id = unit_.model().product_id;
  identity_.bcd_device = unit_.model().bcd_device;
  identity_.max_packet_bytes = kPacketBytes;
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
  switch (state_) {
    case State::kIdle:
      // Short packets are dropped here: a late 06, or a query nobody asked for.
      if (!is_cdb(bytes)) return;
      reply_ = unit_.command(bytes);
      state_ = State::kCommand;
      return;
    case State::kCommand:
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
      answer(std::move(reply_.in));
      // UNVERIFIED(no recording shows it): a reply that is short and fills its last packet is
      // ended by an empty one.
      if (reply_.sense.ili && answers_.back().bytes.size() % kPacketBytes == 0) answer({});
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

void SimulatedUsb::answer_status(const Sense& sense) {
  const auto block = sense.status_block();
  answer(Bytes(block.begin(), block.end()));
  state_ = State::kIdle;
}

std::size_t SimulatedUsb::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                  Duration /*timeout*/) {
  count_transfer(endpoint);
  if (endpoint != kBulkIn) {
    throw wire_error(DeviceError::Kind::kStall, "The endpoint only receives.", endpoint);
  }
  const bool silent = faults_.silent_after > 0 && n_transfers_ > faults_.silent_after;
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
    const auto packet = static_cast<std::size_t>(kPacketBytes);
    if (head.sent < head.bytes.size()) {
      if (head.sent % packet == 0) break;
      // The host's buffer ended inside a packet; the rest of that packet is lost.
      head.sent = std::min(head.bytes.size(), (head.sent / packet + 1) * packet);
      if (head.sent == head.bytes.size()) answers_.pop_front();
      throw wire_error(DeviceError::Kind::kProtocol,
                       "The simulated scanner sent more than was asked for.", endpoint);
    }
    const bool short_packet = head.bytes.size() % packet != 0 || head.bytes.empty();
    answers_.pop_front();
    if (short_packet) break;
  }
  return received;
}

void SimulatedUsb::clear_halt(Endpoint endpoint) { halted_[endpoint == kBulkIn ? 1 : 0] = false; }

void SimulatedUsb::reset() {
  answers_.clear();
  state_ = State::kIdle;
  halted_ = {};
}

}  // namespace reseau::sim
