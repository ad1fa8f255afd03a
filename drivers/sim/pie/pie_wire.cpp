#include "drivers/sim/pie/pie_wire.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/usb_error.h"

namespace reseau::sim::pie {
namespace {

constexpr Endpoint kPieBulkIn = 0x81;
constexpr std::uint8_t kGood = 0x00, kDataReady = 0x01, kCheck = 0x02, kBusy = 0x03, kAgain = 0x08;
constexpr int kAnyValue = -1;
constexpr std::size_t kMostAnnounced = 32 * 1024;

struct Knock {
  int port, value;
};
// What makes the command port listen.
constexpr std::array<Knock, 11> kKnocks{{{0x88, 0xff},
                                         {0x88, 0xaa},
                                         {0x88, 0x55},
                                         {0x88, 0x00},
                                         {0x88, 0xff},
                                         {0x88, 0x87},
                                         {0x88, 0x78},
                                         {0x88, kAnyValue},
                                         {0x87, 0x05},
                                         {0x87, 0x04},
                                         {0x88, 0xff}}};
constexpr std::size_t kModeKnock = 7;
constexpr std::uint8_t kScsi = 0xe0, kBridgeReset = 0x30;

// What a person reads is what a real unit's failure would say.
DeviceError bridge_error(DeviceError::Kind kind, const std::string& what, Endpoint endpoint) {
  return {kind, transfer_error(status_of(kind), endpoint, 0).what(),
          "simulated unit, endpoint " + std::to_string(endpoint) + ": " + what};
}

}  // namespace

PieUsb::PieUsb(const PieModel& model, const SimSpec& spec)
    : faults_(spec.unit), unit_(model, spec) {
  identity_.vendor_id = kGenesysVendor;
  identity_.product_id = model.product_id;
  identity_.bcd_device = 0x0100;
  identity_.bulk_in = kPieBulkIn;
  if (spec.unit.full_speed) identity_.max_packet_bytes = 64;
  if (spec.unit.stale_bytes > 0) {
    // A program died in the middle of a READ: its data wait, and half of its next command came.
    in_.assign(static_cast<std::size_t>(spec.unit.stale_bytes), 0x00);
    announced_ = in_.size();
    status_ = kDataReady;
    selected_ = true;
    cdb_ = {0x08, 0x00, 0x00};
  }
}

void PieUsb::count_transfer(Endpoint endpoint) {
  ++n_transfers_;
  if (faults_.unplug_after > 0 && n_transfers_ > faults_.unplug_after) {
    throw bridge_error(DeviceError::Kind::kDisconnected, "The simulated scanner was unplugged.",
                       endpoint);
  }
  const bool silent = faults_.silent_after > 0 && n_transfers_ > faults_.silent_after;
  const bool late = faults_.timeout_after > 0 && n_transfers_ == faults_.timeout_after;
  if (silent || late || unit_.hung()) {
    throw bridge_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                       endpoint);
  }
  if (faults_.stall_after > 0 && n_transfers_ == faults_.stall_after) {
    throw bridge_error(DeviceError::Kind::kStall, "The simulated scanner halted a transfer.",
                       endpoint);
  }
}

void PieUsb::bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration /*timeout*/) {
  if (data.empty()) return;
  throw bridge_error(DeviceError::Kind::kStall, "The scanner has no such endpoint.", endpoint);
}

void PieUsb::control_out(const ControlRequest& request, std::span<const std::byte> data,
                         Duration /*timeout*/) {
  count_transfer(0x00);
  if (halted_) {
    throw bridge_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                       0x00);
  }
  if (request.type == 0x40 && request.request == 0x0c && data.size() == 1) {
    write_port(request.value, std::to_integer<std::uint8_t>(data[0]));
    return;
  }
  if (request.type == 0x40 && request.request == 0x04 && request.value == 0x82 &&
      data.size() == 8) {
    std::size_t size = 0;
    for (std::size_t i = 8; i-- > 4;) size = size << 8 | std::to_integer<std::size_t>(data[i]);
    announced_ = unit_.model().fragile ? std::min(size, kMostAnnounced) : size;
    return;
  }
  throw bridge_error(DeviceError::Kind::kStall, "The scanner does not know this request.", 0x00);
}

