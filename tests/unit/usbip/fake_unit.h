#pragma once

#include <algorithm>
#include <cerrno>
#include <deque>
#include <utility>
#include <vector>

#include "drivers/bytes.h"
#include "drivers/usb/usb_error.h"
#include "drivers/usb/usb_transport.h"
#include "drivers/usbip/description.h"

namespace reseau::usbip {

// Sends back what it was sent; fails where it is told to.
class FakeUnit final : public UsbTransport {
 public:
  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration) override {
    if (out_status != 0) throw transfer_error(std::exchange(out_status, 0), endpoint, data.size());
    echoes.emplace_back(data.begin(), data.end());
  }
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration) override {
    ++n_reads;
    if (in_status != 0) throw transfer_error(std::exchange(in_status, 0), endpoint, buffer.size());
    if (echoes.empty()) throw transfer_error(ETIMEDOUT, endpoint, buffer.size());
    const Bytes echo = std::move(echoes.front());
    echoes.pop_front();
    if (echo.size() > buffer.size()) throw transfer_error(EOVERFLOW, endpoint, buffer.size());
    std::copy(echo.begin(), echo.end(), buffer.begin());
    return echo.size();
  }
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration) override {
    if (control_status != 0) {
      throw transfer_error(std::exchange(control_status, 0), 0x00, data.size());
    }
    requests.push_back(request);
    echoes.emplace_back(data.begin(), data.end());
  }
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override {
    requests.push_back(request);
    return bulk_in(0x80, buffer, timeout);
  }
  void clear_halt(Endpoint endpoint) override { cleared.push_back(endpoint); }
  void reset() override {
    ++n_resets;
    echoes.clear();
  }

  std::deque<Bytes> echoes;
  std::vector<Endpoint> cleared;
  std::vector<ControlRequest> requests;
  int out_status = 0, in_status = 0, control_status = 0;  // of the next transfer
  int n_resets = 0, n_reads = 0;

 private:
  UsbIdentity identity_;
};

inline DeviceDescription some_device() {
  DeviceDescription device;
  device.vendor_id = 0x04B0;
  device.product_id = 0x4002;
  device.bcd_device = 0x0103;
  device.manufacturer = "Nikon";
  device.product = "LS-5000 ED";
  device.endpoints = {{0x01, false, 0, 0}, {0x82, false, 0, 0}, {0x83, true, 8, 0xC8}};
  return device;
}

}  // namespace reseau::usbip
