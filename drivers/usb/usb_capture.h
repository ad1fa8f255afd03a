// Packets of USB captures, as Linux usbmon and USBPcap write them, and the transfers they make up.
// Link types 189 and 220 (usbmon, 48- and 64-byte headers) and 249 (USBPcap).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/bytes.h"

namespace reseau {

enum class UsbTransferType : std::uint8_t { kIsochronous, kInterrupt, kControl, kBulk };

// One half of a transfer: its submission or its completion.
struct UsbPacket {
  std::uint64_t id = 0;  // pairs the halves
  bool submission = true;
  UsbTransferType type = UsbTransferType::kBulk;
  std::uint8_t endpoint = 0;  // with the direction bit
  std::uint8_t device = 1;
  std::uint16_t bus = 1;
  std::int64_t time_us = 0;  // since 1970
  std::int32_t status = 0;   // completion: 0 or a negative errno
  // Asked for (submission) or moved (completion) [bytes]; absent where a capture does not say.
  std::optional<std::uint32_t> length;
  std::optional<std::array<std::byte, 8>> setup;  // control submissions
  Bytes data;  // OUT with the submission, IN with the completion; less than `length` where a
               // capture limited the size of its packets
  std::uint64_t number = 0;  // in its file, from 1, as Wireshark counts
  // USBPcap before 1.3 writes what a control request sends as a packet of its own.
  bool data_follows = false, continues = false;
  std::string comment;  // of the packet in a pcapng file
};

inline constexpr int kLinkUsbmon48 = 189;
inline constexpr int kLinkUsbmon64 = 220;
inline constexpr int kLinkUsbPcap = 249;

// Little-endian, link type 220.
[[nodiscard]] Bytes encode_usbmon(const UsbPacket& packet);

// Absent for what is no packet of that link type, or too short for its header.
// `time_us` is taken for link types without a time of their own. USBPcap is always little-endian.
[[nodiscard]] std::optional<UsbPacket> decode_usb_packet(ByteView bytes, int link_type,
                                                         bool big_endian, std::int64_t time_us);

// A whole transfer.
struct UsbTransfer {
  UsbTransferType type = UsbTransferType::kBulk;
  std::uint8_t endpoint = 0;
  std::uint16_t bus = 0;
  std::uint8_t device = 0;
  std::int64_t started_us = 0;
  std::int64_t ended_us = 0;
  std::int32_t status = 0;
  std::optional<std::uint32_t> asked_bytes;
  std::uint64_t moved_bytes = 0;  // more than data holds where a capture cut its packets off
  std::optional<std::array<std::byte, 8>> setup;
  Bytes data;
  std::string comment;
  std::uint64_t packet_number = 0;  // of the submission in its file, from 1, as Wireshark counts

  [[nodiscard]] bool in() const { return (endpoint & 0x80) != 0; }
};

}  // namespace reseau
