// Simulated PIE units, transfer by transfer, by a host that shares nothing with the driver.
#include <algorithm>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/sim/pie/pie_model.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/usb/usb_transport.h"

namespace reseau::sim {
namespace {

using Bytes8 = std::vector<std::uint8_t>;

class PieHost {
 public:
  explicit PieHost(const std::string& name) : usb_(open_simulated_unit(name)) {}

  void port(int number, int value) {
    const std::byte byte{static_cast<std::uint8_t>(value)};
    usb_->control_out({0x40, 0x0C, static_cast<std::uint16_t>(number), 0}, std::span(&byte, 1),
                      Duration(1000));
  }
  void knock(int mode = 0xE0) {
    for (const int v : {0xFF, 0xAA, 0x55, 0x00, 0xFF, 0x87, 0x78, mode}) port(0x88, v);
    port(0x87, 0x05);
    port(0x87, 0x04);
    port(0x88, 0xFF);
  }
  int status() {
    std::byte byte{};
    EXPECT_EQ(usb_->control_in({0xC0, 0x0C, 0x84, 0}, std::span(&byte, 1), Duration(1000)), 1U);
    return std::to_integer<int>(byte);
  }
  int settled() {
    int s = status();
    while (s == 0x03) s = status();
    return s;
  }
  int command(int op, int length, const Bytes8& out = {}) {
    knock();
    for (const int v : {op, 0, 0, length >> 8, length & 0xFF, 0}) port(0x85, v);
    int s = settled();
    if (s != 0 || out.empty()) return s;
    for (const int v : out) port(0x85, v);
    return settled();
  }
  Bytes8 data(std::size_t n) {
    Bytes8 all;
    while (all.size() < n) {
      const std::size_t window = std::min<std::size_t>(n - all.size(), 32768);
      std::vector<std::byte> size(8);
      for (std::size_t i = 0; i < 4; ++i) size[4 + i] = std::byte(window >> (8 * i) & 0xFF);
      usb_->control_out({0x40, 0x04, 0x82, 0}, size, Duration(1000));
      std::vector<std::byte> buffer((window + 511) / 512 * 512);
      const std::size_t got = usb_->bulk_in(0x81, buffer, Duration(1000));
      for (std::size_t i = 0; i < got; ++i) all.push_back(std::to_integer<std::uint8_t>(buffer[i]));
    }
    return all;
  }
  Bytes8 ask(int op, std::size_t n) {
    EXPECT_EQ(command(op, static_cast<int>(n)), 0x01) << op;
    Bytes8 bytes = data(n);
    EXPECT_EQ(settled(), 0x00);
    return bytes;
  }
  std::string sense() {
    const Bytes8 s = ask(0x03, 14);
    char text[16];
    std::snprintf(text, sizeof text, "%02X/%02X/%02X", unsigned{s[2]}, unsigned{s[12]},
                  unsigned{s[13]});
    return text;
  }
  int write(const Bytes8& payload) {
    return command(0x0A, static_cast<int>(payload.size()), payload);
  }
  int mode(int dpi, int passes, int quality) {
    const auto b = [](int v) { return static_cast<std::uint8_t>(v & 0xFF); };
    return command(0x15, 16,
                   {0, 0x0F, b(dpi), b(dpi >> 8), b(passes), 0x20, 4, 0, 1, b(quality),
                    b(quality >> 8), 0, 0, 0x80, 0x10, 0});
  }
  UsbTransport& usb() { return *usb_; }