std::size_t PieUsb::control_in(const ControlRequest& request, std::span<std::byte> buffer,
                               Duration /*timeout*/) {
  count_transfer(0x80);
  if (halted_) {
    throw bridge_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                       0x80);
  }
  if (request.type != 0xc0 || request.request != 0x0c || request.value != 0x84 || buffer.empty()) {
    throw bridge_error(DeviceError::Kind::kStall, "The scanner does not know this request.", 0x80);
  }
  if (busy_left_ > 0) {
    --busy_left_;
    buffer[0] = std::byte{kBusy};
  } else {
    buffer[0] = std::byte{status_};
  }
  constexpr std::byte kNoise{0xa5};
  if (faults_.garbage_after > 0 && ++n_statuses_ == faults_.garbage_after) buffer[0] = kNoise;
  return short_now() ? 0 : 1;
}

void PieUsb::write_port(int port, std::uint8_t value) {
  if (port == 0x87 || port == 0x88) return knock(port, value);
  if (port == 0x85 && selected_) take_command_byte(value);
}

void PieUsb::knock(int port, std::uint8_t value) {
  const auto fits = [&](std::size_t i) {
    return kKnocks[i].port == port && (kKnocks[i].value == kAnyValue || kKnocks[i].value == value);
  };
  if (!fits(n_knocks_)) n_knocks_ = 0;
  if (!fits(n_knocks_)) return;
  if (n_knocks_ == kModeKnock) knocked_mode_ = value;
  if (++n_knocks_ < kKnocks.size()) return;
  n_knocks_ = 0;
  // Whatever was under way is forgotten.
  cdb_.clear();
  out_.clear();
  in_.clear();
  in_sent_ = announced_ = out_wanted_ = 0;
  busy_left_ = 0;
  silent_ = false;
  status_ = kGood;
  selected_ = knocked_mode_ == kScsi;
  if (knocked_mode_ == kBridgeReset && unit_.model().fragile) unit_.hang();
}

void PieUsb::take_command_byte(std::uint8_t value) {
  if (out_wanted_ > 0) {
    put8(out_, value);
    if (out_.size() < out_wanted_) return;
    status_ = unit_.data_out(out_).good() ? kGood : kCheck;
    out_wanted_ = 0;
    selected_ = false;
    return;
  }
  put8(cdb_, value);
  if (cdb_.size() == 6) execute();
}

void PieUsb::execute() {
  PieReply reply = unit_.command(cdb_);
  cdb_.clear();
  busy_left_ = reply.busy_polls;
  selected_ = reply.next == PieReply::Next::kDataOut;
  if (reply.again) {
    status_ = kAgain;
    return;
  }
  switch (reply.next) {
    case PieReply::Next::kDone:
      status_ = reply.sense.good() ? kGood : kCheck;
      return;
    case PieReply::Next::kDataOut:
      status_ = kGood;
      out_wanted_ = reply.out_bytes;
      out_.clear();
      return;
    case PieReply::Next::kDataIn:
      status_ = kDataReady;
      in_ = std::move(reply.in);
      in_sent_ = announced_ = 0;
      silent_ = reply.silent;
      return;
  }
}

std::size_t PieUsb::bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration /*timeout*/) {
  count_transfer(endpoint);
  if (endpoint != kPieBulkIn) {
    throw bridge_error(DeviceError::Kind::kStall, "The scanner has no such endpoint.", endpoint);
  }
  std::size_t n = std::min({buffer.size(), announced_, in_.size() - in_sent_});
  if (faults_.fragment_bytes > 0) {
    n = std::min(n, static_cast<std::size_t>(faults_.fragment_bytes));
  }
  if (halted_ || silent_ || n == 0) {
    halted_ = true;
    throw bridge_error(DeviceError::Kind::kTimeout, "The simulated scanner did not answer in time.",
                       endpoint);
  }
  const auto* const from = reinterpret_cast<const std::byte*>(in_.data() + in_sent_);
  std::copy_n(from, n, buffer.begin());
  in_sent_ += n;
  announced_ -= n;
  if (in_sent_ == in_.size()) status_ = kGood;
  return short_now() ? n / 2 : n;
}

bool PieUsb::short_now() const {
  return faults_.short_after > 0 && n_transfers_ == faults_.short_after;
}

void PieUsb::clear_halt(Endpoint endpoint) {
  if (endpoint == kPieBulkIn) halted_ = false;
}

void PieUsb::reset() {
  // A port reset makes such a unit vanish until it is switched off.
  if (unit_.model().fragile) unit_.hang();
  halted_ = selected_ = false;
  n_knocks_ = 0;
}

}  // namespace reseau::sim::pie
