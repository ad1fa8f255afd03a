// Recordings read as commands, checked, blanked, cut, imported.
#include "drivers/sessions.h"

#include <algorithm>
#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/families.h"
#include "drivers/registry.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/pcapng_writer.h"
#include "drivers/usb/recording_transport.h"
#include "tests/replay/simulated_scan.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

constexpr const char* kSerial = "DF123456";

// A simulated unit with a serial number, which is also among its data.
class SerialUsb final : public UsbTransport {
 public:
  explicit SerialUsb(std::unique_ptr<UsbTransport> inner)
      : inner_(std::move(inner)), identity_(inner_->identity()) {
    identity_.serial = kSerial;
  }
  const UsbIdentity& identity() const override { return identity_; }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override {
    inner_->bulk_out(endpoint, data, timeout);
  }
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override {
    return inner_->bulk_in(endpoint, buffer, timeout);
  }
  void clear_halt(Endpoint endpoint) override { inner_->clear_halt(endpoint); }
  void reset() override { inner_->reset(); }

 private:
  std::unique_ptr<UsbTransport> inner_;
  UsbIdentity identity_;
};

class Sessions : public testing::Test {
 protected:
  // A small scan of a unit with a serial, recorded.
  Outcome record(const std::filesystem::path& path) {
    const auto clock = std::make_shared<VirtualClock>();
    auto usb = std::make_unique<RecordingTransport>(
        std::make_unique<SerialUsb>(sim::open_simulated_unit("sim:ls5000?noise=0")), *clock, path,
        SessionHeader{std::string("usb:04b0:4002:") + kSerial, "2026-11-24T00:00:00Z", "asked"});
    coolscan::Coolscan scanner(std::move(usb), clock, {"sim:test", "2026-11-24T00:00:00Z"});
    return scan_of(scanner, small_request());
  }
  static bool holds(const std::filesystem::path& path, const std::string& text) {
    std::string wide;
    for (const char c : text) {
      wide += c;
      wide += '\0';
    }
    wide.pop_back();
    const std::string bytes = test::file_bytes(path);
    return bytes.find(text) != std::string::npos || bytes.find(wide) != std::string::npos;
  }

  test::TempDir dir_;
  std::filesystem::path file_ = dir_ / "scan.pcapng";
};

