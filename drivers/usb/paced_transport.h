#pragma once

#include <memory>

#include "core/base/clock.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// What a Coolscan LS-5000 delivers: a frame of 188 MB (4000 dpi, red green blue infrared) in 77 s.
inline constexpr double kScannerBytesPerSecond = 188.1e6 / 77;

// A transport whose bulk IN transfers come no faster than so many bytes a second, as from a unit
// whose film moves. What the host did not fetch for a while waits in the unit, a second's worth at
// most. Thread-bound.
class PacedTransport final : public UsbTransport {
 public:
  PacedTransport(std::unique_ptr<UsbTransport> inner, double bytes_per_s,
                 std::shared_ptr<Clock> clock);

  [[nodiscard]] const UsbIdentity& identity() const override { return inner_->identity(); }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override {
    inner_->bulk_out(endpoint, data, timeout);
  }
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override {
    inner_->control_out(request, data, timeout);
  }
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override {
    return inner_->control_in(request, buffer, timeout);
  }
  void clear_halt(Endpoint endpoint) override { inner_->clear_halt(endpoint); }
  void reset() override { inner_->reset(); }
  void annotate(std::string_view phase) override { inner_->annotate(phase); }

 private:
  std::unique_ptr<UsbTransport> inner_;
  double us_per_byte_;
  std::shared_ptr<Clock> clock_;
  TimePoint ready_{};  // when the unit has what was fetched last
};

}  // namespace reseau
