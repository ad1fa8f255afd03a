#include "drivers/usb/usb_error.h"

#include <cerrno>
#include <cstring>
#include <string>

namespace reseau {
namespace {

std::string detail_of(int status, Endpoint endpoint, std::size_t asked_bytes) {
  const char* const direction = (endpoint & 0x80) != 0 ? "IN" : "OUT";
  const std::string pipe =
      (endpoint & 0x0F) == 0
          ? std::string("control ") + direction
          : std::string("bulk ") + direction + " endpoint " + std::to_string(endpoint & 0x0F);
  return pipe + ", " + std::to_string(asked_bytes) + " bytes asked: " + std::strerror(status);
}

}  // namespace

DeviceError transfer_error(int status, Endpoint endpoint, std::size_t asked_bytes) {
  const std::string detail = detail_of(status, endpoint, asked_bytes);
  switch (status) {
    case ETIMEDOUT:
    case ENOENT:      // the kernel's word for a URB that its owner gave up waiting for
    case ECONNRESET:  // the same, asynchronously
      return {DeviceError::Kind::kTimeout,
              "The scanner did not answer in time. If it stays silent, switch it off, wait ten "
              "seconds, switch it on again and repeat the scan.",
              detail};
    case EPIPE:
      return {DeviceError::Kind::kStall,
              "The scanner refused a transfer (the USB endpoint stalled). Repeat the scan; if it "
              "happens again, switch the scanner off and on.",
              detail};
    case ENODEV:
    case ESHUTDOWN:
      return {DeviceError::Kind::kDisconnected,
              "The scanner is no longer there: it was unplugged or switched off. Check cable and "
              "power, then start again.",
              detail};
    default:
      return {DeviceError::Kind::kProtocol,
              "A USB transfer failed. Try another cable or another port of the computer, without "
              "a hub.",
              detail};
  }
}

int status_of(DeviceError::Kind kind) {
  switch (kind) {
    case DeviceError::Kind::kTimeout:
      return ETIMEDOUT;
    case DeviceError::Kind::kStall:
      return EPIPE;
    case DeviceError::Kind::kDisconnected:
      return ENODEV;
    default:
      return EPROTO;
  }
}

}  // namespace reseau