 private:
  std::unique_ptr<UsbTransport> usb_;
};

const Bytes8 kFrame{0x12, 0, 10, 0, 0x80, 0, 0, 0, 0, 0, 0xEF, 0, 0x77, 0};  // 240 x 120
const Bytes8 kConfirm{0x17, 0, 2, 0, 1, 0};

TEST(PieWire, ListensOnlyAfterItsKnock) {
  PieHost host("sim:rps7200");
  for (const int v : {0x12, 0, 0, 0, 5, 0}) host.port(0x85, v);
  EXPECT_EQ(host.status(), 0x00) << "nothing was taken";
  EXPECT_THROW((void)host.data(5), DeviceError);
  host.usb().clear_halt(0x81);
  EXPECT_EQ(host.ask(0x12, 5)[4], 180);
  // One command per knock.
  for (const int v : {0x12, 0, 0, 0, 5, 0}) host.port(0x85, v);
  EXPECT_THROW((void)host.data(5), DeviceError);
}

TEST(PieWire, EveryModelSaysWhoItIsInTwoSteps) {
  for (const std::string& name : pie::pie_model_names()) {
    PieHost host("sim:" + name);
    EXPECT_EQ(host.usb().identity().vendor_id, 0x05E3);
    EXPECT_EQ(host.usb().identity().bulk_in, 0x81);
    const std::size_t length = host.ask(0x12, 5)[4] + std::size_t{4};
    EXPECT_EQ(length, 184U);
    const Bytes8 all = host.ask(0x12, length);
    const pie::PieModel* const model = pie::find_pie_model(name);
    EXPECT_EQ(all[116], model->number);
    EXPECT_EQ(all[36] | all[37] << 8, model->max_dpi);
  }
}

TEST(PieWire, SenseIsGoneWhenItWasRead) {
  PieHost host("sim:rps7200");
  EXPECT_EQ(host.command(0xE7, 4), 0x02);
  EXPECT_EQ(host.sense(), "05/20/00");
  EXPECT_EQ(host.sense(), "00/00/00");
  EXPECT_EQ(host.command(0x1B, 1), 0x02);
  EXPECT_EQ(host.sense(), "05/2C/00") << "no frame, no mode";
}

TEST(PieWire, AHaltedPipeTakesEveryRequestWithIt) {
  PieHost host("sim:crystalscan3600");
  std::vector<std::byte> buffer(512);
  EXPECT_THROW((void)host.usb().bulk_in(0x81, buffer, Duration(1000)), DeviceError);
  EXPECT_THROW((void)host.status(), DeviceError);
  host.usb().clear_halt(0x81);
  EXPECT_EQ(host.status(), 0x00);
}

TEST(PieWire, ConfirmingTheFrameComesAfterTheFrame) {
  PieHost host("sim:rps7200");
  EXPECT_EQ(host.write(kConfirm), 0x02);
  EXPECT_EQ(host.sense(), "05/2C/00");
  EXPECT_EQ(host.write(kFrame), 0x00);
  EXPECT_EQ(host.write(kConfirm), 0x00);
}

TEST(PieWire, LengthsAreChecked) {
  PieHost host("sim:rps7200");
  Bytes8 wrong = kFrame;
  wrong[2] = 9;
  EXPECT_EQ(host.write(wrong), 0x02);
  EXPECT_EQ(host.sense(), "06/1A/00");
  EXPECT_EQ(host.command(0x15, 15), 0x02);
  EXPECT_EQ(host.command(0xDC, 28), 0x02);
  EXPECT_EQ(host.command(0x0F, 17), 0x02);
  Bytes8 outside = kFrame;
  outside[11] = 0xFF;
  EXPECT_EQ(host.write(outside), 0x02);
  EXPECT_EQ(host.sense(), "05/26/00");
}

TEST(PieWire, ACommonUnitCalibratesBeforeTheImage) {
  PieHost host("sim:crystalscan3600?noise=0");
  EXPECT_EQ(host.write(kFrame), 0x00);
  EXPECT_EQ(host.mode(300, 0x80, 0), 0x00);
  EXPECT_EQ(host.command(0x1B, 1), 0x02);
  EXPECT_EQ(host.sense(), "06/82/00");
  constexpr std::size_t kStride = 2 + 2 * 5340;
  std::string tags;
  for (int i = 0; i < 80; i += 4) {
    EXPECT_EQ(host.command(0x08, 4), 0x01);
    const Bytes8 lines = host.data(4 * kStride);
    for (std::size_t k = 0; k < 4; ++k) tags += static_cast<char>(lines[k * kStride]);
  }
  EXPECT_EQ(tags.substr(0, 8), "RGBIRGBI");
  const Bytes8 parameters = host.ask(0x0F, 18);
  EXPECT_EQ(parameters[0], 240 / 12);
  EXPECT_EQ(parameters[2], 120 / 12);
  const Bytes8 mask = host.ask(0x18, 5340);
  EXPECT_EQ(std::count(mask.begin(), mask.end(), 0), 20);
  EXPECT_EQ(host.command(0x08, 30), 0x01);
  EXPECT_EQ(host.data(30 * 42).size(), 30U * 42U);
  EXPECT_EQ(host.command(0x08, 1), 0x02);
  EXPECT_EQ(host.sense(), "05/20/00");
  // It holds its calibration now.
  EXPECT_EQ(host.write(kFrame), 0x00);
  EXPECT_EQ(host.mode(300, 0x80, 0x0008), 0x00);
  EXPECT_EQ(host.command(0x1B, 1), 0x00);
}

TEST(PieWire, AnRpsCalibratesInAPassOfItsOwnWithDarkLines) {
  PieHost host("sim:rps7200?noise=0");
  EXPECT_EQ(host.write(kFrame), 0x00);
  EXPECT_EQ(host.write(kConfirm), 0x00);
  EXPECT_EQ(host.mode(300, 0x80, 0x0008), 0x00);
  EXPECT_EQ(host.command(0x1B, 1), 0x02);
  EXPECT_EQ(host.sense(), "06/82/00");
  EXPECT_EQ(host.mode(300, 0x80, 0x0800), 0x00);
  EXPECT_EQ(host.command(0x1B, 1), 0x00);
  constexpr std::size_t kStride = 2 + 2 * 5172;
  int n_dark = 0, n_light = 0;
  for (int i = 0; i < 160; i += 4) {
    ASSERT_EQ(host.command(0x08, 4), 0x01);
    const Bytes8 lines = host.data(4 * kStride);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t middle = k * kStride + 2 + 5172;
      const int value = lines[middle] | lines[middle + 1] << 8;
      (value < 1000 ? n_dark : n_light) += 1;
    }
  }
  EXPECT_EQ(n_dark, 80);
  EXPECT_EQ(n_light, 80);
  EXPECT_EQ(host.command(0x08, 4), 0x02);
  EXPECT_EQ(host.sense(), "05/20/00");
  EXPECT_EQ(host.write(kFrame), 0x00);
  EXPECT_EQ(host.write(kConfirm), 0x00);
  EXPECT_EQ(host.mode(300, 0x80, 0x0008), 0x00);
  EXPECT_EQ(host.command(0x1B, 1), 0x00);
  // A pass that was begun has to be read before anything is set.
  EXPECT_EQ(host.write(kFrame), 0x02);
}

TEST(PieWire, WhatHangsAnRpsHangsThisOne) {
  const auto hung = [](PieHost& host) {
    try {
      (void)host.status();
      return false;
    } catch (const DeviceError& error) {
      return error.kind() == DeviceError::Kind::kTimeout;
    }
  };
  PieHost stopped("sim:rps7200");
  EXPECT_FALSE(hung(stopped));
  EXPECT_THROW((void)stopped.command(0x1B, 0), DeviceError);
  EXPECT_TRUE(hung(stopped));
  PieHost moved("sim:rps7200");
  EXPECT_THROW((void)moved.command(0xD2, 4), DeviceError);
  EXPECT_TRUE(hung(moved));
  PieHost reset("sim:rps7200");
  reset.knock(0x30);
  EXPECT_TRUE(hung(reset));
  PieHost port("sim:rps7200");
  port.usb().reset();
  EXPECT_TRUE(hung(port));
}

TEST(PieWire, SurvivesAnyBytes) {
  std::mt19937 random(20261124);
  for (const char* const name : {"sim:rps7200?film=none", "sim:digitdia6000?film=none"}) {
    PieHost host(name);
    for (int round = 0; round < 3000; ++round) {
      try {
        const int op = static_cast<int>(random() % 256);
        if (op == 0x1B || op == 0xD2) continue;
        Bytes8 out(random() % 20);
        for (std::uint8_t& b : out) b = static_cast<std::uint8_t>(random());
        const int s = host.command(op, static_cast<int>(random() % 400), out);
        if (s == 0x01) (void)host.data(14);
      } catch (const DeviceError&) {
        host.usb().clear_halt(0x81);
      }
    }
    EXPECT_EQ(host.ask(0x12, 5)[4], 180) << name;
  }
}

TEST(PieWire, AnUnknownModelIsToldWithAllThatThereAre) {
  try {
    (void)open_simulated_unit("sim:rps9000");
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("rps7200"), std::string::npos) << text;
    EXPECT_NE(text.find("ls5000"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace reseau::sim
