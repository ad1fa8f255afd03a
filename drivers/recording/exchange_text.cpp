#include "drivers/recording/exchange_text.h"

#include <array>
#include <cstdio>

#include "drivers/coolscan/explain.h"
#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/replies.h"
#include "drivers/pieusb/sense.h"
#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

constexpr std::size_t kShownBytes = 64;

std::string seconds(std::int64_t us) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.6f s", static_cast<double>(us) / 1e6);
  return text.data();
}

void data_line(std::string& text, const char* direction, std::uint64_t n_bytes, ByteView kept) {
  if (n_bytes == 0) return;
  text.append("  ").append(direction).append(" ").append(std::to_string(n_bytes));
  text += " bytes";
  if (!kept.empty()) text.append(": ").append(hex_of(kept, kShownBytes));
  text += "\n";
}

// Ports' answers: SANE's pieusb backend.
constexpr std::uint8_t kBridgeDone = 0x00, kBridgeData = 0x01;
constexpr std::uint8_t kBridgeBusy = 0x03, kBridgeAgain = 0x08;

std::string bridge_outcome(const Exchange& exchange) {
  if (exchange.command.empty()) return "no command followed";
  if (exchange.status.empty()) return "no status in the recording";
  switch (u8_at(exchange.status, 0)) {
    case kBridgeDone:
    case kBridgeData:
      return "good";
    case Exchange::kBridgeCheck:
      return "refused, or there is something to say: REQUEST SENSE tells";
    case kBridgeBusy:
      return "busy when it was asked last";
    case kBridgeAgain:
      return "not taken: the command has to come again";
    default:
      return "failed, status " + hex_of(exchange.status);
  }
}

}  // namespace

std::string name_of(const Exchange& exchange) {
  switch (exchange.kind) {
    case Exchange::Kind::kControl:
      return "control " + hex_of(exchange.command);
    case Exchange::Kind::kBridge:
      if (exchange.command.size() != Exchange::kBridgeCdbBytes) {
        return "part of a command [" + hex_of(exchange.command) + "]";
      }
      return pieusb::describe(Cdb(exchange.command));
    default:
      return coolscan::name_of_command(exchange.command);
  }
}

std::optional<Sense> sense_of(const Exchange& exchange) {
  if (exchange.status.size() < Exchange::kStatusBytes) return std::nullopt;
  constexpr unsigned kKeyBits = 0x0F, kShortRead = 0x20;
  Sense sense;
  sense.key = static_cast<std::uint8_t>(u8_at(exchange.status, 1) & kKeyBits);
  sense.asc = u8_at(exchange.status, 2);
  sense.ascq = u8_at(exchange.status, 3);
  sense.tsc = u8_at(exchange.status, 4);
  sense.short_read = (u8_at(exchange.status, 1) & kShortRead) != 0;
  return sense;
}

std::string outcome_of(const Exchange& exchange) {
  if (exchange.transfer_status != 0) {
    constexpr Endpoint kBulkOut = 0x01, kBulkIn = 0x82;
    const Endpoint endpoint = exchange.in.empty() ? kBulkOut : kBulkIn;
    return transfer_error(-exchange.transfer_status, endpoint, 0).what();
  }
  if (exchange.kind == Exchange::Kind::kControl) return "done";
  if (exchange.kind == Exchange::Kind::kBridge) return bridge_outcome(exchange);
  const std::optional<Sense> sense = sense_of(exchange);
  if (!sense) return "no status in the recording";
  if (u8_at(exchange.status, 0) == 0 && sense->is(SenseKey::kGood)) return "good";
  return sentence_of(*sense);
}

std::string text_of(const Exchange& exchange, std::int64_t start_us) {
  std::string text = "#" + std::to_string(exchange.number) + "  packet " +
                     std::to_string(exchange.first_packet) + "  " +
                     seconds(exchange.started_us - start_us);
  if (!exchange.phase.empty()) text += "  [" + exchange.phase + "]";
  text += "\n  " + name_of(exchange) + "\n";
  if (exchange.kind == Exchange::Kind::kCommand) {
    for (const std::string& line : coolscan::explain(exchange.command, exchange.out, exchange.in)) {
      text.append("    ").append(line).append("\n");
    }
  }
  constexpr std::byte kRequestSense{0x03};
  if (exchange.kind == Exchange::Kind::kBridge && !exchange.command.empty() &&
      exchange.command[0] == kRequestSense && exchange.in.size() >= pieusb::kSenseBytes) {
    text += "    " + pieusb::pie_sentence(pieusb::parse_sense(exchange.in)) + "\n";
  }
  data_line(text, "sent", exchange.out.size(), exchange.out);
  data_line(text, "received", exchange.in_bytes, exchange.in);
  if (exchange.n_phase_queries > 1) {
    text += "  asked " + std::to_string(exchange.n_phase_queries) + " times for the phase\n";
  }
  return text + "  " + outcome_of(exchange) + "\n";
}

}  // namespace reseau
