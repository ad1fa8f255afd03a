#include "drivers/usb/session_header.h"

#include <string_view>

namespace reseau {
namespace {

// Three lines, then the comment: readable in Wireshark's file properties.
constexpr std::string_view kMagic = "reseau session 1\n";
constexpr std::string_view kDeviceField = "device: ";
constexpr std::string_view kStarted = "\nstarted_at_utc: ";

}  // namespace

std::string encode_session_header(const SessionHeader& header) {
  std::string text(kMagic);
  text += kDeviceField;
  text += header.device_name;
  text += kStarted;
  text += header.started_at_utc;
  text += '\n';
  return text + header.comment;
}

SessionHeader decode_session_header(const std::string& text) {
  SessionHeader header;
  const std::string head = std::string(kMagic) + std::string(kDeviceField);
  const std::size_t started = text.find(kStarted);
  const std::size_t end =
      started == std::string::npos ? started : text.find('\n', started + kStarted.size());
  if (!text.starts_with(head) || started < head.size() || end == std::string::npos) {
    header.comment = text;
    return header;
  }
  header.device_name = text.substr(head.size(), started - head.size());
  header.started_at_utc = text.substr(started + kStarted.size(), end - started - kStarted.size());
  header.comment = text.substr(end + 1);
  return header;
}

}  // namespace reseau
