// Vendor requests on endpoint 0 through everything that stands on the transport seam.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/error.h"
#include "drivers/usb/fault_transport.h"
#include "drivers/usb/recording_transport.h"
#include "drivers/usb/replay_transport.h"
#include "drivers/virtual_clock.h"
#include "tests/unit/drivers/scripted_transport.h"

namespace reseau {
namespace {

namespace fs = std::filesystem;

constexpr ControlRequest kWrite{0x40, 0x0C, 0x0085, 0};
constexpr ControlRequest kStatus{0xC0, 0x0C, 0x0084, 0};

// Keeps what is written to it and answers with a counter.
class Ports final : public UsbTransport {
 public:
  Ports() {
    identity_.vendor_id = 0x05E3;
    identity_.product_id = 0x0145;
    identity_.bulk_in = 0x81;
  }
  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint, std::span<const std::byte>, Duration) override {}
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration) override {
    EXPECT_EQ(endpoint, 0x81);
    std::fill(buffer.begin(), buffer.end(), std::byte{9});
    return buffer.size();
  }
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration) override {
    requests.push_back(request);
    written.insert(written.end(), data.begin(), data.end());
  }
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration) override {
    requests.push_back(request);
    buffer[0] = std::byte(n_reads++);
    return 1;
  }
  void clear_halt(Endpoint) override {}
  void reset() override {}

  std::vector<ControlRequest> requests;
  Bytes written;
  int n_reads = 0;

 private:
  UsbIdentity identity_;
};

int status_of(UsbTransport& usb) {
  Bytes one(1);
  EXPECT_EQ(usb.control_in(kStatus, one, Duration(1)), 1U);
  return u8_at(one, 0);
}

TEST(ControlTransfer, AUnitWithoutRequestsOfItsOwnStallsThem) {
  ScriptedTransport plain;
  try {
    plain.control_out(kWrite, bytes_of({1}), Duration(1));
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kStall);
    EXPECT_NE(error.detail().find("control OUT"), std::string::npos) << error.detail();
  }
}

TEST(ControlTransfer, ASetupPacketHoldsTheFieldsLittleEndian) {
  EXPECT_EQ(hex_of(setup_of_request({0x40, 0x04, 0x0082, 0x0102}, 0x0308)),
            "40 04 82 00 02 01 08 03");
  EXPECT_TRUE(is_vendor_request(setup_of_request(kStatus, 1)));
  EXPECT_FALSE(is_vendor_request(clear_halt_setup(0x81)));
  EXPECT_FALSE(is_vendor_request(reset_setup()));
}

TEST(ControlTransfer, FaultsAreCountedAmongThem) {
  auto inner = std::make_unique<Ports>();
  Ports& ports = *inner;
  FaultTransport usb(std::move(inner), {Fault::Kind::kStall, 1});
  usb.control_out(kWrite, bytes_of({7}), Duration(1));
  EXPECT_THROW(usb.control_out(kWrite, bytes_of({8}), Duration(1)), DeviceError);
  EXPECT_EQ(hex_of(ports.written), "07") << "the unit never saw the second";
  EXPECT_EQ(status_of(usb), 0);
  EXPECT_EQ(usb.n_transfers(), 3);

  FaultTransport cut(std::make_unique<Ports>(), {Fault::Kind::kShort, 0});
  Bytes one(1);
  EXPECT_EQ(cut.control_in(kStatus, one, Duration(1)), 0U);
}

class RecordedControl : public testing::Test {
 protected:
  RecordedControl() {
    fs::remove(path_);
    VirtualClock clock;
    RecordingTransport usb(std::make_unique<Ports>(), clock, path_, {"sim:ports", "", ""});
    usb.annotate("open");
    usb.control_out(kWrite, bytes_of({0x12}), Duration(1));
    EXPECT_EQ(status_of(usb), 0);
    Bytes data(512);
    EXPECT_EQ(usb.bulk_in(0x81, data, Duration(1)), 512U);
  }
  ~RecordedControl() override { fs::remove(path_); }

  fs::path path_ =
      fs::temp_directory_path() / ("reseau_control_" + std::to_string(getpid()) + ".pcapng");
  VirtualClock clock_;
};

TEST_F(RecordedControl, PlaysBackWithTheIdentityOfTheUnit) {
  ReplayTransport replay(path_, clock_, {});
  EXPECT_EQ(replay.identity().product_id, 0x0145);
  EXPECT_EQ(replay.identity().bulk_in, 0x81);
  replay.control_out(kWrite, bytes_of({0x12}), Duration(1));
  EXPECT_EQ(status_of(replay), 0);
  Bytes data(512);
  EXPECT_EQ(replay.bulk_in(0x81, data, Duration(1)), 512U);
  EXPECT_EQ(u8_at(data, 511), 9);
}

TEST_F(RecordedControl, AnotherByteOrAnotherPortIsADifference) {
  const auto message = [this](const ControlRequest& request, int byte) -> std::string {
    ReplayTransport replay(path_, clock_, {});
    try {
      replay.control_out(request, bytes_of({byte}), Duration(1));
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message(kWrite, 0x12), "");
  EXPECT_NE(message(kWrite, 0x13).find("40 0C 85 00 00 00 01 00, data 12"), std::string::npos)
      << message(kWrite, 0x13);
  EXPECT_NE(message({0x40, 0x0C, 0x0088, 0}, 0x12).find("phase \"open\""), std::string::npos);
}

}  // namespace
}  // namespace reseau
