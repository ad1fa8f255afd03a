#include "drivers/usb/replay_transport.h"

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/usb/usb_descriptors.h"
#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

bool has_cdb_size(ByteView data) { return data.size() == 6 || data.size() == 10; }

std::string in_text(Endpoint endpoint, std::size_t n_bytes) {
  return "IN endpoint " + std::to_string(endpoint & 0x0F) + ", " + std::to_string(n_bytes) +
         " bytes asked";
}

std::string control_text(const UsbSetup& setup, ByteView data) {
  std::string text = "control " + hex_of(setup);
  if (!data.empty()) text += ", data " + hex_of(data);
  return text;
}

}  // namespace

ReplayTransport::ReplayTransport(const std::filesystem::path& path, VirtualClock& clock,
                                 Decoder decode)
    : path_(path),
      device_(find_recorded_device(path)),
      transfers_(path),
      clock_(clock),
      decode_(std::move(decode)),
      clock_start_(clock.now()) {
  find_first_command();
  header_ = decode_session_header(transfers_.comment());
  start_us_ = ahead_.front().started_us;
}

void ReplayTransport::find_first_command() {
  while (auto transfer = transfers_.next()) {
    if (transfer->bus != device_.bus || transfer->device != device_.device) continue;
    if (!is_scsi_command(*transfer) && !writes_bridge_port(*transfer)) continue;
    ahead_.push_back(*std::move(transfer));
    return;
  }
  CHECK(false);  // or there would be no device
}

std::optional<UsbTransfer> ReplayTransport::next_of_device() {
  if (!ahead_.empty()) {
    UsbTransfer transfer = std::move(ahead_.front());
    ahead_.pop_front();
    return transfer;
  }
  while (auto transfer = transfers_.next()) {
    if (transfer->bus != device_.bus || transfer->device != device_.device) continue;
    if (transfer->type == UsbTransferType::kBulk) return transfer;
    if (transfer->type != UsbTransferType::kControl || !transfer->setup) continue;
    const int request = u8_at(*transfer->setup, 1);
    const bool clear_halt = request == 0x01 && u8_at(*transfer->setup, 0) == 0x02;
    if (clear_halt || *transfer->setup == reset_setup() || is_vendor_request(*transfer->setup)) {
      return transfer;
    }
  }
  return std::nullopt;
}

UsbTransfer ReplayTransport::take(const std::string& asked) {
  if (ended_) throw DeviceError(*ended_);
  std::optional<UsbTransfer> transfer = next_of_device();
  if (!transfer) {
    end({DeviceError::Kind::kDisconnected,
         "The recording ends here. It may have been cut off, or the program now does more than it "
         "did when it was recorded.",
         "phase \"" + phase_ + "\", asked: " + asked});
  }
  if (!transfer->comment.empty()) phase_ = transfer->comment;
  ++n_transfers_;
  if (transfer->status == 0 && transfer->data.size() < transfer->moved_bytes) {
    end({DeviceError::Kind::kProtocol,
         "The recording kept only " + std::to_string(transfer->data.size()) + " of " +
             std::to_string(transfer->moved_bytes) + " bytes of packet " +
             std::to_string(transfer->packet_number) +
             ", so it cannot be replayed from here on. Record without a limit of packet size.",
         path_.string()});
  }
  const bool command =
      transfer->type == UsbTransferType::kBulk && !transfer->in() && has_cdb_size(transfer->data);
  if (command) taken_.clear();
  taken_.push_back(*transfer);
  return *std::move(transfer);
}

void ReplayTransport::to_last_command() {
  ahead_.insert(ahead_.begin(), std::make_move_iterator(taken_.begin()),
                std::make_move_iterator(taken_.end()));
  n_transfers_ -= static_cast<long>(taken_.size());
  taken_.clear();
}

