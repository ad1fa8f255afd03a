// The USB wrapper: command, phase, data, status; and a unit that misbehaves.
#include <functional>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

const Bytes kTestUnitReady(6, 0);
const Bytes kQuery{0xd0};

DeviceError::Kind kind_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const DeviceError& error) {
    return error.kind();
  }
  ADD_FAILURE() << "no DeviceError";
  return DeviceError::Kind::kBusy;
}

TEST(Wire, CommandPhaseStatus) {
  SimHost host("sim:ls5000");
  host.out(kTestUnitReady);
  host.out(kQuery);
  EXPECT_EQ(host.in(512), Bytes{0x01});
  EXPECT_EQ(host.in(512), Bytes(8, 0));
}

TEST(Wire, IdentityIsTheModels) {
  SimHost ls5000("sim:ls5000"), ls50("sim:ls50");
  EXPECT_EQ(ls5000.usb().identity().vendor_id, 0x04b0);
  EXPECT_EQ(ls5000.usb().identity().product_id, 0x4002);
  EXPECT_EQ(ls50.usb().identity().product_id, 0x4001);
  EXPECT_EQ(ls50.usb().identity().max_packet_bytes, 512);
}

TEST(Wire, ShortPacketsAreIgnoredWhileIdle) {
  SimHost host("sim:ls5000");
  for (std::size_t n = 1; n < 6; ++n) host.out(Bytes(n, 0xd0));
  EXPECT_EQ(kind_of([&] { host.in(512); }), DeviceError::Kind::kTimeout);
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
}

TEST(Wire, StatusComesWithAndWithout06) {
  SimHost host("sim:ls5000");
  for (const bool with_06 : {true, false, true}) {
    const Exchange e = host.run("120000002480", 36, {}, with_06);
    EXPECT_EQ(e.phase, 3);
    EXPECT_EQ(e.data.size(), 36U);
    EXPECT_EQ(e.status, SimHost::kGoodStatus);
  }
}

TEST(Wire, AnythingButAQueryAfterACommandGivesBusyAndLosesTheCommand) {
  SimHost host("sim:ls5000");
  host.out(kTestUnitReady);
  host.out(Bytes{0x06});
  EXPECT_EQ(host.in(1), Bytes{0x04});
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
}

TEST(Wire, RefusalSkipsTheDataPhase) {
  SimHost host("sim:ls5000");
  const Exchange in = host.run(
      "280000000000004000"
      "80",
      64);  // image READ without a scan
  EXPECT_EQ(in.phase, 1);
  EXPECT_EQ(in.status, "02052c0000000000");
  const Exchange out = host.run("24000000000000ffff80", 0, Bytes(10));
  EXPECT_EQ(out.phase, 1);
  EXPECT_EQ(out.status, "0205240000000000");
}

TEST(Wire, ZeroLengthHasNoDataPhase) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(host.run("120000000000").phase, 1);
  EXPECT_EQ(host.run("151000000000").phase, 1);
}

TEST(Wire, DataOutMayComeInPieces) {
  SimHost host("sim:ls5000");
  const Bytes list = from_hex("000000080000000000000001030600000fa00000");
  host.out(from_hex("151000001400"));
  host.out(kQuery);
  EXPECT_EQ(host.in(1), Bytes{0x02});
  host.out(ByteView(list).first(7));
  host.out(ByteView(list).subspan(7));
  EXPECT_EQ(to_hex(host.in(8)), SimHost::kGoodStatus);
}

TEST(Wire, BusyPhaseIsAnsweredAsOftenAsAsked) {
  SimHost host("sim:ls5000?busy_phases=3&busy_polls=0&width_px=64&height_px=64&border_px=0");
  WindowList window{.dpi = 4000, .composition = 2, .width = 64, .height = 4};
  host.run(kSetWindow, 0, window.list());
  EXPECT_EQ(host.send("1b0000000100", "01").status, "0209800601000000");
  host.run("28008700000000002180", 33);
  EXPECT_EQ(host.send("1b0000000100", "01").status, SimHost::kGoodStatus);
  host.wait_ready();
  host.out(from_hex("28000000000100020080"));
  for (int n = 0; n < 3; ++n) {
    host.out(kQuery);
    EXPECT_EQ(host.in(1), Bytes{0x04});
  }
  host.out(kQuery);
  EXPECT_EQ(host.in(1), Bytes{0x03});
}

TEST(Wire, StaleBytesComeFirst) {
  SimHost host("sim:ls5000?stale=8");
  host.out(kTestUnitReady);
  host.out(kQuery);
  EXPECT_EQ(host.in(512).size(), 8U);
  EXPECT_EQ(host.in(512), Bytes{0x01});
}

TEST(Wire, FragmentsEndAtPackets) {
  SimHost host("sim:ls50?fragment=1024");
  host.out(from_hex("28000300010100800080"));
  host.out(kQuery);
  EXPECT_EQ(host.in(1), Bytes{0x03});
  for (int n = 0; n < 32; ++n) EXPECT_EQ(host.in(32768).size(), 1024U);
  EXPECT_EQ(to_hex(host.in(8)), SimHost::kGoodStatus);
}

TEST(Wire, ABufferThatEndsInsideAPacketIsAnErrorAndLosesThePacket) {
  SimHost host("sim:ls5000");
  host.out(from_hex("120000002480"));
  host.out(kQuery);
  EXPECT_EQ(host.in(1), Bytes{0x03});
  EXPECT_EQ(kind_of([&] { host.in(20); }), DeviceError::Kind::kProtocol);
  EXPECT_EQ(to_hex(host.in(8)), SimHost::kGoodStatus);
}

TEST(Wire, UnpluggedAtEveryTransfer) {
  for (int n = 1; n <= 8; ++n) {
    SimHost host("sim:ls5000?unplug_after=" + std::to_string(n));
    const auto talk = [&] {
      for (int k = 0; k < 4; ++k) host.run("120000002480", 36);
    };
    EXPECT_EQ(kind_of(talk), DeviceError::Kind::kDisconnected);
    EXPECT_EQ(kind_of(talk), DeviceError::Kind::kDisconnected);
  }
}

TEST(Wire, AStallLastsUntilItIsCleared) {
  SimHost host("sim:ls5000?stall_after=3");
  host.out(kTestUnitReady);
  host.out(kQuery);
  EXPECT_EQ(kind_of([&] { host.in(1); }), DeviceError::Kind::kStall);
  EXPECT_EQ(kind_of([&] { host.in(1); }), DeviceError::Kind::kStall);
  host.usb().clear_halt(kBulkIn);
  EXPECT_EQ(host.in(1), Bytes{0x01});
  EXPECT_EQ(to_hex(host.in(8)), SimHost::kGoodStatus);
}

TEST(Wire, ASilentUnitTimesOut) {
  SimHost host("sim:ls5000?silent_after=4");
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
  EXPECT_EQ(kind_of([&] { host.test_unit_ready(); }), DeviceError::Kind::kTimeout);
}

TEST(Wire, ResetPutsTheWrapperBackInStep) {
  SimHost host("sim:ls5000?stale=100");
  host.out(kTestUnitReady);
  host.usb().reset();
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
}

TEST(OpenSimulatedUnit, NamesTheModelsItKnows) {
  try {
    (void)open_simulated_unit("sim:ls9");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("ls5000, ls50"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace reseau::sim
