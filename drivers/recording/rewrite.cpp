#include "drivers/recording/rewrite.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "drivers/recording/exchange.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/pcapng_writer.h"

namespace reseau {
namespace {

// Shorter ones, or any in picture data, would be found by chance.
constexpr std::size_t kShortestBlank = 4;
constexpr std::size_t kLongestText = Exchange::kKeptBytes;

// Packets [first, last] of a file.
struct PacketSpan {
  std::uint64_t first = 0, last = 0;
};

class Blanker {
 public:
  Blanker(const RewriteOptions& options, const RecordedDevice& device) {
    if (options.blank_serial && !device.identity.serial.empty()) {
      secrets_.push_back(device.identity.serial);
    }
    for (const std::string& text : options.also_blank) {
      if (text.size() < kShortestBlank) {
        throw InputError("\"" + text + "\" is too short to be found without doubt; give at least " +
                         std::to_string(kShortestBlank) + " characters.");
      }
      secrets_.push_back(text);
    }
  }

  // Also as UTF-16, which string descriptors are written in.
  int blank(Bytes& data, UsbTransferType type) const {
    if (data.size() > kLongestText) return 0;
    int n = 0;
    for (const std::string& secret : secrets_) {
      if (type == UsbTransferType::kBulk && secret.size() < kShortestBlank) continue;
      for (const std::size_t step : {std::size_t{1}, std::size_t{2}}) {
        n += blank(data, secret, step);
      }
    }
    return n;
  }

  int blank(std::string& text) const {
    int n = 0;
    for (const std::string& secret : secrets_) {
      for (std::size_t at = 0; (at = text.find(secret, at)) != std::string::npos; ++n) {
        text.replace(at, secret.size(), secret.size(), 'X');
      }
    }
    return n;
  }

 private:
  static int blank(Bytes& data, const std::string& secret, std::size_t step) {
    const std::size_t length = (secret.size() - 1) * step + 1;
    int n = 0;
    for (std::size_t at = 0; at + length <= data.size(); ++at) {
      bool found = true;
      for (std::size_t i = 0; i < secret.size() && found; ++i) {
        found = data[at + i * step] == static_cast<std::byte>(secret[i]) &&
                (step == 1 || i + 1 == secret.size() || data[at + i * step + 1] == std::byte{0});
      }
      if (!found) continue;
      for (std::size_t i = 0; i < secret.size(); ++i) data[at + i * step] = std::byte{'X'};
      ++n;
    }
    return n;
  }

  std::vector<std::string> secrets_;
};

// Asked of every USB device, not of a scanner.
bool is_standard_request(const Exchange& exchange) {
  constexpr unsigned kKind = 0x60;
  return exchange.kind == Exchange::Kind::kControl &&
         (exchange.command.empty() || (u8_at(exchange.command, 0) & kKind) == 0);
}

// Which packets of submissions stay: the part, and what described the unit before its first
// command.
std::vector<PacketSpan> spans_to_keep(const std::filesystem::path& from,
                                      const RewriteOptions& options, RewriteResult& result) {
  std::vector<PacketSpan> spans;
  ExchangeReader reader(from);
  bool before_commands = true;
  while (const auto exchange = reader.next()) {
    const bool describes = before_commands && is_standard_request(*exchange);
    before_commands = before_commands && describes;
    const bool chosen = exchange->number >= options.first_exchange &&
                        exchange->number <= options.last_exchange &&
                        (options.phase.empty() || options.phase == exchange->phase);
    if (!describes && !chosen) continue;
    if (!describes) ++result.n_exchanges;
    if (!spans.empty() && spans.back().last + 1 >= exchange->first_packet) {
      // One that came in between comes after.
      spans.back().last = std::max(spans.back().last, exchange->last_packet);
    } else {
      spans.push_back({exchange->first_packet, exchange->last_packet});
    }
  }
  return spans;
}

}  // namespace

RewriteResult rewrite_recording(const std::filesystem::path& from, const std::filesystem::path& to,
                                const RewriteOptions& options) {
  RewriteResult result;
  const std::vector<PacketSpan> spans = spans_to_keep(from, options, result);
  if (result.n_exchanges == 0) {
    throw InputError("No command of the recording " + from.string() +
                     " lies in the part that was asked for. `reseau session show` prints their "
                     "numbers and phases.");
  }
  ExchangeReader device_reader(from);
  const RecordedDevice& device = device_reader.device();
  const Blanker blanker(options, device);
  CaptureReader packets(from);
  std::optional<UsbPacket> packet = packets.next();
  std::string comment = packets.comment();
  if (options.blank_serial && device_reader.header().device_name.empty()) {
    // Another program's comment may name a person or a machine.
    comment.clear();
  }
  result.n_blanked += blanker.blank(comment);
  PcapngWriter writer(to, comment);
  std::set<std::uint64_t> open;  // submissions whose completion has to follow
  std::size_t span = 0;
  std::string phase;  // named by a packet that was left out
  for (; packet; packet = packets.next()) {
    const std::uint64_t number = packet->number;
    const bool ours = packet->bus == device.bus && packet->device == device.device;
    while (span < spans.size() && spans[span].last < number) ++span;
    const bool inside = span < spans.size() && spans[span].first <= number;
    const bool keep = ours && (packet->submission ? inside : open.erase(packet->id) > 0);
    if (ours && !packet->comment.empty()) phase = packet->comment;
    if (!keep) {
      ++result.n_packets_left_out;
      continue;
    }
    if (packet->submission) {
      open.insert(packet->id);
      packet->comment = std::exchange(phase, {});
    }
    result.n_blanked += blanker.blank(packet->data, packet->type) + blanker.blank(packet->comment);
    writer.write(*packet);
    ++result.n_packets;
  }
  return result;
}

}  // namespace reseau