void ReplayTransport::bulk_out(Endpoint endpoint, std::span<const std::byte> data,
                               Duration /*timeout*/) {
  if (data.empty()) return;
  const UsbTransfer recorded = take(describe_out(data));
  if (recorded.type != UsbTransferType::kBulk || recorded.endpoint != endpoint ||
      !std::equal(data.begin(), data.end(), recorded.data.begin(), recorded.data.end())) {
    differ(recorded, describe_out(data), data);
  }
  if (has_cdb_size(data)) command_.assign(data.begin(), data.end());
  finish(recorded, data.size());
}

std::size_t ReplayTransport::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                     Duration /*timeout*/) {
  const std::string asked = in_text(endpoint, buffer.size());
  UsbTransfer recorded = take(asked);
  if (recorded.type == UsbTransferType::kBulk && recorded.endpoint == endpoint) {
    take_flight(recorded, buffer.size());
  }
  if (recorded.type != UsbTransferType::kBulk || recorded.endpoint != endpoint ||
      recorded.asked_bytes.value_or(static_cast<std::uint32_t>(buffer.size())) != buffer.size() ||
      recorded.data.size() > buffer.size()) {
    differ(recorded, asked);
  }
  finish(recorded, buffer.size());
  std::copy(recorded.data.begin(), recorded.data.end(), buffer.begin());
  return recorded.data.size();
}

// A capture of the bus shows one read as the transfers that libusb and the kernel made of it.
void ReplayTransport::take_flight(UsbTransfer& first, std::size_t wanted) {
  std::size_t asked = first.asked_bytes.value_or(0);
  while (asked > 0 && asked < wanted && first.status == 0) {
    std::optional<UsbTransfer> next = next_of_device();
    if (!next) return;
    const bool in_flight = next->type == UsbTransferType::kBulk &&
                           next->endpoint == first.endpoint && next->started_us <= first.ended_us &&
                           next->asked_bytes.has_value() && *next->asked_bytes <= wanted - asked;
    if (!in_flight) {
      ahead_.push_front(*std::move(next));
      return;
    }
    asked += *next->asked_bytes;
    first.asked_bytes = static_cast<std::uint32_t>(asked);
    first.moved_bytes += next->moved_bytes;
    first.ended_us = std::max(first.ended_us, next->ended_us);
    first.data.insert(first.data.end(), next->data.begin(), next->data.end());
    // Those behind a short one are taken back, which is no failure.
    if (!next->data.empty() || (next->status != -ENOENT && next->status != -ECONNRESET)) {
      first.status = next->status;
    }
    taken_.push_back(*std::move(next));
  }
}

void ReplayTransport::control_out(const ControlRequest& request, std::span<const std::byte> data,
                                  Duration /*timeout*/) {
  const UsbSetup setup = setup_of_request(request, data.size());
  const std::string asked = control_text(setup, data);
  const UsbTransfer recorded = take(asked);
  if (recorded.type != UsbTransferType::kControl || recorded.setup != setup ||
      !std::equal(data.begin(), data.end(), recorded.data.begin(), recorded.data.end())) {
    differ(recorded, asked);
  }
  if (writes_bridge_port(recorded)) {
    if (request.value == kBridgeKnockPort) bridge_.clear();
    if (request.value == kBridgeCommandPort)
      bridge_.insert(bridge_.end(), data.begin(), data.end());
  }
  finish(recorded, data.size());
}

std::size_t ReplayTransport::control_in(const ControlRequest& request, std::span<std::byte> buffer,
                                        Duration /*timeout*/) {
  const UsbSetup setup = setup_of_request(request, buffer.size());
  const std::string asked = control_text(setup, {});
  const UsbTransfer recorded = take(asked);
  if (recorded.type != UsbTransferType::kControl || recorded.setup != setup ||
      recorded.data.size() > buffer.size()) {
    differ(recorded, asked);
  }
  finish(recorded, buffer.size());
  std::copy(recorded.data.begin(), recorded.data.end(), buffer.begin());
  return recorded.data.size();
}

void ReplayTransport::clear_halt(Endpoint endpoint) {
  control(clear_halt_setup(endpoint), "clear halt of endpoint " + std::to_string(endpoint & 0x0F));
}

void ReplayTransport::reset() { control(reset_setup(), "reset of the device"); }

