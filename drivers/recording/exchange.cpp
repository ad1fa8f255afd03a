#include "drivers/recording/exchange.h"

#include <algorithm>
#include <cerrno>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/usb_descriptors.h"

namespace reseau {
namespace {

// Nikon's wrapper: LS-5000 interface specification, USB.
constexpr std::byte kPhaseQuery{0xD0};
constexpr std::byte kStatusRequest{0x06};

// Its status.
constexpr std::uint8_t kBridgeStatusPort = 0x84;

std::uint8_t port_of(const UsbTransfer& transfer) { return u8_at(*transfer.setup, 2); }

// How Linux ends a transfer that its program takes back.
bool was_taken_back(const UsbTransfer& transfer) {
  return transfer.status == -ENOENT || transfer.status == -ECONNRESET;
}

}  // namespace

ExchangeReader::ExchangeReader(const std::filesystem::path& path)
    : device_(find_recorded_device(path)), transfers_(path) {
  // The comment is known once the first block was read.
  ahead_ = next_transfer();
  header_ = decode_session_header(transfers_.comment());
}

std::optional<UsbTransfer> ExchangeReader::next_transfer() {
  if (!aside_.empty() && !exchange_open_) {
    UsbTransfer transfer = std::move(aside_.front());
    aside_.pop_front();
    return transfer;
  }
  if (ahead_) return std::exchange(ahead_, std::nullopt);
  while (auto transfer = transfers_.next()) {
    if (transfer->bus == device_.bus && transfer->device == device_.device) return transfer;
  }
  return std::nullopt;
}

bool ExchangeReader::set_aside(UsbTransfer& transfer) {
  constexpr std::uint8_t kClearFeature = 0x01;
  if (transfer.type != UsbTransferType::kControl || !transfer.setup || !transfer.comment.empty() ||
      is_vendor_request(*transfer.setup) || u8_at(*transfer.setup, 1) == kClearFeature ||
      *transfer.setup == reset_setup()) {
    return false;
  }
  aside_.push_back(std::move(transfer));
  return true;
}

void ExchangeReader::add(Exchange& exchange, const UsbTransfer& transfer) {
  exchange.last_packet = transfer.packet_number;
  exchange.ended_us = transfer.ended_us;
  exchange.cut = exchange.cut || transfer.data.size() < transfer.moved_bytes;
  if (transfer.in() && transfer.data.empty() && was_taken_back(transfer)) {
    // One of several in flight after a short one; a failure only where the answer is missing.
    taken_back_ = transfer.status;
    return;
  }
  if (transfer.status != 0 && exchange.transfer_status == 0) {
    exchange.transfer_status = transfer.status;
  }
  if (transfer.in()) {
    if (asked_phase_ && transfer.data.size() == 1) {
      exchange.wrapper_phase = u8_at(transfer.data, 0);
      asked_phase_ = false;
      return;
    }
    exchange.in_bytes += transfer.moved_bytes;
    ins_.push_back(transfer.data);
    return;
  }
  if (transfer.data.size() == 1 && transfer.data[0] == kPhaseQuery) {
    ++exchange.n_phase_queries;
    asked_phase_ = true;
    return;
  }
  if (transfer.data.size() == 1 && transfer.data[0] == kStatusRequest) return;
  exchange.out.insert(exchange.out.end(), transfer.data.begin(), transfer.data.end());
}

// From the knocking at the command port to the next one: the command, data and status in between.
void ExchangeReader::take_bridge_command(Exchange& exchange, UsbTransfer transfer) {
  exchange.kind = Exchange::Kind::kBridge;
  std::optional<UsbTransfer> next = std::move(transfer);
  for (bool first = true; next; first = false) {
    const bool bulk = next->type == UsbTransferType::kBulk;
    const bool vendor = next->setup && is_vendor_request(*next->setup);
    const bool knocks = vendor && !next->in() && port_of(*next) == kBridgeKnockPort;
    const bool begun = !exchange.command.empty() || !exchange.status.empty();
    if (!first && ((knocks && begun) || !next->comment.empty())) break;
    exchange.last_packet = next->packet_number;
    exchange.ended_us = next->ended_us;
    if (next->status != 0 && exchange.transfer_status == 0) {
      exchange.transfer_status = next->status;
    }
    exchange.cut = exchange.cut || next->data.size() < next->moved_bytes;
    if (bulk) {
      exchange.in_bytes += next->moved_bytes;
      const auto n = static_cast<std::ptrdiff_t>(
          std::min(Exchange::kKeptBytes - exchange.in.size(), next->data.size()));
      exchange.in.insert(exchange.in.end(), next->data.begin(), next->data.begin() + n);
    } else if (vendor && next->in() && port_of(*next) == kBridgeStatusPort) {
      exchange.status = std::move(next->data);
    } else if (vendor && !next->in() && port_of(*next) == kBridgeCommandPort) {
      Bytes& to =
          exchange.command.size() < Exchange::kBridgeCdbBytes ? exchange.command : exchange.out;
      to.insert(to.end(), next->data.begin(), next->data.end());
    }
    next = next_transfer();
  }
  ahead_ = std::move(next);
}

// The last IN transfer is the status block, what came before it is data.
void ExchangeReader::settle(Exchange& exchange, std::vector<Bytes>& ins) {
  // Without a data phase it may be padded to a whole packet.
  const bool data_first = exchange.wrapper_phase.value_or(Exchange::kPhaseIn) == Exchange::kPhaseIn;
  if (!ins.empty() && ins.back().size() >= Exchange::kStatusBytes &&
      (ins.back().size() == Exchange::kStatusBytes || !data_first)) {
    exchange.in_bytes -= ins.back().size();
    ins.back().resize(Exchange::kStatusBytes);
    exchange.status = std::move(ins.back());
    ins.pop_back();
  }
  for (const Bytes& piece : ins) {
    const std::size_t room = Exchange::kKeptBytes - exchange.in.size();
    const auto n = static_cast<std::ptrdiff_t>(std::min(room, piece.size()));
    exchange.in.insert(exchange.in.end(), piece.begin(), piece.begin() + n);
  }
  ins.clear();
}

std::optional<Exchange> ExchangeReader::next() {
  while (auto transfer = next_transfer()) {
    if (!transfer->comment.empty()) phase_ = transfer->comment;
    Exchange exchange;
    exchange.first_packet = exchange.last_packet = transfer->packet_number;
    exchange.started_us = transfer->started_us;
    exchange.ended_us = transfer->ended_us;
    exchange.phase = phase_;
    exchange.transfer_status = transfer->status;
    if (writes_bridge_port(*transfer) && port_of(*transfer) == kBridgeKnockPort) {
      exchange.number = ++n_exchanges_;
      take_bridge_command(exchange, std::move(*transfer));
      return exchange;
    }
    if (transfer->type == UsbTransferType::kControl && transfer->setup) {
      exchange.kind = Exchange::Kind::kControl;
      exchange.number = ++n_exchanges_;
      exchange.command.assign(transfer->setup->begin(), transfer->setup->end());
      Bytes& data = (u8_at(*transfer->setup, 0) & 0x80) != 0 ? exchange.in : exchange.out;
      data = std::move(transfer->data);
      exchange.in_bytes = exchange.in.size();
      return exchange;
    }
    if (!is_scsi_command(*transfer)) {
      ++n_stray_;
      continue;
    }
    exchange.number = ++n_exchanges_;
    exchange.command = std::move(transfer->data);
    asked_phase_ = false;
    taken_back_ = 0;
    exchange_open_ = true;
    while (auto more = next_transfer()) {
      if (set_aside(*more)) continue;
      // Data of six or ten bytes to the unit looks like a command, but follows phase 2.
      const bool wants_data =
          exchange.wrapper_phase == Exchange::kPhaseOut && exchange.out.empty() && ins_.empty();
      const bool other =
          more->type != UsbTransferType::kBulk || (is_scsi_command(*more) && !wants_data);
      if (other || !more->comment.empty()) {
        ahead_ = std::move(more);
        break;
      }
      add(exchange, *more);
    }
    exchange_open_ = false;
    settle(exchange, ins_);
    if (exchange.status.empty() && exchange.transfer_status == 0) {
      exchange.transfer_status = taken_back_;
    }
    return exchange;
  }
  return std::nullopt;
}

}  // namespace reseau
