// A recording of a simulated scan, played back, is the scan; a recording that differs is reported.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/base/error.h"
#include "drivers/registry.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/pcapng_writer.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {
namespace {

namespace fs = std::filesystem;

class ReplayRoundTrip : public testing::Test {
 protected:
  ReplayRoundTrip() { fs::remove(path_); }
  ~ReplayRoundTrip() override { fs::remove(path_); }

  Outcome record(const std::string& name) {
    const OpenedScanner opened = open_scanner(name, {path_, "{\"asked\": 1}"});
    return scan_of(*opened.scanner, small_request());
  }
  std::string replay_name() const { return "replay:" + path_.string(); }

  // Writes the recording again with one packet changed.
  template <typename Change>
  void tamper(std::uint64_t number, Change change) {
    std::vector<UsbPacket> packets;
    std::string comment;
    {
      CaptureReader reader(path_);
      while (auto packet = reader.next()) packets.push_back(*std::move(packet));
      comment = reader.comment();
    }
    fs::remove(path_);
    PcapngWriter writer(path_, comment);
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if (i + 1 == number) change(packets[i]);
      writer.write(packets[i]);
    }
  }

  fs::path path_ =
      fs::temp_directory_path() / ("reseau_replay_" + std::to_string(getpid()) + ".pcapng");
};

TEST_F(ReplayRoundTrip, GivesTheSameSamplesAndContext) {
  for (const std::string name : {"sim:ls5000", "sim:ls50?cold=1", "sim:ls5000?stale=8"}) {
    fs::remove(path_);
    const Outcome live = record(name);
    ASSERT_TRUE(live.complete);
    const OpenedScanner opened = open_scanner(replay_name(), {});
    EXPECT_EQ(opened.recorded_comment, "{\"asked\": 1}");
    EXPECT_EQ(opened.recorded_at_utc, live.context.started_at_utc);
    const Outcome replayed = scan_of(*opened.scanner, small_request());
    EXPECT_TRUE(replayed.complete);
    EXPECT_EQ(replayed.samples, live.samples);
    EXPECT_EQ(replayed.format, live.format);
    EXPECT_EQ(replayed.context.device_name, name);
    EXPECT_EQ(replayed.context.started_at_utc, live.context.started_at_utc);
    EXPECT_EQ(replayed.context.exposure_us, live.context.exposure_us);
    EXPECT_EQ(replayed.context.focus_position, live.context.focus_position);
  }
}

TEST_F(ReplayRoundTrip, AFailureIsReplayedAsTheSameFailure) {
  const auto error_of = [](const std::string& name, const OpenOptions& options) -> std::string {
    try {
      const OpenedScanner opened = open_scanner(name, options);
      (void)scan_of(*opened.scanner, small_request());
    } catch (const DeviceError& error) {
      return std::to_string(static_cast<int>(error.kind())) + error.what();
    }
    return "no error";
  };
  for (const char* const fault : {"stall", "timeout", "disconnect"}) {
    fs::remove(path_);
    // Late enough to hit an image READ, which is not repeated.
    const std::string live =
        error_of("sim:ls5000?fault=" + std::string(fault) + "@330", {path_, ""});
    EXPECT_EQ(error_of(replay_name(), {}), live) << fault;
  }
}

TEST_F(ReplayRoundTrip, AnotherRequestIsReportedWithBothSides) {
  (void)record("sim:ls5000");
  const OpenedScanner opened = open_scanner(replay_name(), {});
  ScanRequest request = small_request();
  request.resolution_dpi = 1000;
  try {
    (void)scan_of(*opened.scanner, request);
    FAIL();
  } catch (const DeviceError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("Recorded: OUT "), std::string::npos) << text;
    EXPECT_NE(text.find("Now: OUT "), std::string::npos) << text;
    EXPECT_NE(text.find("phase \""), std::string::npos) << text;
    EXPECT_NE(text.find("packet "), std::string::npos) << text;
  }
}

TEST_F(ReplayRoundTrip, ACommandThatWasTamperedWithIsReported) {
  (void)record("sim:ls5000");
  // Packets 1 to 4 or 6 are descriptors; find the first TEST UNIT READY.
  std::uint64_t number = 0;
  {
    TransferReader reader(path_);
    while (auto transfer = reader.next()) {
      if (transfer->endpoint == 0x01 && transfer->data == Bytes(6)) {
        number = transfer->packet_number;
        break;
      }
    }
  }
  ASSERT_GT(number, 0U);
  tamper(number, [](UsbPacket& packet) { packet.data[0] = std::byte{0x17}; });
  try {
    (void)open_scanner(replay_name(), {});
    FAIL();
  } catch (const DeviceError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("packet " + std::to_string(number)), std::string::npos) << text;
    EXPECT_NE(text.find("RELEASE UNIT"), std::string::npos) << text;
    EXPECT_NE(text.find("TEST UNIT READY"), std::string::npos) << text;
  }
}

TEST_F(ReplayRoundTrip, ARecordingThatWasCutOffSaysSo) {
  (void)record("sim:ls5000");
  fs::resize_file(path_, fs::file_size(path_) / 2);
  const OpenedScanner opened = open_scanner(replay_name(), {});
  try {
    (void)scan_of(*opened.scanner, small_request());
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("recording ends here"), std::string::npos);
  }
}

TEST(Registry, ExplainsNamesThatCannotBeUnderstood) {
  for (const char* const name :
       {"", "ls5000", "usb:", "usb:04b0", "usb:zzzz:4002", "usb:04b0:4002x", "usb:1234:5678",
        "sim:nothing", "sim:ls5000?pace=never", "sim:ls5000?fault=boom@1", "sim:ls5000?wrong=1"}) {
    EXPECT_THROW((void)open_scanner(name, {}), InputError) << name;
  }
}

TEST(Registry, TakesOptionsOfTheLinkFromAnyPlace) {
  for (const char* const name :
       {"sim:ls5000?pace=fast", "sim:ls5000?noise=0&pace=fast", "sim:ls5000?pace=fast&noise=0",
        "sim:ls5000?noise=0&fault=stall@1000000&pace=fast"}) {
    EXPECT_NO_THROW((void)open_scanner(name, {})) << name;
  }
}

TEST(Registry, ListsTheSimulatedUnits) {
  int n_simulated = 0;
  for (const DeviceEntry& entry : list_devices()) {
    if (!entry.simulated) continue;
    ++n_simulated;
    EXPECT_NO_THROW((void)open_scanner(entry.name, {})) << entry.name;
  }
  EXPECT_GE(n_simulated, 2);
}

TEST(Registry, DiagnosesWithoutHarm) {
  for (const Finding& finding : diagnose_devices()) {
    EXPECT_FALSE(finding.what.empty());
    if (finding.level == Finding::Level::kProblem) {
      EXPECT_FALSE(finding.remedy.empty());
    }
  }
}

}  // namespace
}  // namespace reseau
