#include "drivers/scsi/sg_scsi.h"

#include <cerrno>
#include <deque>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <scsi/sg.h>
#include <sys/ioctl.h>

#include "core/base/error.h"
#include "drivers/coolscan/commands.h"
#include "drivers/scsi/nikon_usb_scsi.h"
#include "drivers/scsi/scsi_as_usb.h"
#include "drivers/virtual_clock.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

// What the kernel answers to one SG_IO.
struct Answer {
  int error = 0;  // errno of the ioctl
  unsigned char status = 0;
  unsigned short host_status = 0;
  Bytes sense{};
  Bytes data{};
};

class FakeKernel {
 public:
  IoctlCall call() {
    return [this](int, unsigned long request, void* argument) { return answer(request, argument); };
  }
  std::deque<Answer> answers;
  std::vector<Bytes> cdbs, outs;
  std::vector<unsigned> timeouts_ms;
  int reserved_bytes = 0;

 private:
  int answer(unsigned long request, void* argument) {
    if (request == SG_SET_RESERVED_SIZE) {
      reserved_bytes = *static_cast<int*>(argument);
      return 0;
    }
    EXPECT_EQ(request, static_cast<unsigned long>(SG_IO));
    auto& io = *static_cast<sg_io_hdr_t*>(argument);
    EXPECT_EQ(io.interface_id, 'S');
    const auto* cdb = reinterpret_cast<const std::byte*>(io.cmdp);
    cdbs.emplace_back(cdb, cdb + io.cmd_len);
    timeouts_ms.push_back(io.timeout);
    const Answer a = answers.empty() ? Answer{} : answers.front();
    if (!answers.empty()) answers.pop_front();
    if (a.error != 0) {
      errno = a.error;
      return -1;
    }
    auto* bytes = static_cast<std::byte*>(io.dxferp);
    if (io.dxfer_direction == SG_DXFER_TO_DEV) outs.emplace_back(bytes, bytes + io.dxfer_len);
    if (io.dxfer_direction == SG_DXFER_FROM_DEV) {
      std::copy(a.data.begin(), a.data.end(), bytes);
      io.resid = static_cast<int>(io.dxfer_len - a.data.size());
    }
    io.status = a.status;
    io.masked_status = static_cast<unsigned char>(a.status >> 1);
    io.host_status = a.host_status;
    std::copy(a.sense.begin(), a.sense.end(), reinterpret_cast<std::byte*>(io.sbp));
    io.sb_len_wr = static_cast<unsigned char>(a.sense.size());
    return 0;
  }
};

// As firewire-sbp2 repacks it: 19 bytes, Nikon's code at [15].
Bytes sense(int key, int asc, int ascq, int tsc) {
  Bytes data(19);
  data[0] = std::byte{0x70};
  data[2] = std::byte(key);
  data[7] = std::byte{0x0B};
  data[12] = std::byte(asc);
  data[13] = std::byte(ascq);
  data[15] = std::byte(tsc);
  return data;
}

class SgScsiTest : public testing::Test {
 protected:
  SgScsi make() { return {make_sg_node(open("/dev/null", O_RDONLY), kernel.call()), clock}; }
  FakeKernel kernel;
  VirtualClock clock;
};

TEST_F(SgScsiTest, PassesCommandsAndDataAsTheyAre) {
  SgScsi scsi = make();
  EXPECT_GE(kernel.reserved_bytes, 128 * 1024);
  const Bytes data = coolscan::mode_select_data(4000);
  EXPECT_TRUE(scsi.send(coolscan::mode_select(), data, std::chrono::seconds(30)).good);
  ASSERT_EQ(kernel.outs.size(), 1U);
  EXPECT_EQ(kernel.outs[0], data);
  EXPECT_EQ(kernel.timeouts_ms[0], 30000U);

  kernel.answers.push_back({.data = bytes_of({1, 2, 3, 4})});
  Bytes in(6);
  const ScsiReply reply = scsi.receive(coolscan::inquiry(), in, std::chrono::seconds(1));
  EXPECT_TRUE(reply.good);
  EXPECT_EQ(reply.received, 4U) << "the kernel counts what did not come";
  EXPECT_EQ(u8_at(in, 3), 4);
}

TEST_F(SgScsiTest, FindsNikonsCodeAtByte15) {
  SgScsi scsi = make();
  kernel.answers.push_back({.status = 0x02, .sense = sense(2, 4, 3, 6)});
  const ScsiReply reply = scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1));
  EXPECT_FALSE(reply.good);
  EXPECT_EQ(reply.sense, (Sense{2, 4, 3, 6, false}));
  EXPECT_EQ(decode_sense_data(bytes_of({0x72, 0x05, 0x2C, 0x00})), (Sense{5, 0x2C, 0, 0, false}));
  EXPECT_EQ(decode_sense_data(bytes_of({0x70, 0, 0x2B})), (Sense{0xB, 0, 0, 0, true}));
  EXPECT_EQ(decode_sense_data({}), Sense{});
  for (std::size_t n = 0; n < 32; ++n) (void)decode_sense_data(Bytes(n, std::byte{0xA5}));
}

