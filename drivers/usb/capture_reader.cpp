#include "drivers/usb/capture_reader.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/pcapng_format.h"

namespace reseau {
namespace {

// No USB transfer is larger; a length beyond it is a broken file, not a reason to allocate.
constexpr std::size_t kMaxBlockBytes = 64 << 20;
constexpr std::size_t kMaxInterfaces = 1024;
// USB captures of many devices hold transfers that never complete.
constexpr std::size_t kMaxPending = 4096;

constexpr std::uint32_t kClassicMicroseconds = 0xA1B2C3D4;
constexpr std::uint32_t kClassicNanoseconds = 0xA1B23C4D;

std::int64_t microseconds(std::uint64_t ticks, std::uint64_t ticks_per_second) {
  const std::uint64_t seconds = ticks / ticks_per_second;
  const auto rest = static_cast<double>(ticks % ticks_per_second);
  return static_cast<std::int64_t>(seconds % (1ULL << 40)) * 1'000'000 +
         static_cast<std::int64_t>(rest * 1e6 / static_cast<double>(ticks_per_second));
}

}  // namespace

CaptureReader::CaptureReader(const std::filesystem::path& path)
    : path_(path), file_(path, std::ios::binary | std::ios::ate) {
  left_bytes_ = file_ ? static_cast<std::uint64_t>(file_.tellg()) : 0;
  file_.seekg(0);
  if (!file_) {
    throw std::system_error(errno != 0 ? errno : ENOENT, std::generic_category(),
                            "The recording " + path.string() + " cannot be opened");
  }
  constexpr std::size_t kClassicHeader = 24;
  if (!read(kClassicHeader)) broken("it is too short to be a capture");
  const auto magic_le = static_cast<std::uint32_t>(load_le(buffer_, 0, 4));
  const auto magic_be = static_cast<std::uint32_t>(load_be(buffer_, 0, 4));
  if (magic_le == pcapng::kSectionHeader) {
    step_back(kClassicHeader);
    return;
  }
  classic_ = true;
  big_endian_ = magic_be == kClassicMicroseconds || magic_be == kClassicNanoseconds;
  const std::uint32_t magic = big_endian_ ? magic_be : magic_le;
  if (magic != kClassicMicroseconds && magic != kClassicNanoseconds) {
    broken("it is neither pcapng nor pcap");
  }
  interfaces_.push_back({static_cast<int>(number(buffer_, 20, 4) & 0xFFFF),
                         magic == kClassicNanoseconds ? 1'000'000'000U : 1'000'000U});
}

void CaptureReader::broken(const std::string& what) const {
  throw InputError("The recording " + path_.string() + " cannot be used: " + what + ".");
}

bool CaptureReader::read(std::size_t n) {
  // A length from a broken file must not make room for what cannot come.
  if (n > left_bytes_) {
    left_bytes_ = 0;  // nothing after what was cut off can be understood
    return false;
  }
  left_bytes_ -= n;
  buffer_.resize(n);
  file_.read(reinterpret_cast<char*>(buffer_.data()), static_cast<std::streamsize>(n));
  return static_cast<std::size_t>(file_.gcount()) == n;
}

void CaptureReader::step_back(std::size_t n) {
  file_.seekg(-static_cast<std::streamoff>(n), std::ios::cur);
  left_bytes_ += n;
}

std::uint64_t CaptureReader::number(ByteView bytes, std::size_t offset, std::size_t n) const {
  return big_endian_ ? load_be(bytes, offset, n) : load_le(bytes, offset, n);
}

std::optional<UsbPacket> CaptureReader::next() {
  while (true) {
    std::optional<UsbPacket> packet;
    if (ahead_.empty()) {
      packet = next_as_written();
    } else {
      packet = std::move(ahead_.front());
      ahead_.pop_front();
    }
    if (packet && packet->data_follows) append_what_follows(*packet);
    // One whose beginning is not in the capture says nothing.
    if (!packet || !packet->continues) return packet;
  }
}

// It follows at once, but for what other devices did meanwhile.
void CaptureReader::append_what_follows(UsbPacket& packet) {
  constexpr std::size_t kFarthest = 32;
  for (std::size_t i = 0; i < kFarthest; ++i) {
    if (i == ahead_.size()) {
      auto next = next_as_written();
      if (!next) return;
      ahead_.push_back(*std::move(next));
    }
    const UsbPacket& other = ahead_[i];
    if (other.id != packet.id || other.bus != packet.bus || other.device != packet.device) continue;
    if (!other.continues) return;
    packet.data = other.data;
    packet.length = other.length;
    ahead_.erase(ahead_.begin() + static_cast<std::ptrdiff_t>(i));
    return;
  }
}

bool CaptureReader::seen_elsewhere(const UsbPacket& packet, std::size_t interface_index) {
  const std::uint32_t device = std::uint32_t{packet.bus} << 8 | packet.device;
  return interface_of_.emplace(device, interface_index).first->second != interface_index;
}

std::optional<UsbPacket> CaptureReader::next_as_written() {
  if (classic_) return next_classic();
  constexpr std::size_t kFrame = 12, kHead = 8, kMagic = 4;
  while (read(kHead)) {
    auto type = static_cast<std::uint32_t>(number(buffer_, 0, 4));
    Bytes head = buffer_;
    if (type == pcapng::kSectionHeader) {
      // Its length is in the byte order that only its first field tells.
      if (!read(kMagic)) return std::nullopt;
      big_endian_ = load_be(buffer_, 0, 4) == pcapng::kByteOrderMagic;
      if (!big_endian_ && load_le(buffer_, 0, 4) != pcapng::kByteOrderMagic) {
        broken("a section has no byte order");
      }
      step_back(kMagic);
    }
    const std::size_t block_bytes = number(head, 4, 4);
    if (block_bytes < kFrame || block_bytes % 4 != 0 || block_bytes > kMaxBlockBytes) {
      broken("a block after packet " + std::to_string(n_packets_) + " has an impossible length");
    }
    if (!read(block_bytes - kHead)) return std::nullopt;
    if (number(buffer_, buffer_.size() - 4, 4) != block_bytes) {
      broken("a block after packet " + std::to_string(n_packets_) + " has two lengths");
    }
    const Bytes body(buffer_.begin(), buffer_.end() - 4);
    if (auto packet = packet_of_block(type, body)) return packet;
  }
  return std::nullopt;
}

std::optional<UsbPacket> CaptureReader::packet_of_block(std::uint32_t type, ByteView body) {
  if (type == pcapng::kSectionHeader) {
    section_header(body);
    return std::nullopt;
  }
  if (type == pcapng::kInterface) {
    interface(body);
    return std::nullopt;
  }
  if (type == pcapng::kSimplePacket) ++n_packets_;
  if (type != pcapng::kEnhancedPacket) return std::nullopt;
  ++n_packets_;
  constexpr std::size_t kPacketHead = 20;
  if (body.size() < kPacketHead) broken("a packet block is too short");
  const std::uint64_t index = number(body, 0, 4);
  if (index >= interfaces_.size()) broken("a packet belongs to no interface");
  const Interface& source = interfaces_[index];
  const std::size_t captured = number(body, 12, 4);
  const std::size_t padded = (captured + 3) / 4 * 4;
  if (captured > body.size() - kPacketHead || padded > body.size() - kPacketHead) {
    broken("packet " + std::to_string(n_packets_) + " is longer than its block");
  }
  const std::uint64_t ticks = number(body, 4, 4) << 32 | number(body, 8, 4);
  auto packet = decode_usb_packet(body.subspan(kPacketHead, captured), source.link_type,
                                  big_endian_, microseconds(ticks, source.ticks_per_second));
  if (!packet || seen_elsewhere(*packet, index)) return std::nullopt;
  packet->comment = options(body.subspan(kPacketHead + padded)).comment;
  packet->number = n_packets_;
  return packet;
}

void CaptureReader::section_header(ByteView body) {
  constexpr std::size_t kFixed = 16;
  if (body.size() < kFixed) broken("a section header is too short");
  interfaces_.clear();
  interface_of_.clear();
  const std::string text = options(body.subspan(kFixed)).comment;
  if (comment_.empty()) comment_ = text;
}

void CaptureReader::interface(ByteView body) {
  constexpr std::size_t kFixed = 8;
  if (body.size() < kFixed) broken("an interface description is too short");
  if (interfaces_.size() == kMaxInterfaces) broken("it describes too many interfaces");
  Interface description{static_cast<int>(number(body, 0, 2)), 1'000'000};
  const Options o = options(body.subspan(kFixed));
  if (o.ticks_per_second != 0) description.ticks_per_second = o.ticks_per_second;
  interfaces_.push_back(description);
}

CaptureReader::Options CaptureReader::options(ByteView bytes) const {
  Options found;
  constexpr std::size_t kOptionHead = 4;
  while (bytes.size() >= kOptionHead) {
    const auto code = static_cast<std::uint16_t>(number(bytes, 0, 2));
    const std::size_t length = number(bytes, 2, 2);
    const std::size_t padded = (length + 3) / 4 * 4;
    if (code == pcapng::kOptionEnd || padded > bytes.size() - kOptionHead) break;
    const ByteView value = bytes.subspan(kOptionHead, length);
    if (code == pcapng::kOptionComment && found.comment.empty()) {
      for (const std::byte b : value) found.comment += static_cast<char>(b);
    } else if (code == pcapng::kOptionTimeResolution && length >= 1) {
      const unsigned exponent = u8_at(value, 0) & 0x7F;
      const bool binary = (u8_at(value, 0) & 0x80) != 0;
      if (exponent > (binary ? 63U : 19U)) broken("an interface has an impossible time resolution");
      found.ticks_per_second = 1;
      for (unsigned i = 0; i < exponent; ++i) found.ticks_per_second *= binary ? 2 : 10;
    }
    bytes = bytes.subspan(kOptionHead + padded);
  }
  return found;
}

std::optional<UsbPacket> CaptureReader::next_classic() {
  constexpr std::size_t kRecordHead = 16;
  const Interface& source = interfaces_.front();
  while (read(kRecordHead)) {
    const std::size_t captured = number(buffer_, 8, 4);
    if (captured > kMaxBlockBytes) {
      broken("packet " + std::to_string(n_packets_ + 1) + " has an impossible length");
    }
    const std::uint64_t ticks =
        number(buffer_, 0, 4) * source.ticks_per_second + number(buffer_, 4, 4);
    if (!read(captured)) return std::nullopt;
    ++n_packets_;
    if (auto packet = decode_usb_packet(buffer_, source.link_type, big_endian_,
                                        microseconds(ticks, source.ticks_per_second))) {
      packet->number = n_packets_;
      return packet;
    }
  }
  return std::nullopt;
}

void TransferReader::complete(const UsbPacket& packet) {
  const auto match = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& p) {
    return !p.complete && p.id == packet.id && p.transfer.device == packet.device &&
           p.transfer.bus == packet.bus;
  });
  // A capture that began in the middle of a transfer.
  if (match == pending_.end()) return;
  UsbTransfer& transfer = match->transfer;
  match->complete = true;
  transfer.status = packet.status;
  transfer.ended_us = packet.time_us;
  if (transfer.in() || !packet.data.empty()) transfer.data = packet.data;
  // Of what was sent only the submission tells how much it was where a capture cut it off.
  const std::uint64_t said =
      transfer.in() ? packet.length.value_or(0) : transfer.asked_bytes.value_or(0);
  transfer.moved_bytes = std::max<std::uint64_t>(said, transfer.data.size());
  // Where a capture did not say how much was asked for, an import could not either.
  if (transfer.in() && transfer.type == UsbTransferType::kBulk && transfer.asked_bytes == 0U) {
    transfer.asked_bytes.reset();
  }
}

std::optional<UsbTransfer> TransferReader::next() {
  while (pending_.empty() || !pending_.front().complete) {
    std::optional<UsbPacket> packet = packets_.next();
    if (!packet || pending_.size() >= kMaxPending) {
      while (!pending_.empty() && !pending_.front().complete) pending_.pop_front();
      if (pending_.empty() && !packet) return std::nullopt;
      if (!packet) break;
    }
    if (!packet->submission) {
      complete(*packet);
      continue;
    }
    UsbTransfer transfer;
    transfer.type = packet->type;
    transfer.endpoint = packet->endpoint;
    transfer.bus = packet->bus;
    transfer.device = packet->device;
    transfer.started_us = transfer.ended_us = packet->time_us;
    transfer.asked_bytes = packet->length;
    transfer.setup = packet->setup;
    transfer.data = std::move(packet->data);
    transfer.comment = std::move(packet->comment);
    transfer.packet_number = packet->number;
    pending_.push_back({std::move(transfer), packet->id, false});
  }
  UsbTransfer transfer = std::move(pending_.front().transfer);
  pending_.pop_front();
  return transfer;
}

}  // namespace reseau