TEST_F(Sessions, ShowsEveryCommandWithWhatItMeans) {
  ASSERT_TRUE(record(file_).complete);
  std::string text;
  std::set<std::string> phases;
  int n = 0, n_good = 0;
  const ShownSession session = show_session(file_, [&](const ShownExchange& e) {
    EXPECT_EQ(e.number, ++n);
    n_good += e.good ? 1 : 0;
    // Answers that are no "good" belong to commands that are there to be answered so.
    if (!e.good) {
      EXPECT_TRUE(e.command.starts_with("TEST UNIT READY") || e.command.starts_with("SCAN"))
          << e.text;
    }
    phases.insert(e.phase);
    text += e.text;
  });
  EXPECT_EQ(session.n_exchanges, n);
  EXPECT_EQ(session.device, "04b0:4002");
  EXPECT_EQ(session.serial, kSerial);
  EXPECT_GT(n_good, n / 2);
  EXPECT_TRUE(phases.contains("scan"));
  for (const char* const part :
       {"INQUIRY", "\"Nikon   LS-5000 ED", "window red: 500 dpi", "window infrared", "colours",
        "operation A0, autofocus at a point", "the host shall remove padding", "data: image",
        "white-balance exposure", "[scan]"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

TEST_F(Sessions, AWholeRecordingHasNoProblemAndACutOneHas) {
  (void)record(file_);
  const SessionCheck good = check_session(file_);
  EXPECT_TRUE(good.problems.empty()) << good.problems.front();
  EXPECT_EQ(good.n_failed_transfers, 0);
  EXPECT_GT(good.n_not_ready, 5) << "polls while it moves";
  EXPECT_EQ(good.n_refused, 0);

  // Without its descriptors and the first command's data.
  const std::filesystem::path cut = dir_ / "cut.pcapng";
  {
    CaptureReader reader(file_);
    PcapngWriter writer(cut, "");
    for (int i = 0; auto packet = reader.next(); ++i) {
      if (i >= 40 && i != 90 && i != 91) writer.write(*packet);
    }
  }
  const SessionCheck bad = check_session(cut);
  ASSERT_GE(bad.problems.size(), 2U);
  EXPECT_NE(bad.problems[0].find("descriptors"), std::string::npos) << bad.problems[0];
}

TEST_F(Sessions, AnonymiseBlanksTheSerialEverywhereAndNothingElse) {
  const Outcome live = record(file_);
  ASSERT_TRUE(holds(file_, kSerial)) << "or this test shows nothing";
  const std::filesystem::path blanked = dir_ / "blanked.pcapng";
  RewriteOptions options;
  options.blank_serial = true;
  options.also_blank = {"2026-11-24"};
  const RewriteResult result = rewrite_session(file_, blanked, options);
  EXPECT_GE(result.n_blanked, 3);
  EXPECT_EQ(result.n_packets_left_out, 0);
  EXPECT_FALSE(holds(blanked, kSerial));
  EXPECT_FALSE(holds(blanked, "2026-11-24"));
  // It still plays.
  const OpenedScanner opened = open_scanner("replay:" + blanked.string(), {});
  EXPECT_EQ(opened.scanner->capabilities().serial, "XXXXXXXX");
  EXPECT_TRUE(scan_of(*opened.scanner, small_request()).samples == live.samples);
  EXPECT_THROW(rewrite_session(file_, blanked, options), std::system_error) << "exists";
  options.also_blank = {"abc"};
  EXPECT_THROW(rewrite_session(file_, dir_ / "other.pcapng", options), InputError);
}

TEST_F(Sessions, TrimKeepsThePartAndWhatTheUnitIs) {
  (void)record(file_);
  std::vector<std::string> all;
  show_session(file_, [&](const ShownExchange& e) { all.push_back(e.command_hex); });
  RewriteOptions options;
  options.first_exchange = 10;
  options.last_exchange = 29;
  const std::filesystem::path part = dir_ / "part.pcapng";
  EXPECT_EQ(rewrite_session(file_, part, options).n_exchanges, 20);
  std::vector<std::string> kept;
  const ShownSession session =
      show_session(part, [&](const ShownExchange& e) { kept.push_back(e.command_hex); });
  EXPECT_EQ(session.device, "04b0:4002");
  ASSERT_GE(kept.size(), 20U);
  EXPECT_TRUE(std::equal(kept.end() - 20, kept.end(), all.begin() + 9));

  RewriteOptions phase;
  phase.phase = "scan";
  const std::filesystem::path scan = dir_ / "scan-only.pcapng";
  EXPECT_GT(rewrite_session(file_, scan, phase).n_exchanges, 5);
  show_session(scan, [&](const ShownExchange& e) {
    if (e.command.rfind("control", 0) != 0) {
      EXPECT_EQ(e.phase, "scan");
    }
  });
  options.first_exchange = 100000;
  options.last_exchange = 100001;
  EXPECT_THROW(rewrite_session(file_, dir_ / "none.pcapng", options), InputError);
}

// A bridge's commands come byte by byte, and its data in transfers of another kind.
TEST_F(Sessions, CommandsOfAPieUnitAreShownAnonymisedAndPlayAgain) {
  const auto clock = std::make_shared<VirtualClock>();
  Outcome live;
  ScanRequest request;
  request.resolution_dpi = 300;
  request.area = {3.0, 4.0, 4.0, 3.0};
  {
    auto usb = std::make_unique<RecordingTransport>(
        sim::open_simulated_unit("sim:crystalscan3600?noise=0&film=none"), *clock, file_,
        SessionHeader{"sim:crystalscan3600", "2026-11-24T00:00:00Z", ""});
    live =
        scan_of(*open_family(std::move(usb), clock, {"sim:test", "2026-11-24T00:00:00Z"}), request);
  }
  ASSERT_TRUE(live.complete);
  std::string text;
  const ShownSession session = show_session(file_, [&](const ShownExchange& e) { text += e.text; });
  EXPECT_EQ(session.device, "05e3:0145");
  for (const char* const part : {"INQUIRY", "MODE SELECT", "REQUEST SENSE", "wants to calibrate",
                                 "sent 16 bytes: 00 0F", "[scan]", "good"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  const SessionCheck check = check_session(file_);
  EXPECT_TRUE(check.problems.empty()) << check.problems.front();
  RewriteOptions options;
  options.blank_serial = true;
  const std::filesystem::path copy = dir_ / "copy.pcapng";
  EXPECT_EQ(rewrite_session(file_, copy, options).n_packets_left_out, 0);
  const OpenedScanner opened = open_scanner("replay:" + copy.string(), {});
  EXPECT_TRUE(scan_of(*opened.scanner, request).samples == live.samples);
}

// USBPcap: no length asked for, 27-byte headers, another device on the bus.
void write_usbpcap(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::ofstream file(to, std::ios::binary);
  const auto put = [&](std::uint64_t value, int n) {
    for (int i = 0; i < n; ++i) file.put(static_cast<char>(value >> (8 * i) & 0xFF));
  };
  put(0xA1B2C3D4, 4);
  put(2, 2);
  put(4, 2);
  put(0, 8);
  put(0x40000, 4);
  put(249, 4);
  CaptureReader reader(from);
  const auto write = [&](const UsbPacket& packet, std::uint16_t device) {
    Bytes data = packet.data;
    if (packet.setup) data.insert(data.begin(), packet.setup->begin(), packet.setup->end());
    put(static_cast<std::uint64_t>(packet.time_us / 1000000), 4);
    put(static_cast<std::uint64_t>(packet.time_us % 1000000), 4);
    put(27 + data.size(), 4);
    put(27 + data.size(), 4);
    put(27, 2);
    put(packet.id, 8);
    put(0, 4);
    put(8, 2);
    put(packet.submission ? 0 : 1, 1);
    put(2, 2);
    put(device, 2);
    put(packet.endpoint, 1);
    put(static_cast<std::uint64_t>(packet.type), 1);
    put(data.size(), 4);
    for (const std::byte b : data) put(std::to_integer<std::uint64_t>(b), 1);
  };
  while (auto packet = reader.next()) {
    UsbPacket mouse;
    mouse.id = packet->id + (1U << 20);
    mouse.submission = packet->submission;
    mouse.type = UsbTransferType::kInterrupt;
    mouse.endpoint = 0x81;
    mouse.data = Bytes(4);
    write(mouse, 9);
    write(*packet, 5);
  }
}

TEST_F(Sessions, ACaptureOfUsbPcapIsImportedAndPlays) {
  const Outcome live = record(file_);
  const std::filesystem::path windows = dir_ / "windows.pcap";
  write_usbpcap(file_, windows);
  const std::filesystem::path imported = dir_ / "imported.pcapng";
  const RewriteResult result = rewrite_session(windows, imported, {});
  EXPECT_GT(result.n_packets_left_out, result.n_packets / 2) << "the mouse stays outside";
  EXPECT_TRUE(check_session(imported).problems.empty());
  const OpenedScanner opened = open_scanner("replay:" + imported.string(), {});
  EXPECT_TRUE(scan_of(*opened.scanner, small_request()).samples == live.samples);
}

TEST_F(Sessions, TheRecordedNikonScanSessionIsImported) {
  const std::filesystem::path lines =
      RESEAU_SHARED_DIR "/data/sessions/ls5000-nikonscan4-rgbi4.jsonl";
  if (!std::filesystem::exists(lines)) GTEST_SKIP() << "the recorded session is not here";
  EXPECT_EQ(rewrite_session(lines, file_, {}).n_exchanges, 607);
  int n_commands = 0, n_images = 0;
  std::string text;
  show_session(file_, [&](const ShownExchange& e) {
    if (e.command.rfind("control", 0) == 0) return;
    ++n_commands;
    n_images += e.command.rfind("READ image", 0) == 0 ? 1 : 0;
    text += e.text;
  });
  EXPECT_EQ(n_commands, 607);
  EXPECT_GT(n_images, 40);
  EXPECT_NE(text.find("received 131072 bytes"), std::string::npos) << "lengths are kept";
  EXPECT_NE(text.find("the host shall average the readings"), std::string::npos);
  EXPECT_NE(text.find("window infrared: 285 dpi"), std::string::npos);
}

TEST_F(Sessions, LinesThatAreNoSessionAreRefusedByTheirNumber) {
  const std::filesystem::path lines = dir_ / "bad.jsonl";
  const auto refusal = [&](const std::string& second) -> std::string {
    std::ofstream(lines) << "{\"cdb\": \"000000000000\", \"expected_phase\": 1}\n"
                         << second << "\n";
    const std::filesystem::path out = dir_ / "out.pcapng";
    std::filesystem::remove(out);
    try {
      rewrite_session(lines, out, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const char* const bad : {"no json", "{}", "{\"cdb\": \"00\", \"expected_phase\": 1}",
                                "{\"cdb\": \"zz0000000000\", \"expected_phase\": 1}",
                                "{\"cdb\": \"000000000000\", \"expected_phase\": \"x\"}"}) {
    EXPECT_NE(refusal(bad).find("Line 2"), std::string::npos) << bad;
  }
}

TEST_F(Sessions, AReplayThatDiffersNamesByteCommandAndSource) {
  (void)record(file_);
  const OpenedScanner opened = open_scanner("replay:" + file_.string(), {});
  ScanRequest request = small_request();
  request.resolution_dpi = 1000;  // the middle, where it focuses, is elsewhere
  try {
    (void)scan_of(*opened.scanner, request);
    FAIL();
  } catch (const DeviceError& error) {
    const std::string text = error.what();
    for (const char* const part :
         {"transfer ", "packet ", "phase \"", "Recorded: OUT ", "Now: OUT ", "from byte ",
          "SET PARAMETER", "LS-5000 interface specification"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
    }
  }
}

TEST_F(Sessions, AReplayOfAPieUnitThatDiffersNamesTheCommand) {
  const auto clock = std::make_shared<VirtualClock>();
  ScanRequest request;
  request.resolution_dpi = 300;
  request.area = {3.0, 4.0, 4.0, 3.0};
  request.exposure.mode = ExposureRequest::Mode::kFixed;
  {
    auto usb = std::make_unique<RecordingTransport>(
        sim::open_simulated_unit("sim:crystalscan3600?noise=0&film=none"), *clock, file_,
        SessionHeader{"sim:crystalscan3600", "2026-11-24T00:00:00Z", ""});
    (void)scan_of(*open_family(std::move(usb), clock, {"sim:test", "2026-11-24T00:00:00Z"}),
                  request);
  }
  const auto difference = [&] {
    try {
      (void)scan_of(*open_scanner("replay:" + file_.string(), {}).scanner, request);
    } catch (const DeviceError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  request.area.left_mm = 5.0;  // another byte of a command's data
  for (const char* const part : {"phase \"scan\"", "It belongs to the command WRITE, 14 bytes [0A",
                                 "See: SANE's pieusb backend"}) {
    EXPECT_NE(difference().find(part), std::string::npos) << part << " in " << difference();
  }
  request.area.left_mm = 3.0;
  request.exposure.mode = ExposureRequest::Mode::kMeter;  // other commands in other places
  request.depth_bits = 8;
  EXPECT_NE(difference().find("command"), std::string::npos) << difference();
}

TEST_F(Sessions, AReplayTakesFaultsByPositionAndAPace) {
  const Outcome live = record(file_);
  OpenOptions options;
  // The driver repeats the command, and the recording plays it again.
  for (const char* const kind : {"stall@", "timeout@", "short@"}) {
    for (int n = 0; n < 100; n += 3) {
      options.replay_fault = kind + std::to_string(n);
      SCOPED_TRACE(options.replay_fault);
      EXPECT_TRUE(
          scan_of(*open_scanner("replay:" + file_.string(), options).scanner, small_request())
              .samples == live.samples);
    }
  }
  options.replay_fault = "disconnect@40";
  EXPECT_THROW((void)open_scanner("replay:" + file_.string(), options), DeviceError);
  options.replay_fault = "nonsense";
  EXPECT_THROW((void)open_scanner("replay:" + file_.string(), options), InputError);
  options.replay_fault.clear();
  options.replay_speed = 1e9;
  EXPECT_TRUE(scan_of(*open_scanner("replay:" + file_.string(), options).scanner, small_request())
                  .complete);
  options.replay_speed = -1;
  EXPECT_THROW((void)open_scanner("replay:" + file_.string(), options), InputError);
}

}  // namespace
}  // namespace reseau
