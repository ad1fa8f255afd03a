#include "drivers/sim/simulated_sg.h"

#include <algorithm>

#include "core/base/error.h"

namespace reseau::sim {
namespace {

enum HostStatus : int { kNoConnect = 1, kTimeOut = 3, kBusError = 7 };

ByteView bytes_of(reseau::ByteView bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

void put_sense(const Sense& sense, std::size_t residual, SgExchange& e) {
  constexpr std::size_t kSenseBytes = 19;
  e.status = 0x02;
  e.sense.fill(std::byte{0});
  e.sense[0] = std::byte{0x70};
  e.sense[2] = static_cast<std::byte>(sense.key | (sense.ili ? 0x20 : 0));
  if (sense.ili) {
    e.sense[0] = std::byte{0xf0};
    for (std::size_t i = 0; i < 4; ++i) {
      e.sense[3 + i] = static_cast<std::byte>(residual >> (8 * (3 - i)) & 0xff);
    }
  }
  e.sense[7] = std::byte{0x0b};
  e.sense[12] = static_cast<std::byte>(sense.asc);
  e.sense[13] = static_cast<std::byte>(sense.ascq);
  e.sense[15] = static_cast<std::byte>(sense.tsc);
  e.sense_bytes = kSenseBytes;
}

}  // namespace

SimulatedSg::SimulatedSg(const SimSpec& spec) : faults_(spec.unit), unit_(spec, 0) {}

void SimulatedSg::exchange(SgExchange& e) {
  ++n_commands_;
  const auto struck = [this](int at) { return at > 0 && n_commands_ == at; };
  const auto past = [this](int at) { return at > 0 && n_commands_ > at; };
  e.status = 0;
  e.host_status = 0;
  e.residual_bytes = e.in.size();
  if (past(faults_.unplug_after)) {
    e.host_status = kNoConnect;
  } else if (past(faults_.silent_after) || struck(faults_.timeout_after)) {
    e.host_status = kTimeOut;
  } else if (struck(faults_.stall_after)) {
    e.host_status = kBusError;
  }
  if (e.host_status != 0) return;

  CommandReply reply = unit_.command(bytes_of(e.cdb));
  Sense sense = reply.sense;
  if (reply.next == CommandReply::Next::kDataOut) {
    Bytes data(bytes_of(e.out).begin(), bytes_of(e.out).end());
    data.resize(reply.out_bytes, 0);
    sense = unit_.data_out(data);
  } else if (reply.next == CommandReply::Next::kDataIn) {
    std::size_t n = std::min(reply.in.size(), e.in.size());
    if (struck(faults_.short_after)) n /= 2;
    std::copy_n(reinterpret_cast<const std::byte*>(reply.in.data()), n, e.in.begin());
    e.residual_bytes = e.in.size() - n;
  }
  if (!sense.good()) put_sense(sense, e.residual_bytes, e);
  if (struck(faults_.garbage_after)) {
    e.status = 0x02;
    e.sense.fill(std::byte{0xa5});
    e.sense_bytes = e.sense.size();
  }
}

}  // namespace reseau::sim
