#include <cerrno>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/error.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/pcapng_writer.h"

namespace reseau {
namespace {

namespace fs = std::filesystem;

class CaptureFile : public testing::Test {
 protected:
  CaptureFile() {
    fs::remove(path_);
    UsbPacket out;
    out.id = 1;
    out.endpoint = 0x01;
    out.length = 6;
    out.time_us = 1'700'000'000'123'456;
    out.data = Bytes(6, std::byte{0x12});
    out.comment = "open";
    UsbPacket out_done = out;
    out_done.submission = false;
    out_done.data.clear();
    out_done.comment.clear();
    UsbPacket in;
    in.id = 2;
    in.endpoint = 0x82;
    in.length = 512;
    UsbPacket in_done = in;
    in_done.submission = false;
    in_done.length = 3;
    in_done.data = Bytes(3, std::byte{7});
    UsbPacket failed = in;
    failed.id = 3;
    UsbPacket failed_done = failed;
    failed_done.submission = false;
    failed_done.status = -ETIMEDOUT;
    packets_ = {out, out_done, in, in_done, failed, failed_done};
  }
  ~CaptureFile() override { fs::remove(path_); }

  void write() {
    fs::remove(path_);
    PcapngWriter writer(path_, "a comment");
    for (const UsbPacket& packet : packets_) writer.write(packet);
  }
  std::vector<char> load() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void store(const std::vector<char>& bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  int count() const {
    TransferReader reader(path_);
    int n = 0;
    while (reader.next()) ++n;
    return n;
  }

  fs::path path_ = fs::temp_directory_path() / ("reseau_capture_" + std::to_string(getpid()));
  std::vector<UsbPacket> packets_;
};

TEST_F(CaptureFile, KeepsTransfersCommentsTimesAndErrors) {
  write();
  TransferReader reader(path_);
  const auto out = reader.next();
  ASSERT_TRUE(out);
  EXPECT_EQ(reader.comment(), "a comment");
  EXPECT_EQ(out->comment, "open");
  EXPECT_EQ(out->started_us, 1'700'000'000'123'456);
  EXPECT_EQ(out->data.size(), 6U);
  EXPECT_EQ(out->packet_number, 1U);
  const auto in = reader.next();
  ASSERT_TRUE(in);
  EXPECT_EQ(in->asked_bytes, 512U);
  EXPECT_EQ(in->data, Bytes(3, std::byte{7}));
  EXPECT_EQ(in->packet_number, 3U);
  const auto failed = reader.next();
  ASSERT_TRUE(failed);
  EXPECT_EQ(failed->status, -ETIMEDOUT);
  EXPECT_FALSE(reader.next());
}

TEST_F(CaptureFile, NeverOverwritesARecording) {
  write();
  EXPECT_THROW(PcapngWriter(path_, ""), std::system_error);
}

TEST_F(CaptureFile, CutAnywhereItReadsUpToTheCut) {
  write();
  const std::vector<char> whole = load();
  int last = 0;
  for (std::size_t n = 28; n <= whole.size(); ++n) {
    store({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)});
    const int now = count();
    EXPECT_GE(now, last);
    last = now;
  }
  EXPECT_EQ(last, 3);
}

TEST_F(CaptureFile, AnyDamageIsReadOrRefusedButNeverHarmful) {
  write();
  const std::vector<char> whole = load();
  std::mt19937 random(20261122);
  int refused = 0;
  for (int round = 0; round < 500; ++round) {
    std::vector<char> bytes = whole;
    for (unsigned i = 0; i <= random() % 4; ++i) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    store(bytes);
    try {
      EXPECT_LE(count(), 3);
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
}

TEST_F(CaptureFile, SaysWhatIsNoCapture) {
  store(std::vector<char>(100, 'x'));
  EXPECT_THROW(CaptureReader{path_}, InputError);
  store({});
  EXPECT_THROW(CaptureReader{path_}, InputError);
  fs::remove(path_);
  EXPECT_THROW(CaptureReader{path_}, std::system_error);
}

void append(Bytes& to, const Bytes& from) { to.insert(to.end(), from.begin(), from.end()); }

TEST_F(CaptureFile, ReadsClassicPcapOfUsbmonWithBothHeaders) {
  for (const int link_type : {kLinkUsbmon48, kLinkUsbmon64}) {
    Bytes file;
    append_le(file, 4, 0xA1B2C3D4);
    append_le(file, 4, 0x00040002);
    append_le(file, 8, 0);
    append_le(file, 4, 0xFFFF);
    append_le(file, 4, static_cast<std::uint64_t>(link_type));
    for (const UsbPacket& packet : packets_) {
      Bytes content = encode_usbmon(packet);
      if (link_type == kLinkUsbmon48) content.erase(content.begin() + 48, content.begin() + 64);
      append_le(file, 4, 1);
      append_le(file, 4, 2);
      append_le(file, 4, content.size());
      append_le(file, 4, content.size());
      append(file, content);
    }
    std::vector<char> bytes;
    for (const std::byte b : file) bytes.push_back(static_cast<char>(b));
    store(bytes);
    EXPECT_EQ(count(), 3) << link_type;
  }
}

TEST(UsbPcapPacket, IsDecoded) {
  // Header of 27 bytes: IRP 5, success, function 9, from the device, bus 1, device 4, endpoint 82.
  Bytes b;
  append_le(b, 2, 27);
  append_le(b, 8, 5);
  append_le(b, 4, 0);
  append_le(b, 2, 9);
  append_le(b, 1, 1);
  append_le(b, 2, 1);
  append_le(b, 2, 4);
  append_le(b, 1, 0x82);
  append_le(b, 1, 3);
  append_le(b, 4, 2);
  append_le(b, 2, 0xBBAA);
  const auto packet = decode_usb_packet(b, kLinkUsbPcap, false, 99);
  ASSERT_TRUE(packet);
  EXPECT_FALSE(packet->submission);
  EXPECT_EQ(packet->endpoint, 0x82);
  EXPECT_EQ(packet->data, bytes_of({0xAA, 0xBB}));
  EXPECT_FALSE(packet->length) << "USBPcap does not say how much was asked for";
  b.resize(20);
  EXPECT_FALSE(decode_usb_packet(b, kLinkUsbPcap, false, 99));
}

}  // namespace
}  // namespace reseau
