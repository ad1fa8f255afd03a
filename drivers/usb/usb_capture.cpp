#include "drivers/usb/usb_capture.h"

#include <algorithm>
#include <cerrno>

namespace reseau {
namespace {

// Linux: Documentation/usb/usbmon.rst, struct usbmon_packet.
constexpr std::size_t kUsbmonShortHeader = 48;
constexpr std::size_t kUsbmonHeader = 64;
// USBPcap: USBPCAP_BUFFER_PACKET_HEADER.
constexpr std::size_t kUsbPcapHeader = 27;
// Of control transfers, a byte behind it.
constexpr int kStageSetup = 0, kStageData = 1, kStageStatus = 2;
constexpr std::size_t kSetupBytes = 8;

std::optional<UsbPacket> decode_usbmon(ByteView b, std::size_t header_bytes, bool big_endian) {
  if (b.size() < header_bytes) return std::nullopt;
  const auto number = [&](std::size_t offset, std::size_t n) {
    return big_endian ? load_be(b, offset, n) : load_le(b, offset, n);
  };
  UsbPacket packet;
  const char event = static_cast<char>(u8_at(b, 8));
  if (event != 'S' && event != 'C' && event != 'E') return std::nullopt;
  packet.id = number(0, 8);
  packet.submission = event == 'S';
  if (u8_at(b, 9) > 3) return std::nullopt;
  packet.type = static_cast<UsbTransferType>(u8_at(b, 9));
  packet.endpoint = u8_at(b, 10);
  packet.device = u8_at(b, 11);
  packet.bus = static_cast<std::uint16_t>(number(12, 2));
  // A hostile second count must not overflow.
  const auto seconds = static_cast<std::int64_t>(number(16, 8) & 0xFFFFFFFFFF);
  packet.time_us = seconds * 1'000'000 + static_cast<std::int32_t>(number(24, 4));
  // A status that no kernel writes must not overflow when its sign is changed.
  packet.status = std::max(static_cast<std::int32_t>(number(28, 4)), -0xFFFF);
  packet.length = static_cast<std::uint32_t>(number(32, 4));
  // A limit of packet size may have cut the rest off.
  const std::size_t captured = std::min<std::size_t>(number(36, 4), b.size() - header_bytes);
  if (packet.submission && packet.type == UsbTransferType::kControl && u8_at(b, 14) == 0) {
    packet.setup.emplace();
    std::copy_n(b.begin() + 40, kSetupBytes, packet.setup->begin());
  }
  const ByteView data = b.subspan(header_bytes, captured);
  packet.data.assign(data.begin(), data.end());
  return packet;
}

std::optional<UsbPacket> decode_usbpcap(ByteView b, std::int64_t time_us) {
  if (b.size() < kUsbPcapHeader) return std::nullopt;
  const std::size_t header_bytes = load_le(b, 0, 2);
  if (header_bytes < kUsbPcapHeader || header_bytes > b.size()) return std::nullopt;
  UsbPacket packet;
  packet.id = load_le(b, 2, 8);
  const bool failed = load_le(b, 10, 4) != 0;
  packet.submission = (u8_at(b, 16) & 1) == 0;
  packet.bus = static_cast<std::uint16_t>(load_le(b, 17, 2));
  packet.device = static_cast<std::uint8_t>(load_le(b, 19, 2));
  packet.endpoint = u8_at(b, 21);
  if (u8_at(b, 22) > 3) return std::nullopt;
  packet.type = static_cast<UsbTransferType>(u8_at(b, 22));
  packet.time_us = time_us;
  // Windows status words have no errno; a cancelled URB is the usual one.
  packet.status = failed && !packet.submission ? -EPROTO : 0;
  std::size_t sent = load_le(b, 23, 4);
  ByteView data = b.subspan(header_bytes, std::min(sent, b.size() - header_bytes));
  if (packet.type == UsbTransferType::kControl) {
    const int stage = header_bytes > kUsbPcapHeader ? u8_at(b, kUsbPcapHeader) : kStageSetup;
    // Not from the host, whatever the direction of this packet.
    if (stage == kStageStatus) packet.submission = false;
    packet.continues = packet.submission && stage == kStageData;
    if (packet.submission && stage == kStageSetup && data.size() >= kSetupBytes) {
      packet.setup.emplace();
      std::copy_n(data.begin(), kSetupBytes, packet.setup->begin());
      data = data.subspan(kSetupBytes);
      sent -= kSetupBytes;
      packet.endpoint =
          static_cast<std::uint8_t>((packet.endpoint & 0x7F) | (u8_at(*packet.setup, 0) & 0x80));
      const bool sends = (packet.endpoint & 0x80) == 0 && load_le(*packet.setup, 6, 2) > 0;
      packet.data_follows = sends && sent == 0;
    }
  }
  packet.data.assign(data.begin(), data.end());
  if (data.size() < sent) packet.length = static_cast<std::uint32_t>(sent);
  return packet;
}

}  // namespace

Bytes encode_usbmon(const UsbPacket& packet) {
  const bool in = (packet.endpoint & 0x80) != 0;
  Bytes b;
  b.reserve(kUsbmonHeader + packet.data.size());
  append_le(b, 8, packet.id);
  append_le(b, 1, packet.submission ? 'S' : 'C');
  append_le(b, 1, static_cast<std::uint64_t>(packet.type));
  append_le(b, 1, packet.endpoint);
  append_le(b, 1, packet.device);
  append_le(b, 2, packet.bus);
  append_le(b, 1, packet.setup ? 0 : '-');
  append_le(b, 1, !packet.data.empty() ? 0 : (in ? '<' : '>'));
  append_le(b, 8, static_cast<std::uint64_t>(packet.time_us / 1'000'000));
  append_le(b, 4, static_cast<std::uint64_t>(packet.time_us % 1'000'000));
  append_le(b, 4, static_cast<std::uint32_t>(packet.submission ? -EINPROGRESS : packet.status));
  append_le(b, 4, packet.length.value_or(0));
  append_le(b, 4, packet.data.size());
  for (std::size_t i = 0; i < kSetupBytes; ++i) {
    b.push_back(packet.setup ? (*packet.setup)[i] : std::byte{0});
  }
  append_le(b, 4, 0);  // interval
  append_le(b, 4, 0);  // start frame
  append_le(b, 4, 0);  // transfer flags
  append_le(b, 4, 0);  // isochronous descriptors
  CHECK(b.size() == kUsbmonHeader);
  b.insert(b.end(), packet.data.begin(), packet.data.end());
  return b;
}

std::optional<UsbPacket> decode_usb_packet(ByteView bytes, int link_type, bool big_endian,
                                           std::int64_t time_us) {
  switch (link_type) {
    case kLinkUsbmon48:
      return decode_usbmon(bytes, kUsbmonShortHeader, big_endian);
    case kLinkUsbmon64:
      return decode_usbmon(bytes, kUsbmonHeader, big_endian);
    case kLinkUsbPcap:
      return decode_usbpcap(bytes, time_us);
    default:
      return std::nullopt;
  }
}

}  // namespace reseau
