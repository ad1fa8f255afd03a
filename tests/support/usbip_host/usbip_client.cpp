#include "tests/support/usbip_host/usbip_client.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace reseau::testing {
namespace {

using Words = std::vector<std::uint8_t>;

void put(Words& to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    to.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::uint32_t word(std::span<const std::uint8_t> from, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | from[at + i];
  return value;
}

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error("USB/IP client: " + what + ": " + std::strerror(errno));
}

}  // namespace

UsbipClient::UsbipClient(const std::string& address) {
  if (address.rfind("unix:", 0) == 0) {
    sockaddr_un to{};
    to.sun_family = AF_UNIX;
    address.copy(to.sun_path, sizeof to.sun_path - 1, 5);
    fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) fail(address);
    return;
  }
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port =
      htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) fail(address);
  const int on = 1;
  ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

UsbipClient::~UsbipClient() { ::close(fd_); }

void UsbipClient::send(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail("send");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

bool UsbipClient::receive(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

std::uint32_t UsbipClient::count_devices() {
  send(Words{1, 0x11, 0x80, 5, 0, 0, 0, 0});
  Words head(12);
  if (!receive(head)) fail("list of devices");
  return word(head, 8);
}

std::optional<ImportedDevice> UsbipClient::import(const std::string& bus_id) {
  Words request{1, 0x11, 0x80, 3, 0, 0, 0, 0};
  request.resize(40);
  std::copy(bus_id.begin(), bus_id.end(), request.begin() + 8);
  send(request);
  Words reply(8);
  if (!receive(reply)) fail("import");
  if (word(reply, 4) != 0) return std::nullopt;
  Words summary(312);
  if (!receive(summary)) fail("import");
  const ImportedDevice device{word(summary, 288), word(summary, 292), word(summary, 296)};
  device_id_ = device.bus << 16 | device.device;
  return device;
}

void UsbipClient::submit(std::uint32_t sequence, bool in, std::uint8_t endpoint,
                         std::uint32_t length, std::span<const std::uint8_t> out,
                         const std::array<std::uint8_t, 8>& setup, std::uint32_t flags) {
  Words request;
  for (const std::uint32_t value : {1U, sequence, device_id_, in ? 1U : 0U, std::uint32_t{endpoint},
                                    flags, length, 0U, 0U, 0U}) {
    put(request, value);
  }
  request.insert(request.end(), setup.begin(), setup.end());
  request.insert(request.end(), out.begin(), out.end());
  send(request);
}

void UsbipClient::unlink(std::uint32_t sequence, std::uint32_t of) {
  Words request;
  for (const std::uint32_t value : {2U, sequence, device_id_, 0U, 0U, of}) put(request, value);
  request.resize(48);
  send(request);
}

TransferReply UsbipClient::reply() {
  Words head(48);
  if (!receive(head)) fail("reply");
  TransferReply reply;
  reply.unlink = word(head, 0) == 4;
  reply.sequence = word(head, 4);
  reply.status = static_cast<std::int32_t>(word(head, 20));
  reply.length = reply.unlink ? 0 : word(head, 24);
  return reply;
}

int UsbipClient::control_in(const std::array<std::uint8_t, 8>& setup,
                            std::vector<std::uint8_t>& data) {
  submit(++control_sequence_, true, 0, static_cast<std::uint32_t>(data.size()), {}, setup);
  const TransferReply got = reply();
  if (got.length > data.size() || !receive(std::span(data).first(got.length))) fail("control");
  return got.status != 0 ? got.status : static_cast<int>(got.length);
}

}  // namespace reseau::testing
