// The host side of USB/IP, independent of the program's own server code.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace reseau::testing {

struct ImportedDevice {
  std::uint32_t bus = 0, device = 0, speed = 0;
};

struct TransferReply {
  bool unlink = false;
  std::uint32_t sequence = 0;
  std::int32_t status = 0;
  std::uint32_t length = 0;
};

// Blocking. Every failure of the connection is a std::runtime_error.
class UsbipClient {
 public:
  // "unix:/path" or "tcp:127.0.0.1:PORT".
  explicit UsbipClient(const std::string& address);
  ~UsbipClient();
  UsbipClient(const UsbipClient&) = delete;
  UsbipClient& operator=(const UsbipClient&) = delete;

  // Raw bytes, for requests that are wrong on purpose.
  void send(std::span<const std::uint8_t> bytes);
  // False when the server closed the connection first.
  [[nodiscard]] bool receive(std::span<std::uint8_t> bytes);

  // How many devices the server says it has.
  [[nodiscard]] std::uint32_t count_devices();
  // Absent when it was refused.
  [[nodiscard]] std::optional<ImportedDevice> import(const std::string& bus_id);

  void submit(std::uint32_t sequence, bool in, std::uint8_t endpoint, std::uint32_t length,
              std::span<const std::uint8_t> out = {}, const std::array<std::uint8_t, 8>& setup = {},
              std::uint32_t flags = 0);
  void unlink(std::uint32_t sequence, std::uint32_t of);
  // The head of the next reply; `length` bytes follow it when the transfer was an IN one.
  [[nodiscard]] TransferReply reply();
  // A control transfer alone on the wire: status, or the number of bytes received.
  int control_in(const std::array<std::uint8_t, 8>& setup, std::vector<std::uint8_t>& data);

 private:
  int fd_ = -1;
  std::uint32_t device_id_ = 0;
  std::uint32_t control_sequence_ = 0x70000000;
};

}  // namespace reseau::testing
