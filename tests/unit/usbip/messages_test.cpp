#include "drivers/usbip/messages.h"

#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/usbip/description.h"
#include "tests/unit/usbip/fake_unit.h"

namespace reseau::usbip {
namespace {

Bytes submit_bytes(std::uint32_t sequence, bool in, std::uint32_t endpoint, std::uint32_t length,
                   std::uint32_t n_packets = 0) {
  Bytes bytes(48);
  store_be(bytes, 0, 4, 1);
  store_be(bytes, 4, 4, sequence);
  store_be(bytes, 8, 4, 0x10002);
  store_be(bytes, 12, 4, in ? 1 : 0);
  store_be(bytes, 16, 4, endpoint);
  store_be(bytes, 24, 4, length);
  store_be(bytes, 32, 4, n_packets);
  return bytes;
}

TEST(UsbipMessages, OperationsAreCutFromAStreamByteByByte) {
  RequestReader reader;
  Bytes stream =
      bytes_of({1, 0x11, 0x80, 5, 0, 0, 0, 0, 1, 0x11, 0x80, 3, 0, 0, 0, 0, '1', '-', '1'});
  stream.resize(48);
  std::vector<Request> got;
  for (const std::byte byte : stream) {
    reader.feed({&byte, 1});
    while (auto request = reader.next()) got.push_back(*std::move(request));
  }
  ASSERT_EQ(got.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<DeviceListRequest>(got[0]));
  EXPECT_EQ(std::get<ImportRequest>(got[1]).bus_id, "1-1");
}

TEST(UsbipMessages, AnotherVersionOrOperationIsUnknown) {
  RequestReader reader;
  reader.feed(bytes_of({1, 0x06, 0x80, 5, 0, 0, 0, 0, 1, 0x11, 0x80, 9, 0, 0, 0, 0}));
  EXPECT_EQ(std::get<UnknownRequest>(*reader.next()).code, 0x8005);
  EXPECT_EQ(std::get<UnknownRequest>(*reader.next()).code, 0x8009);
  EXPECT_FALSE(reader.next());
}

TEST(UsbipMessages, TransfersCarryTheirData) {
  RequestReader reader;
  reader.attach();
  Bytes bytes = submit_bytes(7, false, 1, 3);
  for (const int value : {10, 20, 30}) bytes.push_back(std::byte(value));
  const Bytes second = submit_bytes(8, true, 2, 512, 0xFFFFFFFF);
  bytes.insert(bytes.end(), second.begin(), second.end());
  reader.feed(ByteView(bytes).first(50));
  EXPECT_FALSE(reader.next()) << "one byte of data is missing";
  reader.feed(ByteView(bytes).subspan(50));
  const auto out = std::get<SubmitRequest>(*reader.next());
  EXPECT_EQ(out.sequence, 7U);
  EXPECT_FALSE(out.in);
  EXPECT_EQ(out.data, bytes_of({10, 20, 30}));
  const auto in = std::get<SubmitRequest>(*reader.next());
  EXPECT_TRUE(in.in);
  EXPECT_EQ(in.length, 512U);
  EXPECT_TRUE(in.data.empty());
}

TEST(UsbipMessages, WhatIsNoTransferEndsTheStream) {
  for (const Bytes& wrong : {submit_bytes(1, true, 16, 1), submit_bytes(1, true, 1, 0xFFFFFFFF),
                             submit_bytes(1, true, 1, kMaxTransferBytes + 1),
                             submit_bytes(1, true, 1, 8, 4), Bytes(48)}) {
    RequestReader reader;
    reader.attach();
    reader.feed(wrong);
    EXPECT_THROW(static_cast<void>(reader.next()), InputError) << hex_of(wrong, 48);
  }
}

TEST(UsbipMessages, RepliesHaveTheDocumentedLength) {
  DeviceSummary device;
  device.path = std::string(400, 'x');
  device.bus_id = "1-1";
  EXPECT_EQ(encode_device_list({device}).size(), 12U + 312 + 4);
  EXPECT_EQ(encode_device_list({}).size(), 12U);
  const Bytes import = encode_import(device);
  ASSERT_EQ(import.size(), 8U + 312);
  EXPECT_EQ(u8_at(import, 8 + 255), 0) << "a path that is too long still ends";
  EXPECT_EQ(hex_of(ByteView(import).subspan(8 + 256, 4)), "31 2D 31 00");
  EXPECT_EQ(hex_of(encode_import(std::nullopt)), "01 11 00 03 00 00 00 01");
  EXPECT_EQ(hex_of(encode_refusal(0x8009)), "01 11 00 09 00 00 00 01");
  Completion completion;
  completion.sequence = 0x01020304;
  completion.status = -32;
  completion.moved_bytes = 2;
  completion.data = bytes_of({0xAA, 0xBB});
  Bytes bytes;
  append_completion(completion, bytes);
  ASSERT_EQ(bytes.size(), 50U);
  EXPECT_EQ(load_be(bytes, 0, 4), 3U);
  EXPECT_EQ(load_be(bytes, 4, 4), 0x01020304U);
  EXPECT_EQ(load_be(bytes, 20, 4), 0xFFFFFFE0U);
  EXPECT_EQ(load_be(bytes, 24, 4), 2U);
}

TEST(UsbDescription, DescriptorsOfAHighSpeedUnit) {
  DeviceDescription device = some_device();
  device.endpoints.pop_back();
  EXPECT_EQ(hex_of(*descriptor(device, kDeviceDescriptor, 0)),
            "12 01 00 02 FF FF FF 40 B0 04 02 40 03 01 01 02 00 01");
  EXPECT_EQ(hex_of(*descriptor(device, kConfigurationDescriptor, 0)),
            "09 02 20 00 01 01 00 C0 01 09 04 00 00 02 FF FF FF 00 07 05 01 02 00 02 00 07 05 82 "
            "02 00 02 00");
  EXPECT_EQ(hex_of(*descriptor(device, kOtherSpeedDescriptor, 0)),
            "09 07 20 00 01 01 00 C0 01 09 04 00 00 02 FF FF FF 00 07 05 01 02 40 00 00 07 05 82 "
            "02 40 00 00");
  EXPECT_EQ(hex_of(*descriptor(device, kQualifierDescriptor, 0)), "0A 06 00 02 FF FF FF 40 01 00");
  EXPECT_EQ(hex_of(*descriptor(device, kStringDescriptor, 0)), "04 03 09 04");
  EXPECT_EQ(hex_of(*descriptor(device, kStringDescriptor, 1)),
            "0C 03 4E 00 69 00 6B 00 6F 00 6E 00");
  EXPECT_FALSE(descriptor(device, kStringDescriptor, 3)) << "no serial";
  EXPECT_FALSE(descriptor(device, kConfigurationDescriptor, 1));
  EXPECT_FALSE(descriptor(device, 4, 0));
  device.high_speed = false;
  EXPECT_FALSE(descriptor(device, kQualifierDescriptor, 0));
  EXPECT_EQ(hex_of(ByteView(*descriptor(device, kConfigurationDescriptor, 0)).subspan(18, 7)),
            "07 05 01 02 40 00 00");
}

}  // namespace
}  // namespace reseau::usbip
