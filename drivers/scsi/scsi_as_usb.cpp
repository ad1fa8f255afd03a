#include "drivers/scsi/scsi_as_usb.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace reseau {
namespace {

constexpr std::uint16_t kNikon = 0x04B0;
constexpr std::byte kQueryOfPhase{0xD0};
enum PhaseByte : int { kStatusPhase = 1, kOutPhase = 2, kInPhase = 3 };

bool sends_data(std::uint8_t opcode) {
  return opcode == 0x15 || opcode == 0x1B || opcode == 0x24 || opcode == 0x2A || opcode == 0xE0;
}

std::size_t length_of(ByteView cdb) {
  // TEST UNIT READY, RESERVE, EXECUTE … name no length: their fourth byte is 0.
  return cdb.size() == 6 ? u8_at(cdb, 4) : static_cast<std::size_t>(load_be(cdb, 6, 3));
}

}  // namespace

ScsiAsUsb::ScsiAsUsb(ScsiLink link) : link_(std::move(link)) {
  identity_.vendor_id = kNikon;
  identity_.product_id = kScsiProductId;
  identity_.serial = link_.serial;
}

void ScsiAsUsb::answer(const ScsiReply& reply, Bytes data) {
  if (!data.empty()) {
    answers_.push_back(bytes_of({kInPhase}));
    answers_.push_back(std::move(data));
  } else if (!wants_data_) {
    answers_.push_back(bytes_of({kStatusPhase}));
  }
  const Sense& s = reply.sense;
  answers_.push_back(reply.good ? Bytes(8)
                                : bytes_of({0x02, s.key | (s.short_read ? 0x20 : 0), s.asc, s.ascq,
                                            s.tsc, 0, 0, 0}));
}

void ScsiAsUsb::bulk_out(Endpoint /*endpoint*/, std::span<const std::byte> data, Duration timeout) {
  if (data.empty()) return;
  if (wants_data_) {
    const ScsiReply reply = link_.device->send(Cdb(cdb_), data, timeout);
    answer(reply, {});
    wants_data_ = false;
    cdb_.clear();
    return;
  }
  if (cdb_.empty()) {
    if (data.size() == 6 || data.size() == 10) cdb_.assign(data.begin(), data.end());
    return;
  }
  if (data.size() != 1 || data[0] != kQueryOfPhase) return;
  const Cdb cdb(cdb_);
  const std::size_t length = length_of(cdb_);
  if (sends_data(cdb.opcode()) && length > 0) {
    answers_.push_back(bytes_of({kOutPhase}));
    wants_data_ = true;
    return;
  }
  cdb_.clear();
  Bytes in(sends_data(cdb.opcode()) || cdb.opcode() == 0x1D ? 0 : length);
  const ScsiReply reply =
      in.empty() ? link_.device->command(cdb, timeout) : link_.device->receive(cdb, in, timeout);
  in.resize(in.empty() ? 0 : reply.received);
  answer(reply, std::move(in));
}

std::size_t ScsiAsUsb::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                               Duration /*timeout*/) {
  if (answers_.empty()) {
    throw DeviceError(DeviceError::Kind::kTimeout, "The scanner did not answer in time.",
                      "endpoint " + std::to_string(endpoint));
  }
  Bytes& head = answers_.front();
  const std::size_t n = std::min(buffer.size(), head.size());
  std::copy_n(head.begin(), n, buffer.begin());
  head.erase(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(n));
  if (head.empty()) answers_.pop_front();
  return n;
}

void ScsiAsUsb::reset() {
  answers_.clear();
  cdb_.clear();
  wants_data_ = false;
}

}  // namespace reseau
