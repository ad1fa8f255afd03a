#include "drivers/usb/pcapng_writer.h"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "drivers/usb/pcapng_format.h"

namespace reseau {
namespace {

constexpr std::size_t kMaxOptionBytes = 0xFFFF;

void pad_to_4(Bytes& bytes) {
  while (bytes.size() % 4 != 0) bytes.push_back(std::byte{0});
}

void append_option(Bytes& body, std::uint16_t code, const std::string& text) {
  const std::size_t n = std::min(text.size(), kMaxOptionBytes);
  append_le(body, 2, code);
  append_le(body, 2, n);
  for (std::size_t i = 0; i < n; ++i) body.push_back(static_cast<std::byte>(text[i]));
  pad_to_4(body);
}

void append_end_of_options(Bytes& body) { append_le(body, 4, 0); }

}  // namespace

PcapngWriter::PcapngWriter(const std::filesystem::path& path, const std::string& comment)
    : path_(path) {
  if (std::filesystem::exists(path)) {
    throw std::system_error(EEXIST, std::generic_category(),
                            "The recording " + path.string() +
                                " exists already and is not overwritten; choose another name");
  }
  file_.open(path, std::ios::binary);
  if (!file_) {
    throw std::system_error(errno, std::generic_category(),
                            "The recording " + path.string() + " cannot be written");
  }
  Bytes section;
  append_le(section, 4, pcapng::kByteOrderMagic);
  append_le(section, 2, 1);  // version 1.0
  append_le(section, 2, 0);
  append_le(section, 8, ~std::uint64_t{0});  // section length not known
  append_option(section, pcapng::kOptionComment, comment);
  append_option(section, pcapng::kOptionApplication, "reseau " RESEAU_VERSION);
  append_end_of_options(section);
  write_block(pcapng::kSectionHeader, section);

  Bytes interface;
  append_le(interface, 2, kLinkUsbmon64);
  append_le(interface, 2, 0);
  append_le(interface, 4, 0);  // no limit of packet size
  write_block(pcapng::kInterface, interface);
}

void PcapngWriter::write(const UsbPacket& packet) {
  const Bytes content = encode_usbmon(packet);
  const auto time_us = static_cast<std::uint64_t>(packet.time_us);
  Bytes body;
  body.reserve(content.size() + packet.comment.size() + 40);
  append_le(body, 4, 0);  // interface
  append_le(body, 4, time_us >> 32);
  append_le(body, 4, time_us & 0xFFFFFFFF);
  append_le(body, 4, content.size());
  append_le(body, 4, content.size());
  body.insert(body.end(), content.begin(), content.end());
  pad_to_4(body);
  if (!packet.comment.empty()) {
    append_option(body, pcapng::kOptionComment, packet.comment);
    append_end_of_options(body);
  }
  write_block(pcapng::kEnhancedPacket, body);
}

void PcapngWriter::write_block(std::uint32_t type, const Bytes& body) {
  constexpr std::size_t kFrame = 12;  // type, length, length again
  Bytes block;
  block.reserve(body.size() + kFrame);
  append_le(block, 4, type);
  append_le(block, 4, body.size() + kFrame);
  block.insert(block.end(), body.begin(), body.end());
  append_le(block, 4, body.size() + kFrame);
  file_.write(reinterpret_cast<const char*>(block.data()),
              static_cast<std::streamsize>(block.size()));
  file_.flush();
  if (!file_) {
    throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(),
                            "The recording " + path_.string() +
                                " cannot be continued; make room or record to another disk");
  }
}

}  // namespace reseau
