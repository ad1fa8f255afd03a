#include "drivers/sessions.h"

#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "drivers/pieusb/models.h"
#include "drivers/pieusb/replies.h"
#include "drivers/pieusb/sense.h"
#include "drivers/recording/exchange.h"
#include "drivers/recording/exchange_text.h"
#include "drivers/recording/rewrite.h"

namespace reseau {
namespace {

std::string id_text(const UsbIdentity& identity) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x", unsigned{identity.vendor_id},
                unsigned{identity.product_id});
  return text.data();
}

ShownSession begun(const ExchangeReader& reader) {
  const RecordedDevice& device = reader.device();
  const SessionHeader& header = reader.header();
  return {id_text(device.identity), device.identity.serial, header.device_name,
          header.started_at_utc, 0};
}

// What a command ended with. A request to the host, a state that changed and a remark are no
// refusals: the driver answers them and goes on.
void count_sense(const Sense& sense, SessionCheck& check) {
  switch (static_cast<SenseKey>(sense.key)) {
    case SenseKey::kNotReady:
      ++check.n_not_ready;
      return;
    case SenseKey::kGood:
    case SenseKey::kRecovered:
    case SenseKey::kUnitAttention:
    case SenseKey::kHostAction:
      return;
    default:
      ++check.n_refused;
  }
}

// A bridge says only that there is something to say; REQUEST SENSE, which comes next, says what.
class BridgeRefusals {
 public:
  void add(const Exchange& e, SessionCheck& check) {
    constexpr std::byte kRequestSense{0x03}, kRead{0x08};
    if (e.kind != Exchange::Kind::kBridge || e.command.empty()) return;
    if (std::exchange(asked_, false) && e.command[0] == kRequestSense &&
        e.in.size() >= pieusb::kSenseBytes) {
      const Sense sense = pieusb::parse_sense(e.in);
      if (!(after_read_ && pieusb::no_more_lines(sense))) count_sense(sense, check);
      return;
    }
    asked_ = !e.status.empty() && u8_at(e.status, 0) == Exchange::kBridgeCheck;
    after_read_ = e.command[0] == kRead;
  }

 private:
  bool asked_ = false, after_read_ = false;
};

// A command with a data phase that its answer does not fill, or without an answer.
void check_exchange(const Exchange& e, SessionCheck& check) {
  constexpr std::size_t kProblemsShown = 20;
  const auto problem = [&](const std::string& what) {
    if (check.problems.size() > kProblemsShown) return;
    if (check.problems.size() == kProblemsShown) {
      check.problems.emplace_back("There is more that is not listed here.");
      return;
    }
    check.problems.push_back("Command " + std::to_string(e.number) + " (packet " +
                             std::to_string(e.first_packet) + ", " + name_of(e) + "): " + what);
  };
  if (e.transfer_status != 0) {
    ++check.n_failed_transfers;
    return;
  }
  if (e.kind == Exchange::Kind::kControl) return;
  if (e.cut) {
    problem("the capture kept only part of its data; record without a limit of packet size.");
    return;
  }
  if (e.kind == Exchange::Kind::kBridge) {
    if (e.command.empty() || e.status.empty()) {
      problem("it has no status; the capture has a hole or ends here.");
    }
    return;
  }
  if (!e.wrapper_phase) {
    problem("it was never asked for its phase; the capture has a hole or ends here.");
  } else if (*e.wrapper_phase == Exchange::kPhaseOut && e.out.empty()) {
    problem("the unit wanted data, but none was sent.");
  } else if (*e.wrapper_phase == Exchange::kPhaseIn && e.in_bytes == 0) {
    problem("the unit announced data, but none came.");
  } else if (*e.wrapper_phase > Exchange::kPhaseIn || *e.wrapper_phase < Exchange::kPhaseStatus) {
    problem("its phase stayed at " + std::to_string(*e.wrapper_phase) + ".");
  } else if (e.status.empty()) {
    problem("its status is missing; the capture has a hole or ends here.");
  }
  if (const std::optional<Sense> sense = sense_of(e)) count_sense(*sense, check);
}

}  // namespace

ShownSession show_session(const std::filesystem::path& file,
                          const std::function<void(const ShownExchange&)>& each) {
  ExchangeReader reader(file);
  ShownSession session = begun(reader);
  std::int64_t start_us = 0;
  while (const auto e = reader.next()) {
    if (++session.n_exchanges == 1) start_us = e->started_us;
    ShownExchange shown;
    shown.number = e->number;
    shown.first_packet = e->first_packet;
    shown.start_s = static_cast<double>(e->started_us - start_us) / 1e6;
    shown.duration_ms = static_cast<double>(e->ended_us - e->started_us) / 1e3;
    shown.phase = e->phase;
    shown.command_hex = hex_of(e->command);
    shown.command = name_of(*e);
    shown.out_bytes = e->out.size();
    shown.in_bytes = e->in_bytes;
    shown.status_hex = hex_of(e->status);
    shown.outcome = outcome_of(*e);
    shown.good = shown.outcome == "good" || shown.outcome == "done";
    shown.text = text_of(*e, start_us);
    each(shown);
  }
  return session;
}

SessionCheck check_session(const std::filesystem::path& file) {
  ExchangeReader reader(file);
  SessionCheck check;
  check.session = begun(reader);
  const bool is_scsi_bridge = reader.device().identity.vendor_id == pieusb::kGenesysVendorId;
  if (reader.device().identity.vendor_id == 0) {
    check.problems.emplace_back(
        "It does not say which unit it is: its descriptors are missing. Start the capture before "
        "the scanner is plugged in, or record with --record.");
  }
  bool inquired = is_scsi_bridge;
  BridgeRefusals bridge_refusals;
  while (const auto e = reader.next()) {
    ++check.session.n_exchanges;
    constexpr std::byte kInquiry{0x12};
    inquired = inquired || (e->kind == Exchange::Kind::kCommand && e->command[0] == kInquiry);
    check_exchange(*e, check);
    bridge_refusals.add(*e, check);
  }
  if (!inquired) {
    check.problems.emplace_back(
        "The unit was never asked what it is (INQUIRY), so no driver can be opened on it. Start "
        "the capture before the program.");
  }
  // The bridge's bulk data follows control transfers.
  if (reader.n_stray_transfers() > 0 && !is_scsi_bridge) {
    check.problems.push_back(std::to_string(reader.n_stray_transfers()) +
                             " transfers belong to no command: the capture began in the middle of "
                             "one, or has a hole.");
  }
  return check;
}

RewriteResult rewrite_session(const std::filesystem::path& from, const std::filesystem::path& to,
                              const RewriteOptions& options) {
  if (from.extension() != ".jsonl") return rewrite_recording(from, to, options);
  RewriteResult result;
  result.n_exchanges = import_command_lines(from, to);
  return result;
}

}  // namespace reseau
