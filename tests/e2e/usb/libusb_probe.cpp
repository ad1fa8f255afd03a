// libusb_probe: one transfer of each kind through our own libusb code, each outcome as a line. Run
// under tests/support/usbip_host.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "drivers/bytes.h"
#include "drivers/usb/libusb_transport.h"

namespace {

using namespace std::chrono_literals;
constexpr reseau::Endpoint kOut = 0x01, kIn = 0x82, kNowhere = 0x85;

const char* word(reseau::DeviceError::Kind kind) {
  switch (kind) {
    case reseau::DeviceError::Kind::kTimeout:
      return "timeout";
    case reseau::DeviceError::Kind::kStall:
      return "stall";
    case reseau::DeviceError::Kind::kDisconnected:
      return "disconnected";
    default:
      return "protocol";
  }
}

void report(const char* what, const std::function<std::string()>& transfer) {
  std::string outcome;
  try {
    outcome = transfer();
  } catch (const reseau::DeviceError& error) {
    outcome = word(error.kind());
  }
  std::printf("%s: %s\n", what, outcome.c_str());
}

}  // namespace

int main() {
  const auto usb = reseau::open_libusb(0x04B0, 0x4002, "");
  const auto send = [&](const reseau::Bytes& bytes) {
    usb->bulk_out(kOut, bytes, 2s);
    return std::string("ok");
  };
  const auto receive = [&](std::size_t n, std::chrono::milliseconds timeout) {
    reseau::Bytes buffer(n);
    const std::size_t got = usb->bulk_in(kIn, buffer, timeout);
    return reseau::hex_of(reseau::ByteView(buffer).first(got), 8);
  };
  report("identity", [&] {
    return std::to_string(usb->identity().product_id) + " " +
           std::to_string(usb->identity().max_packet_bytes);
  });
  report("nothing there", [&] { return receive(512, 50ms); });
  report("command", [&] { return send(reseau::bytes_of({0x12, 0, 0, 0, 0x24, 0x80})); });
  report("query", [&] { return send(reseau::bytes_of({0xD0})); });
  report("phase", [&] { return receive(512, 2s); });
  report("short data", [&] { return receive(1024, 2s); });
  report("status", [&] { return receive(512, 2s); });
  report("after it", [&] { return receive(512, 50ms); });
  report("no endpoint", [&] {
    reseau::Bytes buffer(512);
    return std::to_string(usb->bulk_in(kNowhere, buffer, 2s));
  });
  report("clear halt", [&] {
    usb->clear_halt(kIn);
    return std::string("ok");
  });
  report("command again", [&] { return send(reseau::bytes_of({0, 0, 0, 0, 0, 0})); });
  report("query again", [&] { return send(reseau::bytes_of({0xD0})); });
  report("phase again", [&] { return receive(512, 2s); });
  return 0;
}
