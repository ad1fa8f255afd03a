#include "drivers/scsi/nikon_usb_scsi.h"

#include <cerrno>

#include <gtest/gtest.h>

#include "drivers/coolscan/commands.h"
#include "drivers/virtual_clock.h"
#include "tests/unit/drivers/scripted_transport.h"

namespace reseau {
namespace {

using namespace std::chrono_literals;

const Bytes kGood = bytes_of({0, 0, 0, 0, 0, 0, 0, 0});
const Bytes kQuery = bytes_of({0xD0});
const Bytes kTestUnitReady = bytes_of({0, 0, 0, 0, 0, 0});

Bytes copy_of(const Cdb& cdb) { return {cdb.bytes().begin(), cdb.bytes().end()}; }

TEST(NikonUsbScsi, RunsCommandQueryPhaseStatusWithoutStatusRequest) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({1})).in(kGood);
  NikonUsbScsi scsi(usb, clock);
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), 1s).good);
}

TEST(NikonUsbScsi, ReadsSenseFromTheStatusBlock) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({1})).in(bytes_of({2, 2, 0x3A, 0, 1, 0, 0, 0}));
  NikonUsbScsi scsi(usb, clock);
  const ScsiReply reply = scsi.command(coolscan::test_unit_ready(), 1s);
  EXPECT_FALSE(reply.good);
  EXPECT_EQ(reply.sense, (Sense{2, 0x3A, 0, 1, false}));
}

TEST(NikonUsbScsi, AsksAgainWhileTheUnitIsBusy) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady)
      .out(kQuery)
      .in(bytes_of({4}))
      .out(kQuery)
      .in(bytes_of({4}))
      .out(kQuery)
      .in(bytes_of({1}))
      .in(kGood);
  NikonUsbScsi scsi(usb, clock);
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), 1s).good);
  EXPECT_GE(clock.now().time_since_epoch(), 10ms);
}

// A query that got lost: the unit took the next command for it, and answers no more.
TEST(NikonUsbScsi, SendsAgainWhatABusyUnitAnswersNoMoreWellBeforeTheDeadline) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({4})).out(kQuery).in_fails(ETIMEDOUT);
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({1})).in(kGood);
  NikonUsbScsi scsi(usb, clock);
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), 180s).good);
  EXPECT_GT(usb.in_timeouts.at(0), 100s) << "a cold unit takes its time";
  EXPECT_LE(usb.in_timeouts.at(1), 7s);
}

TEST(NikonUsbScsi, GivesUpOnAUnitThatStaysBusy) {
  VirtualClock clock;
  ScriptedTransport usb;
  // Three attempts, each until the deadline of the whole command.
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({4})).out(kQuery).in(bytes_of({4}));
  usb.in_fails(ETIMEDOUT);  // the drain
  NikonUsbScsi scsi(usb, clock);
  try {
    (void)scsi.command(coolscan::test_unit_ready(), 3ms);
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kTimeout);
  }
}

TEST(NikonUsbScsi, SkipsTheDataOfARefusedCommand) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(copy_of(coolscan::inquiry()))
      .out(kQuery)
      .in(bytes_of({1}))
      .in(bytes_of({2, 6, 0x28, 0, 0, 0, 0, 0}));
  NikonUsbScsi scsi(usb, clock);
  Bytes data(coolscan::kInquiryBytes);
  const ScsiReply reply = scsi.receive(coolscan::inquiry(), data, 1s);
  EXPECT_EQ(reply.received, 0U);
  EXPECT_TRUE(reply.sense.is(SenseKey::kUnitAttention));
}

TEST(NikonUsbScsi, JoinsDataThatComesInSeveralTransfers) {
  // As recorded: 21188 bytes came as 20992 and 196.
  VirtualClock clock;
  ScriptedTransport usb;
  const Cdb cdb = coolscan::read(coolscan::DataType::kFrameTable, coolscan::Colour::kRed, 3, 21188);
  Bytes first(20992, std::byte{1}), second(196, std::byte{2});
  usb.out(copy_of(cdb)).out(kQuery).in(bytes_of({3})).in(first).in(second).in(kGood);
  NikonUsbScsi scsi(usb, clock);
  Bytes data(21188);
  EXPECT_EQ(scsi.receive(cdb, data, 1s).received, 21188U);
  EXPECT_EQ(data[20991], std::byte{1});
  EXPECT_EQ(data[20992], std::byte{2});
}

TEST(NikonUsbScsi, DropsThePaddingOfTheLastPacketAndOfTheStatus) {
  VirtualClock clock;
  ScriptedTransport usb;
  Bytes padded(512, std::byte{0xAA});
  Bytes status = kGood;
  status.resize(512, std::byte{0x55});
  usb.out(copy_of(coolscan::inquiry())).out(kQuery).in(bytes_of({3})).in(padded).in(status);
  NikonUsbScsi scsi(usb, clock);
  Bytes data(coolscan::kInquiryBytes);
  EXPECT_TRUE(scsi.receive(coolscan::inquiry(), data, 1s).good);
}

TEST(NikonUsbScsi, DrainsStaleAnswersAndRepeatsTheFirstCommand) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady).out(kQuery).in(kGood);  // eight bytes where one was expected
  usb.in(bytes_of({1})).in(kGood).in_fails(ETIMEDOUT);
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({1})).in(kGood);
  NikonUsbScsi scsi(usb, clock);
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), 1s).good);
  EXPECT_EQ(usb.n_clear_halts, 2);
}

TEST(NikonUsbScsi, NeverRepeatsAnImageRead) {
  VirtualClock clock;
  ScriptedTransport usb;
  const Cdb cdb = coolscan::read(coolscan::DataType::kImage, coolscan::Colour::kDefault, 1, 1024);
  usb.out(copy_of(cdb)).out(kQuery).in(bytes_of({3})).in_fails(EPIPE).in_fails(ETIMEDOUT);
  NikonUsbScsi scsi(usb, clock);
  Bytes data(1024);
  EXPECT_THROW((void)scsi.receive(cdb, data, 1s), DeviceError);
}

TEST(NikonUsbScsi, SendsALostCommandAgainAtFullSpeed) {
  // An LS-40: "busy" means that the command was lost, and no further query is answered.
  VirtualClock clock;
  ScriptedTransport usb(64);
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({4})).out(kQuery).in_fails(ETIMEDOUT);
  usb.out(kTestUnitReady).out(kQuery).in(bytes_of({1})).in(kGood);
  NikonUsbScsi scsi(usb, clock);
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), 30s).good);
}

TEST(NikonUsbScsi, LetsADisconnectionThroughAtOnce) {
  VirtualClock clock;
  ScriptedTransport usb;
  usb.out(kTestUnitReady).out(kQuery).in_fails(ENODEV);
  NikonUsbScsi scsi(usb, clock);
  try {
    (void)scsi.command(coolscan::test_unit_ready(), 1s);
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kDisconnected);
  }
}

}  // namespace
}  // namespace reseau
