#include "drivers/usb/paced_transport.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace reseau {
namespace {

constexpr Duration kMostWaiting{1'000'000};

}  // namespace

PacedTransport::PacedTransport(std::unique_ptr<UsbTransport> inner, double bytes_per_s,
                               std::shared_ptr<Clock> clock)
    : inner_(std::move(inner)), us_per_byte_(1e6 / bytes_per_s), clock_(std::move(clock)) {}

std::size_t PacedTransport::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                    Duration timeout) {
  const std::size_t n = inner_->bulk_in(endpoint, buffer, timeout);
  const Duration takes(std::llround(static_cast<double>(n) * us_per_byte_));
  ready_ = std::max(ready_, clock_->now() - kMostWaiting) + takes;
  clock_->sleep_until(ready_);
  return n;
}

}  // namespace reseau
