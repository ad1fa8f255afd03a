#include "drivers/usbip/exported_device.h"

#include <cerrno>
#include <optional>

#include <gtest/gtest.h>

#include "tests/unit/usbip/fake_unit.h"

namespace reseau::usbip {
namespace {

class Exported : public testing::Test {
 protected:
  SubmitRequest request(bool in, std::uint32_t endpoint, std::uint32_t length) {
    SubmitRequest request;
    request.sequence = ++sequence_;
    request.device_id = 0x10002;
    request.in = in;
    request.endpoint = endpoint;
    request.length = length;
    return request;
  }
  std::vector<Completion> in(std::uint32_t length, std::uint32_t flags = 0) {
    SubmitRequest r = request(true, 2, length);
    r.flags = flags;
    return submit(std::move(r));
  }
  std::vector<Completion> out(const Bytes& data) {
    SubmitRequest r = request(false, 1, static_cast<std::uint32_t>(data.size()));
    r.data = data;
    return submit(std::move(r));
  }
  // Status, or the number of bytes.
  Completion control(const Bytes& setup) {
    SubmitRequest r =
        request((u8_at(setup, 0) & 0x80) != 0, 0, static_cast<std::uint32_t>(load_le(setup, 6, 2)));
    std::copy(setup.begin(), setup.end(), r.setup.begin());
    if (!r.in) r.data.resize(r.length);
    const std::vector<Completion> done = submit(std::move(r));
    EXPECT_GE(done.size(), 1U);
    return done.empty() ? Completion{} : done.front();
  }
  std::vector<Completion> submit(SubmitRequest r) {
    std::vector<Completion> done;
    device_.submit(std::move(r), done);
    return done;
  }

  FakeUnit unit_;
  ExportedDevice device_{some_device(), unit_};
  std::uint32_t sequence_ = 0;
};

TEST_F(Exported, AReadWaitsForItsAnswer) {
  EXPECT_TRUE(in(512).empty());
  EXPECT_TRUE(in(512).empty());
  const int n_reads = unit_.n_reads;
  EXPECT_TRUE(in(512).empty());
  EXPECT_EQ(unit_.n_reads, n_reads) << "the unit is not asked again while nothing happens";
  const auto done = out(bytes_of({1, 2, 3}));
  ASSERT_EQ(done.size(), 2U);
  EXPECT_EQ(done[0].moved_bytes, 3U);
  EXPECT_EQ(done[1].sequence, 1U) << "the first that waited";
  EXPECT_EQ(done[1].data, bytes_of({1, 2, 3}));
  EXPECT_EQ(device_.n_waiting(), 2U);
}

TEST_F(Exported, UnlinkTakesAWaitingReadBackOnce) {
  static_cast<void>(in(512));
  const Completion taken = device_.unlink({100, 0x10002, 1});
  EXPECT_TRUE(taken.unlink);
  EXPECT_EQ(taken.sequence, 100U);
  EXPECT_EQ(taken.status, -ECONNRESET);
  EXPECT_EQ(device_.unlink({101, 0x10002, 1}).status, 0);
  EXPECT_EQ(out(bytes_of({9})).size(), 1U) << "nobody reads the echo";
  EXPECT_EQ(in(512).size(), 1U);
}

TEST_F(Exported, AStalledEndpointStaysHaltedUntilItIsCleared) {
  unit_.in_status = EPIPE;
  auto done = in(512);
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0].status, -EPIPE);
  EXPECT_EQ(in(512).at(0).status, -EPIPE);
  EXPECT_EQ(control(bytes_of({0x82, 0, 0, 0, 0x82, 0, 2, 0})).data, bytes_of({1, 0}));
  EXPECT_EQ(control(bytes_of({0x82, 0, 0, 0, 0x01, 0, 2, 0})).data, bytes_of({0, 0}));
  EXPECT_EQ(control(bytes_of({0x02, 1, 0, 0, 0x82, 0, 0, 0})).status, 0);
  EXPECT_EQ(unit_.cleared, std::vector<Endpoint>{0x82});
  EXPECT_EQ(control(bytes_of({0x82, 0, 0, 0, 0x82, 0, 2, 0})).data, bytes_of({0, 0}));
  EXPECT_TRUE(in(512).empty()) << "it waits again";
}

