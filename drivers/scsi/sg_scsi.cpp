#include "drivers/scsi/sg_scsi.h"

#include <string>

#include "core/base/error.h"

namespace reseau {
namespace {

using namespace std::chrono_literals;

constexpr Duration kBusyTargetPoll = 100ms;

enum Status : std::uint8_t { kGood = 0x00, kCheck = 0x02, kTargetBusy = 0x08, kConflict = 0x18 };
// SG_IO's host status, linux/Documentation/scsi.
enum HostStatus : int {
  kOk = 0,
  kNoConnect = 1,
  kBusBusy = 2,
  kTimeOut = 3,
  kReset = 8,
  kSoftError = 11
};

DeviceError host_error(int host_status, const Cdb& cdb) {
  const std::string detail = cdb.describe() + ": host status " + std::to_string(host_status);
  switch (host_status) {
    case kNoConnect:
      return {DeviceError::Kind::kDisconnected,
              "The scanner is gone. Check its cable and its power, then start again.", detail};
    case kTimeOut:
      return {DeviceError::Kind::kTimeout,
              "The scanner did not answer in time. Try again; if that fails, switch it off, wait "
              "ten seconds and switch it on.",
              detail};
    default:
      return {DeviceError::Kind::kProtocol,
              "The connection to the scanner broke down in the middle of a command. Check the "
              "cable; if it happens again, switch the scanner off and on.",
              detail};
  }
}

}  // namespace

Sense decode_sense_data(ByteView data) {
  Sense sense;
  if (data.size() < 3) return sense;
  const int form = u8_at(data, 0) & 0x7F;
  if (form == 0x72 || form == 0x73) {
    sense.key = u8_at(data, 1) & 0x0F;
    sense.asc = u8_at(data, 2);
    if (data.size() > 3) sense.ascq = u8_at(data, 3);
    return sense;
  }
  // Anything else is no sense data.
  if (form != 0x70 && form != 0x71) return sense;
  const std::uint8_t flags = u8_at(data, 2);
  sense.key = flags & 0x0F;
  sense.short_read = (flags & 0x20) != 0;
  if (data.size() > 13) {
    sense.asc = u8_at(data, 12);
    sense.ascq = u8_at(data, 13);
  }
  if (data.size() > 15) sense.tsc = u8_at(data, 15);
  return sense;
}

ScsiReply SgScsi::command(const Cdb& cdb, Duration timeout) {
  return transact(cdb, {}, {}, timeout);
}

ScsiReply SgScsi::send(const Cdb& cdb, ByteView out, Duration timeout) {
  return transact(cdb, out, {}, timeout);
}

ScsiReply SgScsi::receive(const Cdb& cdb, std::span<std::byte> in, Duration timeout) {
  return transact(cdb, {}, in, timeout);
}

ScsiReply SgScsi::transact(const Cdb& cdb, ByteView out, std::span<std::byte> in,
                           Duration timeout) {
  const TimePoint until = clock_.now() + timeout;
  for (;;) {
    SgExchange e;
    e.cdb = cdb.bytes();
    e.out = out;
    e.in = in;
    e.timeout = std::max(until - clock_.now(), Duration(1s));
    node_->exchange(e);
    // Neither of the two was executed by the unit.
    const bool busy =
        e.host_status == kBusBusy || (e.host_status == kOk && e.status == kTargetBusy);
    if (busy) {
      if (clock_.now() >= until) {
        throw DeviceError(DeviceError::Kind::kBusy,
                          "The scanner stays busy. Wait until it is done; if it does not end, "
                          "switch it off, wait ten seconds and switch it on again.",
                          cdb.describe() + ": BUSY until the deadline");
      }
      clock_.sleep_for(kBusyTargetPoll);
      continue;
    }
    if (e.host_status != kOk) throw host_error(e.host_status, cdb);
    if (e.status == kConflict) {
      throw DeviceError(DeviceError::Kind::kBusy,
                        "Another computer or program has reserved the scanner. Close it there, or "
                        "switch the scanner off and on.",
                        cdb.describe() + ": RESERVATION CONFLICT");
    }
    if (e.status != kGood && e.status != kCheck) {
      throw DeviceError(DeviceError::Kind::kProtocol,
                        "The scanner gave an answer that this program does not understand. Please "
                        "report it.",
                        cdb.describe() + ": SCSI status " + std::to_string(int{e.status}));
    }
    ScsiReply reply;
    reply.good = e.status == kGood;
    if (!reply.good) reply.sense = decode_sense_data(ByteView(e.sense).first(e.sense_bytes));
    if (!reply.good && reply.sense == Sense{}) {
      throw DeviceError(DeviceError::Kind::kProtocol,
                        "The scanner refused a command without saying why. Switch it off, wait ten "
                        "seconds and switch it on again.",
                        cdb.describe() + ": CHECK CONDITION without sense");
    }
    reply.received = in.size() - std::min(in.size(), e.residual_bytes);
    // A refused command moves no data, whatever the host adapter counted.
    if (!reply.good && !reply.sense.short_read && reply.sense.key != 1) reply.received = 0;
    return reply;
  }
}

ScsiLink sg_scsi_link(std::unique_ptr<SgNode> node, Clock& clock) {
  ScsiLink link;
  link.device = std::make_unique<SgScsi>(std::move(node), clock);
  link.description = "SCSI";
  return link;
}

}  // namespace reseau
