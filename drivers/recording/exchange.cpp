#include "drivers/recording/exchange.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/usb_descriptors.h"

namespace reseau {
namespace {

// Nikon's wrapper: LS-5000 interface specification, USB.
constexpr std::byte kPhaseQuery{0xD0};
constexpr std::byte kStatusRequest{0x06};

bool is_command(const UsbTransfer& transfer) {
  return transfer.type == UsbTransferType::kBulk && !transfer.in() &&
         (transfer.data.size() == 6 || transfer.data.size() == 10);
}

// Ports of a PIE bridge: the sequence that opens the command port, the port itself, its status.
constexpr std::uint8_t kKnockPort = 0x88, kBridgeCommandPort = 0x85, kBridgeStatusPort = 0x84;

std::uint8_t port_of(const UsbTransfer& transfer) { return u8_at(*transfer.setup, 2); }

bool writes_vendor_port(const UsbTransfer& transfer) {
  return transfer.type == UsbTransferType::kControl && transfer.setup &&
         is_vendor_request(*transfer.setup) && u8_at(*transfer.setup, 0) == 0x40;
}

}  // namespace

RecordedDevice find_recorded_device(const std::filesystem::path& path) {
  TransferReader transfers(path);
  std::vector<RecordedDevice> known;
  while (const auto transfer = transfers.next()) {
    auto device = std::find_if(known.begin(), known.end(), [&](const RecordedDevice& k) {
      return k.bus == transfer->bus && k.device == transfer->device;
    });
    if (device == known.end()) {
      known.push_back({transfer->bus, transfer->device, {}});
      device = known.end() - 1;
    }
    if (transfer->type == UsbTransferType::kControl) learn_identity(*transfer, device->identity);
    if (is_command(*transfer) || writes_vendor_port(*transfer)) return *device;
  }
  throw InputError("The recording " + path.string() +
                   " holds no commands to a scanner. Record with --record, or with Wireshark on "
                   "the bus that the scanner is plugged into.");
}

ExchangeReader::ExchangeReader(const std::filesystem::path& path)
    : device_(find_recorded_device(path)), transfers_(path) {
  // The comment is known once the first block was read.
  ahead_ = next_transfer();
  header_ = decode_session_header(transfers_.comment());
}

std::optional<UsbTransfer> ExchangeReader::next_transfer() {
  if (ahead_) return std::exchange(ahead_, std::nullopt);
  while (auto transfer = transfers_.next()) {
    if (transfer->bus == device_.bus && transfer->device == device_.device) return transfer;
  }
  return std::nullopt;
}

void ExchangeReader::add(Exchange& exchange, const UsbTransfer& transfer) {
  exchange.last_packet = transfer.packet_number;
  exchange.ended_us = transfer.ended_us;
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
    const bool knocks = vendor && !next->in() && port_of(*next) == kKnockPort;
    const bool begun = !exchange.command.empty() || !exchange.status.empty();
    if (!first && ((knocks && begun) || !next->comment.empty())) break;
    exchange.last_packet = next->packet_number;
    exchange.ended_us = next->ended_us;
    if (next->status != 0 && exchange.transfer_status == 0) {
      exchange.transfer_status = next->status;
    }
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
    if (writes_vendor_port(*transfer) && port_of(*transfer) == kKnockPort) {
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
    if (!is_command(*transfer)) {
      ++n_stray_;
      continue;
    }
    exchange.number = ++n_exchanges_;
    exchange.command = std::move(transfer->data);
    asked_phase_ = false;
    while (auto more = next_transfer()) {
      // Data of six or ten bytes to the unit looks like a command, but follows phase 2.
      const bool wants_data =
          exchange.wrapper_phase == Exchange::kPhaseOut && exchange.out.empty() && ins_.empty();
      const bool other = more->type != UsbTransferType::kBulk || (is_command(*more) && !wants_data);
      if (other || !more->comment.empty()) {
        ahead_ = std::move(more);
        break;
      }
      add(exchange, *more);
    }
    settle(exchange, ins_);
    return exchange;
  }
  return std::nullopt;
}

}  // namespace reseau