void ReplayTransport::control(const UsbSetup& setup, const std::string& asked) {
  const UsbTransfer recorded = take(asked);
  if (recorded.type != UsbTransferType::kControl || recorded.setup != setup) {
    differ(recorded, asked);
  }
  finish(recorded, 0);
}

void ReplayTransport::finish(const UsbTransfer& transfer, std::size_t asked_bytes) {
  const Duration since_start(transfer.ended_us - start_us_);
  if (pace_) pace_(since_start);
  clock_.advance_to(clock_start_ + since_start);
  if (transfer.status != 0) throw transfer_error(-transfer.status, transfer.endpoint, asked_bytes);
}

void ReplayTransport::differ(const UsbTransfer& recorded, const std::string& asked, ByteView sent) {
  std::string text = "The program does something else than the recording at transfer " +
                     std::to_string(n_transfers_ - 1) + ", packet " +
                     std::to_string(recorded.packet_number) + " (phase \"" + phase_ +
                     "\"). Recorded: " + describe(recorded) + ". Now: " + asked + ".";
  const bool both_out = !sent.empty() && !recorded.in() &&
                        recorded.type == UsbTransferType::kBulk && !recorded.data.empty();
  if (both_out) {
    const auto [now, then] =
        std::mismatch(sent.begin(), sent.end(), recorded.data.begin(), recorded.data.end());
    const auto byte = [](auto at, auto end) {
      return at == end ? std::string("nothing") : hex_of({&*at, 1});
    };
    text += " They differ from byte " + std::to_string(now - sent.begin()) +
            " on: " + byte(then, recorded.data.end()) + " recorded, " + byte(now, sent.end()) +
            " now.";
  }
  // The command itself where that is new, else the one that the transfer belongs to.
  const Bytes command = has_cdb_size(sent) ? Bytes(sent.begin(), sent.end()) : command_;
  if (!command.empty() && !has_cdb_size(sent) && decode_.name) {
    text += " It belongs to the command " + decode_.name(command) + ".";
  }
  if (!command.empty() && decode_.source) text += " See: " + decode_.source(command) + ".";
  if (command.empty()) text += bridge_command_text(recorded);
  end({DeviceError::Kind::kProtocol, text, path_.string()});
}

std::string ReplayTransport::bridge_command_text(const UsbTransfer& recorded) {
  constexpr std::size_t kCdbBytes = 6;
  const auto for_command = [](const UsbTransfer& transfer) {
    return writes_bridge_port(transfer) && u8_at(*transfer.setup, 2) == kBridgeCommandPort;
  };
  Bytes cdb = bridge_;
  const bool is_new = cdb.size() < kCdbBytes;
  std::optional<UsbTransfer> next = recorded;
  while (next && cdb.size() < kCdbBytes && for_command(*next)) {
    cdb.insert(cdb.end(), next->data.begin(), next->data.end());
    next = next_of_device();
  }
  if (cdb.size() < kCdbBytes || !decode_.bridge_name) return {};
  cdb.resize(kCdbBytes);
  std::string text = is_new ? " The recorded command is " : " It belongs to the command ";
  text += decode_.bridge_name(cdb) + ".";
  if (decode_.bridge_source) text += " See: " + decode_.bridge_source(cdb) + ".";
  return text;
}

void ReplayTransport::end(DeviceError error) {
  ended_ = error;
  throw std::move(error);
}

std::string ReplayTransport::describe_out(ByteView data) const {
  std::string text = "OUT ";
  if (decode_.name && has_cdb_size(data)) return text + decode_.name(data);
  return text + hex_of(data);
}

std::string ReplayTransport::describe(const UsbTransfer& transfer) const {
  if (transfer.type == UsbTransferType::kControl && transfer.setup) {
    return control_text(*transfer.setup, transfer.data);
  }
  if (!transfer.in()) return describe_out(transfer.data);
  return in_text(transfer.endpoint, transfer.asked_bytes.value_or(0)) + ", answer " +
         hex_of(transfer.data);
}

}  // namespace reseau