TEST_F(Exported, TheHostCanHaltAnEndpoint) {
  static_cast<void>(in(512));
  SubmitRequest halt = request(false, 0, 0);
  const Bytes setup = bytes_of({0x02, 3, 0, 0, 0x82, 0, 0, 0});
  std::copy(setup.begin(), setup.end(), halt.setup.begin());
  const auto done = submit(std::move(halt));
  ASSERT_EQ(done.size(), 2U);
  EXPECT_EQ(done[1].status, -EPIPE) << "what waits ends";
  EXPECT_EQ(out(bytes_of({1})).at(0).status, 0) << "the other endpoint works";
}

TEST_F(Exported, FailuresOfTheUnitAreErrnos) {
  unit_.out_status = EPIPE;
  EXPECT_EQ(out(bytes_of({1})).at(0).status, -EPIPE);
  EXPECT_EQ(control(bytes_of({0x02, 1, 0, 0, 0x01, 0, 0, 0})).status, 0);
  static_cast<void>(out(Bytes(600)));
  EXPECT_EQ(in(512).at(0).status, -EOVERFLOW);
  unit_.out_status = ETIMEDOUT;
  EXPECT_TRUE(out(bytes_of({1})).empty()) << "nobody takes it: it waits";
  EXPECT_EQ(device_.unlink({100, 0x10002, sequence_}).status, -ECONNRESET);
  unit_.in_status = ENODEV;
  EXPECT_EQ(in(512).at(0).status, -ENODEV);
  EXPECT_TRUE(device_.gone());
  EXPECT_EQ(out(bytes_of({1})).at(0).status, -ENODEV);
}

TEST_F(Exported, UnknownEndpointsStallAndTheInterruptEndpointIsSilent) {
  EXPECT_EQ(submit(request(true, 5, 8)).at(0).status, -EPIPE);
  EXPECT_EQ(submit(request(false, 2, 0)).at(0).status, -EPIPE) << "2 only sends";
  const int n_reads = unit_.n_reads;
  EXPECT_TRUE(submit(request(true, 3, 8)).empty());
  EXPECT_EQ(unit_.n_reads, n_reads);
  EXPECT_EQ(out(bytes_of({1})).size(), 1U);
  EXPECT_EQ(in(512).size(), 1U) << "it waits for nobody else";
  SubmitRequest elsewhere = request(true, 2, 8);
  elsewhere.device_id = 0x20002;
  EXPECT_EQ(submit(std::move(elsewhere)).at(0).status, -ENODEV);
}

TEST_F(Exported, AReadThatMustNotBeShortHoldsWhatIsBehindIt) {
  static_cast<void>(in(512, 1));
  static_cast<void>(in(512, 1));
  auto done = out(bytes_of({1}));
  ASSERT_EQ(done.size(), 2U);
  EXPECT_EQ(done[1].status, -EREMOTEIO);
  EXPECT_EQ(done[1].moved_bytes, 1U);
  unit_.echoes.push_back(bytes_of({2}));
  EXPECT_EQ(device_.unlink({100, 0x10002, 2}).status, -ECONNRESET);
  done = in(512);
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0].data, bytes_of({2}));
}

