#include <random>
#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/pieusb/bridge.h"
#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/models.h"
#include "drivers/pieusb/never.h"
#include "drivers/pieusb/replies.h"
#include "drivers/pieusb/sense.h"
#include "drivers/pieusb/unit.h"
#include "drivers/virtual_clock.h"
#include "tests/unit/drivers/pieusb_units.h"
#include "tests/unit/drivers/scripted_transport.h"

namespace reseau::pieusb {
namespace {

TEST(PieCommands, EveryByteHasItsPlace) {
  EXPECT_EQ(hex_of(command_of(Op::kRead, 216).bytes()), "08 00 00 00 D8 00");
  EXPECT_EQ(hex_of(command_of(Op::kCopy, 5340).bytes()), "18 00 00 14 DC 00");
  EXPECT_EQ(hex_of(scan_frame_data({0, 3431, 10343, 6888})),
            "12 00 0A 00 80 00 00 00 67 0D 67 28 E8 1A");
  EXPECT_EQ(hex_of(filter_percentage_data(0x13, 4)), "13 00 04 00 04 00 64 00");
  EXPECT_EQ(hex_of(prepare_calibration_info_data()), "95 00 00 00 00 00");
  EXPECT_EQ(hex_of(confirm_frame_data()), "17 00 02 00 01 00");
  EXPECT_EQ(hex_of(mode_data({3600, true, 16, 0x0088})),
            "00 0F 10 0E 90 20 04 00 01 88 00 00 00 80 10 00");
  EXPECT_EQ(hex_of(mode_data({300, false, 8, 0x0008})),
            "00 0F 2C 01 80 04 04 00 01 08 00 00 00 80 10 00");
  GainOffset gain;
  gain.exposure = {2937, 0x0102, 0x0304, 0x0506};
  gain.offset = {1, 2, 3, 4};
  gain.gain = {19, 20, 21, 22};
  gain.infrared = true;
  EXPECT_EQ(hex_of(gain_data(gain)),
            "79 0B 02 01 04 03 01 02 03 00 00 00 13 14 15 04 01 00 06 05 04 00 16 00 00 00 00 01 "
            "00");
}

TEST(PieCommands, AreNamedForPeople) {
  EXPECT_EQ(describe(command_of(Op::kRead, 63)), "READ, 63 lines [08 00 00 00 3F 00]");
  EXPECT_EQ(describe(command_of(Op::kScan, 1)), "SCAN, start [1B 00 00 00 01 00]");
}

TEST(PieReplies, AreParsedFieldByField) {
  const Inquiry i = parse_inquiry(pie_inquiry(0x31, 7200, 10344, 6888, true));
  EXPECT_EQ(i.vendor, "PIE");
  EXPECT_EQ(i.product, "MF Scanner");
  EXPECT_EQ(i.firmware, "1.70");
  EXPECT_EQ(i.model_number, 0x31);
  EXPECT_EQ(i.max_dpi, 7200);
  EXPECT_EQ(i.depths_bits, (std::vector<int>{8, 16}));
  EXPECT_TRUE(i.infrared && i.one_pass && i.index_format && i.confirms_frame);
  EXPECT_EQ(i.max_exposure, 65535);
  const CalibrationInfo info = parse_calibration_info(
      bytes_of({0x95, 0,    0x1C, 0,  4,    6,    4,    0,                           //
                0x00, 0x10, 0x10, 20, 0x34, 0x14, 0x08, 0x10, 0x10, 20, 0x34, 0x14,  //
                0x10, 0x10, 0x10, 20, 0x34, 0x14, 0x20, 0x10, 0x10, 20, 0x34, 0x14}));
  EXPECT_EQ(info.n_lines, 80);
  EXPECT_EQ(info.width_px, 5172);
  EXPECT_EQ(parse_mask(bytes_of({0x70, 0, 0, 0x70, 0})), (std::vector<int>{1, 2, 4}));
  const Sense sense = parse_sense(bytes_of({0x70, 0, 0x06, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0x82, 0x00}));
  EXPECT_TRUE(must_calibrate(sense));
  EXPECT_NE(pie_sentence(sense).find("[06/82/00]"), std::string::npos);
}

TEST(PieReplies, NoBytesCrashAParser) {
  std::mt19937 random(20261124);
  const auto tried = [](auto parse) {
    try {
      parse();
    } catch (const DeviceError& error) {
      EXPECT_NE(std::string(error.what()), "");
    }
  };
  for (int round = 0; round < 20000; ++round) {
    Bytes b(random() % 200);
    for (std::byte& byte : b) byte = std::byte(random() % 256);
    tried([&] { (void)parse_inquiry(b); });
    tried([&] { (void)parse_state(b, true); });
    tried([&] { (void)parse_gain(b); });
    tried([&] { (void)parse_calibration_info(b); });
    tried([&] { (void)parse_parameters(b); });
    tried([&] { (void)parse_sense(b); });
    tried([&] { (void)inquiry_length(b); });
    (void)parse_mask(b);
  }
}

TEST(PieSense, EveryCodeIsASentence) {
  for (int key = 0; key < 16; ++key) {
    for (int code = 0; code < 256; ++code) {
      Sense sense;
      sense.key = static_cast<std::uint8_t>(key);
      sense.asc = static_cast<std::uint8_t>(code);
      const std::string sentence = pie_sentence(sense);
      EXPECT_GT(sentence.size(), 20U);
      EXPECT_EQ(sentence.back(), ']');
    }
  }
  EXPECT_NE(pie_sentence(kUnknownSense).find("got lost"), std::string::npos);
}

// The list of pieusb/README.md, *Never*, line by line.
TEST(PieNever, NothingOfTheListLeavesTheProgram) {
  ScriptedTransport usb;  // expects no transfer at all
  VirtualClock clock;
  PieBridge bridge(usb, clock);
  const auto refused = [&](const Cdb& cdb, const Bytes& out, std::size_t in_bytes) {
    Bytes in(in_bytes);
    try {
      if (!out.empty()) {
        (void)bridge.send(cdb, out, Duration(1));
      } else if (in_bytes > 0) {
        (void)bridge.receive(cdb, in, Duration(1));
      } else {
        (void)bridge.command(cdb, Duration(1));
      }
      ADD_FAILURE() << describe(cdb);
    } catch (const DeviceError& error) {
      EXPECT_EQ(error.kind(), DeviceError::Kind::kRefused) << error.what();
    }
  };
  refused(command_of(Op::kScan, 0), {}, 0);
  refused(command_of(Op::kSetScanHead, 4), bytes_of({2, 0, 0, 0}), 0);
  refused(command_of(Op::kModeSense, 16), {}, 16);
  refused(command_of(Op::kVendorE7, 4), {}, 4);
  refused(command_of(Op::kRead, 64), {}, 64 * 100);
  refused(command_of(Op::kRead, 217), {}, 217 * 100);
  refused(command_of(Op::kRead, 100), {}, 100 * 6000);
  refused(command_of(Op::kRead, 10), {}, 1001);
  refused(command_of(Op::kSlide, 4), bytes_of({0x40, 1, 0, 0}), 0);
  refused(command_of(Op::kSlide, 4), bytes_of({0x00, 88, 0, 4}), 0);
  refused(command_of(Op::kWrite, 8), bytes_of({0x13, 0, 4, 0, 2, 0, 50, 0}), 0);
  refused(command_of(Op::kWrite, 8), bytes_of({0x10, 0, 4, 0, 2, 0, 50, 0}), 0);
  refused(command_of(Op::kWrite, 14), scan_frame_data({5, 5, 4, 9}), 0);
  Bytes far_end = mode_data({300, false, 8, 8});
  far_end[14] = std::byte{0x11};
  refused(command_of(Op::kModeSelect, 16), far_end, 0);
  Bytes one_filter = mode_data({300, false, 8, 8});
  one_filter[4] = std::byte{0x02};
  refused(command_of(Op::kModeSelect, 16), one_filter, 0);
  refused(Cdb{0x28, 0, 0, 0, 0, 0, 0, 0, 1, 0}, {}, 1);
}

TEST(PieNever, OnlyWhatTheDriverUsesPasses) {
  std::mt19937 random(5);
  int n_passed = 0;
  for (int round = 0; round < 200000; ++round) {
    const int op = static_cast<int>(random() % 256);
    const int length = static_cast<int>(random() % 300);
    const Cdb cdb{op, 0, 0, length >> 8, length & 0xFF, 0};
    Bytes out(random() % 2 == 0 ? static_cast<std::size_t>(length) : 0);
    for (std::byte& b : out) b = std::byte(random() % 256);
    const std::size_t in_bytes = out.empty() ? static_cast<std::size_t>(length) : 0;
    if (why_never(cdb, out, in_bytes) != nullptr) continue;
    ++n_passed;
    EXPECT_NE(op, 0xD2);
    EXPECT_NE(op, 0xE7);
    EXPECT_NE(op, 0x1A);
    if (op == 0x1B) {
      EXPECT_EQ(length, 1);
    }
  }
  EXPECT_GT(n_passed, 100);
}

TEST(PieRead, AsksForAsManyLinesAsTheVendorButNever64) {
  EXPECT_EQ(lines_for_read(10000, 864), 216);
  EXPECT_EQ(lines_for_read(10000, 20690), 25);
  EXPECT_EQ(lines_for_read(10000, 8192), 63) << "512 KiB would be 64 lines";
  EXPECT_EQ(lines_for_read(64, 864), 63);
  EXPECT_EQ(lines_for_read(1, 864), 1);
  EXPECT_EQ(lines_for_read(3, 2'000'000), 1);
  for (int left = 1; left < 1000; ++left) {
    for (const std::size_t bytes : {10U, 864U, 5000U, 8192U, 20690U}) {
      const int n = lines_for_read(left, bytes);
      ASSERT_TRUE(n >= 1 && n <= left && n != 64);
      ASSERT_EQ(why_never(command_of(Op::kRead, n), {}, static_cast<std::size_t>(n) * bytes),
                nullptr);
    }
  }
}

TEST(PieModels, AreFoundByTheirNumber) {
  for (const Model& model : models()) {
    EXPECT_EQ(model_by_number(model.number), &model);
    EXPECT_TRUE(is_known_usb_id(kGenesysVendorId, model.product_id));
  }
  EXPECT_EQ(model_by_number(0), nullptr);
  EXPECT_FALSE(is_known_usb_id(kGenesysVendorId, 0x0608)) << "a hub of the same maker";
  EXPECT_FALSE(is_known_usb_id(0x04B0, 0x0145));
}

}  // namespace
}  // namespace reseau::pieusb
