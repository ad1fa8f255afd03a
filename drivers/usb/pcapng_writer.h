#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "drivers/usb/usb_capture.h"

namespace reseau {

// Writes USB packets as pcapng, link type 220, so that Wireshark opens the file. Every block is
// handed to the operating system at once: a program that dies leaves a file that can be read up to
// its last packet. Thread-bound.
class PcapngWriter {
 public:
  // Creates the file; never overwrites one. `comment` is kept in the section header. Throws
  // std::system_error.
  PcapngWriter(const std::filesystem::path& path, const std::string& comment);

  // Throws std::system_error when the place is full or gone.
  void write(const UsbPacket& packet);

 private:
  void write_block(std::uint32_t type, const Bytes& body);

  std::filesystem::path path_;
  std::ofstream file_;
};

}  // namespace reseau