TEST_F(SgScsiTest, AsksABusyUnitAgainUntilTheTimeIsOver) {
  SgScsi scsi = make();
  kernel.answers.push_back({.status = 0x08});
  kernel.answers.push_back({.host_status = 2});
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1)).good);
  EXPECT_EQ(kernel.cdbs.size(), 3U);
  for (int i = 0; i < 100; ++i) kernel.answers.push_back({.status = 0x08});
  try {
    (void)scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1));
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.kind(), DeviceError::Kind::kBusy);
  }
}

TEST_F(SgScsiTest, SaysWhatIsWrong) {
  const auto kind_of = [&](const Answer& answer) {
    SgScsi scsi = make();
    kernel.answers = {answer};
    try {
      (void)scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1));
    } catch (const DeviceError& error) {
      EXPECT_NE(std::string(error.what()), "");
      return error.kind();
    }
    ADD_FAILURE() << "no error";
    return DeviceError::Kind::kProtocol;
  };
  EXPECT_EQ(kind_of({.status = 0x18}), DeviceError::Kind::kBusy) << "RESERVATION CONFLICT";
  EXPECT_EQ(kind_of({.host_status = 1}), DeviceError::Kind::kDisconnected);
  EXPECT_EQ(kind_of({.host_status = 3}), DeviceError::Kind::kTimeout);
  EXPECT_EQ(kind_of({.host_status = 7}), DeviceError::Kind::kProtocol);
  EXPECT_EQ(kind_of({.error = ENODEV}), DeviceError::Kind::kDisconnected);
  EXPECT_EQ(kind_of({.status = 0x02}), DeviceError::Kind::kProtocol) << "no sense";
  EXPECT_EQ(kind_of({.status = 0x22}), DeviceError::Kind::kProtocol);
  SgScsi scsi = make();
  kernel.answers = {{.error = EPERM}};
  EXPECT_THROW((void)scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1)),
               std::system_error);
  kernel.answers = {{.error = EINTR}, {}};
  EXPECT_TRUE(scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1)).good);
}

TEST_F(SgScsiTest, AMissingNodeIsSaid) {
  EXPECT_THROW((void)open_sg_node("/dev/there/is/none"), std::system_error);
  EXPECT_THROW((void)open_sg_node("/dev/null"), DeviceError);
}

TEST_F(SgScsiTest, ListsScannersOnly) {
  const test::TempDir dir;
  const auto put = [&](const std::string& node, const std::string& type, const std::string& model) {
    const auto device = dir.path() / node / "device";
    std::filesystem::create_directories(device);
    std::ofstream(device / "type") << type << "\n";
    std::ofstream(device / "vendor") << "Nikon   \n";
    std::ofstream(device / "model") << model << "\n";
  };
  put("sg0", "0", "a disk");
  put("sg1", "6", "LS-9000 ED      ");
  const std::vector<SgDeviceInfo> found = list_sg_scanners(dir.path().string());
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].path, "/dev/sg1");
  EXPECT_EQ(found[0].product, "LS-9000 ED");
  EXPECT_TRUE(list_sg_scanners("/there/is/none").empty());
}

// The wrapper and its opposite cancel each other.
TEST_F(SgScsiTest, ASessionLooksLikeThatOfAUsbUnit) {
  ScsiLink link = sg_scsi_link(make_sg_node(open("/dev/null", O_RDONLY), kernel.call()), clock);
  ScsiAsUsb usb(std::move(link));
  NikonUsbScsi scsi(usb, clock);
  const Bytes data = coolscan::mode_select_data(4000);
  EXPECT_TRUE(scsi.send(coolscan::mode_select(), data, std::chrono::seconds(1)).good);
  EXPECT_EQ(kernel.outs.at(0), data);
  kernel.answers.push_back({.data = Bytes(36, std::byte{0x5A})});
  Bytes in(36);
  EXPECT_EQ(scsi.receive(coolscan::inquiry(), in, std::chrono::seconds(1)).received, 36U);
  EXPECT_EQ(in, Bytes(36, std::byte{0x5A}));
  kernel.answers.push_back({.status = 0x02, .sense = sense(5, 0x24, 0, 0)});
  EXPECT_EQ(scsi.receive(coolscan::inquiry(), in, std::chrono::seconds(1)).sense,
            (Sense{5, 0x24, 0, 0, false}));
  kernel.answers.push_back({.status = 0x02, .sense = sense(2, 0x3A, 0, 1)});
  EXPECT_EQ(scsi.command(coolscan::test_unit_ready(), std::chrono::seconds(1)).sense,
            (Sense{2, 0x3A, 0, 1, false}));
}

}  // namespace
}  // namespace reseau