TEST_F(Exported, EveryStandardRequestIsAnsweredOrStalled) {
  const auto data = [&](std::initializer_list<int> setup) { return control(bytes_of(setup)).data; };
  const auto status = [&](std::initializer_list<int> setup) {
    return control(bytes_of(setup)).status;
  };
  EXPECT_EQ(data({0x80, 0, 0, 0, 0, 0, 2, 0}), bytes_of({1, 0})) << "self powered";
  EXPECT_EQ(data({0x81, 0, 0, 0, 0, 0, 2, 0}), bytes_of({0, 0}));
  EXPECT_EQ(data({0x80, 8, 0, 0, 0, 0, 1, 0}), bytes_of({1}));
  EXPECT_EQ(data({0x81, 10, 0, 0, 0, 0, 1, 0}), bytes_of({0}));
  EXPECT_EQ(data({0x80, 6, 0, 1, 0, 0, 8, 0}).size(), 8U) << "cut to what was asked";
  EXPECT_EQ(data({0x80, 6, 0, 1, 0, 0, 255, 0}).size(), 18U);
  EXPECT_EQ(status({0x00, 5, 9, 0, 0, 0, 0, 0}), 0) << "SET_ADDRESS";
  EXPECT_EQ(status({0x01, 11, 0, 0, 0, 0, 0, 0}), 0) << "SET_INTERFACE";
  EXPECT_EQ(status({0x01, 11, 1, 0, 0, 0, 0, 0}), -EPIPE);
  EXPECT_EQ(status({0x00, 3, 1, 0, 0, 0, 0, 0}), -EPIPE) << "no remote wake-up";
  EXPECT_EQ(status({0x00, 7, 0, 1, 0, 0, 18, 0}), -EPIPE) << "SET_DESCRIPTOR";
  EXPECT_EQ(status({0x82, 12, 0, 0, 0x82, 0, 2, 0}), -EPIPE) << "SYNCH_FRAME";
  EXPECT_EQ(status({0xA0, 0, 0, 0, 0, 0, 2, 0}), -EPIPE) << "of a class";
  EXPECT_EQ(status({0x80, 6, 0, 9, 0, 0, 2, 0}), -EPIPE);
  EXPECT_EQ(status({0x00, 9, 2, 0, 0, 0, 0, 0}), -EPIPE) << "no second configuration";
  EXPECT_EQ(unit_.n_resets, 0);
  EXPECT_EQ(status({0x00, 9, 0, 0, 0, 0, 0, 0}), 0);
  EXPECT_EQ(in(512).at(0).status, -EPIPE) << "not configured";
  EXPECT_EQ(status({0x00, 9, 1, 0, 0, 0, 0, 0}), 0);
  EXPECT_EQ(unit_.n_resets, 2);
  EXPECT_TRUE(in(512).empty());
}

TEST_F(Exported, RequestsOfTheVendorGoToTheUnit) {
  EXPECT_EQ(control(bytes_of({0x40, 0x0C, 0x85, 0, 7, 0, 3, 0})).moved_bytes, 3U);
  ASSERT_EQ(unit_.requests.size(), 1U);
  EXPECT_EQ(unit_.requests[0], (ControlRequest{0x40, 0x0C, 0x85, 7}));
  const Completion answer = control(bytes_of({0xC0, 0x0C, 0x84, 0, 0, 0, 8, 0}));
  EXPECT_EQ(answer.status, 0);
  EXPECT_EQ(answer.data.size(), 3U) << "a short answer is one";

  // A stall of endpoint 0 is over with the next request; silence lasts until the host gives up.
  unit_.control_status = EPIPE;
  EXPECT_EQ(control(bytes_of({0x40, 0x0C, 0x85, 0, 0, 0, 1, 0})).status, -EPIPE);
  EXPECT_EQ(control(bytes_of({0x40, 0x0C, 0x85, 0, 0, 0, 1, 0})).status, 0);
  unit_.control_status = ETIMEDOUT;
  SubmitRequest silent = request(false, 0, 1);
  silent.setup = {std::byte{0x40}, std::byte{0x0C}, std::byte{0x85}, {}, {}, {}, std::byte{1}, {}};
  silent.data.resize(1);
  EXPECT_TRUE(submit(silent).empty());
  UnlinkRequest unlink;
  unlink.unlink_sequence = silent.sequence;
  EXPECT_EQ(device_.unlink(unlink).status, -ECONNRESET);
  unit_.control_status = ENODEV;
  EXPECT_EQ(control(bytes_of({0x40, 0x0C, 0x85, 0, 0, 0, 1, 0})).status, -ENODEV);
  EXPECT_TRUE(device_.gone());
}

TEST_F(Exported, AUnitThatDoesNotBearAResetIsNotReset) {
  DeviceDescription tender = some_device();
  tender.bears_reset = false;
  ExportedDevice device(tender, unit_);
  device.detach();
  EXPECT_EQ(unit_.n_resets, 0);
  EXPECT_EQ(unit_.cleared.size(), tender.endpoints.size());
}

TEST_F(Exported, DetachingForgetsTheClient) {
  static_cast<void>(in(512));
  static_cast<void>(out(bytes_of({1})));
  static_cast<void>(out(bytes_of({2})));
  device_.detach();
  EXPECT_EQ(device_.n_waiting(), 0U);
  EXPECT_EQ(unit_.n_resets, 1);
  EXPECT_TRUE(in(512).empty()) << "nothing of the last client is left in the pipe";
}

}  // namespace
}  // namespace reseau::usbip
