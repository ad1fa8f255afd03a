#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/bytes.h"
#include "drivers/usb/usb_error.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// Expects exactly these transfers, in this order.
class ScriptedTransport final : public UsbTransport {
 public:
  explicit ScriptedTransport(int max_packet_bytes = 512) {
    identity_.max_packet_bytes = max_packet_bytes;
  }
  ~ScriptedTransport() override { EXPECT_TRUE(steps_.empty()) << steps_.size() << " steps left"; }

  ScriptedTransport& out(Bytes data) {
    steps_.push_back({false, std::move(data), 0});
    return *this;
  }
  ScriptedTransport& in(Bytes data) {
    steps_.push_back({true, std::move(data), 0});
    return *this;
  }
  ScriptedTransport& in_fails(int status) {
    steps_.push_back({true, {}, status});
    return *this;
  }

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint, std::span<const std::byte> data, Duration) override {
    const Step step = take();
    EXPECT_FALSE(step.in);
    EXPECT_EQ(hex_of(step.data), hex_of(data));
  }
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override {
    const Step step = take();
    in_timeouts.push_back(timeout);
    EXPECT_TRUE(step.in);
    EXPECT_EQ(buffer.size() % static_cast<std::size_t>(identity_.max_packet_bytes), 0U);
    if (step.status != 0) throw transfer_error(step.status, endpoint, buffer.size());
    EXPECT_LE(step.data.size(), buffer.size());
    std::copy(step.data.begin(), step.data.end(), buffer.begin());
    return step.data.size();
  }
  void clear_halt(Endpoint) override { ++n_clear_halts; }
  void reset() override {}

  int n_clear_halts = 0;
  std::vector<Duration> in_timeouts;

 private:
  struct Step {
    bool in;
    Bytes data;
    int status;
  };
  Step take() {
    if (steps_.empty()) {
      ADD_FAILURE() << "a transfer too many";
      throw transfer_error(ENODEV, 0, 0);
    }
    Step step = std::move(steps_.front());
    steps_.pop_front();
    return step;
  }

  UsbIdentity identity_;
  std::deque<Step> steps_;
};

}  // namespace reseau
