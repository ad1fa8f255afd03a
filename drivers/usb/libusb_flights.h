// Reads of a bulk endpoint with several transfers in flight, so that the bus never waits for this
// program between them.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "drivers/usb/usb_transport.h"

struct libusb_context;
struct libusb_device_handle;
struct libusb_transfer;

namespace reseau {

// Of a code that libusb returned.
[[nodiscard]] int errno_of_libusb(int code);
// At least 1: 0 would mean "for ever" to libusb.
[[nodiscard]] unsigned libusb_milliseconds(Duration timeout);

// The order of the transfers is that of the data. When one comes short, the read ends there, those
// behind it are taken back, and what they had received already is kept for the next read.
// Thread-bound; borrows both.
class BulkFlights {
 public:
  // Whole packets of either speed.
  static constexpr std::size_t kFlightBytes = 16 * 1024;
  static constexpr std::size_t kMaxFlights = 8;

  BulkFlights(libusb_context* context, libusb_device_handle* handle);

  // How many bytes came, as UsbTransport::bulk_in() says; at most kMaxFlights * kFlightBytes are
  // asked for. Throws DeviceError.
  [[nodiscard]] std::size_t read(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout);
  // What one transfer behind a short one had received; absent when there is none.
  [[nodiscard]] std::optional<std::size_t> take_kept(Endpoint endpoint,
                                                     std::span<std::byte> buffer);
  void forget() { kept_.clear(); }

 private:
  struct TransferDeleter {
    void operator()(libusb_transfer* transfer) const;
  };
  struct Kept {
    Endpoint endpoint;
    std::vector<std::byte> bytes;
  };
  static void ended(libusb_transfer* transfer) noexcept;
  int start(std::size_t i, Endpoint endpoint, std::span<std::byte> part, Duration timeout);
  void land(std::size_t n_started);
  void keep_from(std::size_t first, std::size_t end, Endpoint endpoint);

  libusb_context* context_;
  libusb_device_handle* handle_;
  std::array<std::unique_ptr<libusb_transfer, TransferDeleter>, kMaxFlights> transfers_;
  std::size_t n_flying_ = 0;
  int broken_ = 0;  // one ended before its end; an int, as libusb wants it
  std::deque<Kept> kept_;
};

}  // namespace reseau
