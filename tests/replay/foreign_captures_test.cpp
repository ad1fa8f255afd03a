// Captures as other programs write them: usbmon through tcpdump, dumpcap and Wireshark, USBPcap. A
// scan of a simulated unit is put on a busy bus and into each format, byte by byte from the
// formats' descriptions and with no code of the reader; it has to be imported, found whole, and
// played.
#include <cerrno>
#include <fstream>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/families.h"
#include "drivers/registry.h"
#include "drivers/sessions.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/recording_transport.h"
#include "tests/replay/simulated_scan.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

constexpr int kUsbmon = 189, kUsbmonMmapped = 220, kUsbPcap = 249, kEthernet = 1;
constexpr std::uint16_t kBus = 3, kScanner = 7, kSerialAdapter = 4, kDisk = 5, kCamera = 8,
                        kMouse = 9;
constexpr std::size_t kMostUrbBytes = 16384;  // libusb cuts longer transfers up

struct Format {
  const char* name;
  int link_type;
  bool pcapng = false, big_endian = false, nanoseconds = false;
  bool old_stages = false;  // USBPcap before 1.3
  std::size_t snap_bytes = 1 << 20;
  bool alone = false;  // no other devices
};

void PrintTo(const Format& format, std::ostream* out) { *out << format.name; }

// One event of the bus.
struct Event {
  std::uint64_t urb = 0;
  char kind = 'S';
  int type = 3;  // 0 isochronous, 1 interrupt, 2 control, 3 bulk
  std::uint16_t device = kScanner;
  std::uint8_t endpoint = 0;
  std::int64_t time_us = 0;
  std::int32_t status = 0;
  std::uint32_t length = 0;
  std::optional<std::array<std::byte, 8>> setup{};
  Bytes data{};
};

class CaptureWriter {
 public:
  CaptureWriter(const std::filesystem::path& path, const Format& format)
      : file_(path, std::ios::binary), format_(format) {
    format_.pcapng ? begin_pcapng() : begin_pcap();
  }

  void write(const Event& event) {
    if (format_.link_type != kUsbPcap) {
      const Bytes packet = usbmon(event);
      record(packet, event.time_us, 1);
      // The interface of all buses shows it a second time.
      if (format_.pcapng && !format_.alone) record(packet, event.time_us, 2);
      return;
    }
    for (const Bytes& packet : usbpcap(event)) record(packet, event.time_us, 1);
  }

 private:
  void put(Bytes& to, std::uint64_t value, int n) const {
    for (int i = 0; i < n; ++i) {
      const int shift = 8 * (format_.big_endian ? n - 1 - i : i);
      to.push_back(std::byte(value >> shift & 0xFF));
    }
  }
  static void put_le(Bytes& to, std::uint64_t value, int n) {
    for (int i = 0; i < n; ++i) to.push_back(std::byte(value >> (8 * i) & 0xFF));
  }
  static void put_all(Bytes& to, ByteView data) { to.insert(to.end(), data.begin(), data.end()); }
  void flush(const Bytes& bytes) {
    file_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  }

  void begin_pcap() {
    Bytes b;
    put(b, format_.nanoseconds ? 0xA1B23C4D : 0xA1B2C3D4, 4);
    put(b, 2, 2);
    put(b, 4, 2);
    put(b, 0, 8);
    put(b, format_.snap_bytes, 4);
    put(b, static_cast<std::uint64_t>(format_.link_type), 4);
    flush(b);
  }

  void block(std::uint32_t type, Bytes body) {
    while (body.size() % 4 != 0) body.push_back(std::byte{0});
    Bytes b;
    put(b, type, 4);
    put(b, body.size() + 12, 4);
    put_all(b, body);
    put(b, body.size() + 12, 4);
    flush(b);
  }
  void option(Bytes& to, int code, const std::string& text) const {
    put(to, static_cast<std::uint64_t>(code), 2);
    put(to, text.size(), 2);
    for (const char c : text) to.push_back(std::byte(c));
    while (to.size() % 4 != 0) to.push_back(std::byte{0});
  }
  void interface(int link_type, const std::string& name) {
    Bytes b;
    put(b, static_cast<std::uint64_t>(link_type), 2);
    put(b, 0, 2);
    put(b, format_.snap_bytes, 4);
    option(b, 2, name);
    if (format_.nanoseconds) option(b, 9, "\x09");
    option(b, 12, "Linux 6.1.0-28-amd64");
    put(b, 0, 4);
    block(1, b);
  }
  void begin_pcapng() {
    Bytes b;
    put(b, 0x1A2B3C4D, 4);
    put(b, 1, 2);
    put(b, 0, 2);
    put(b, ~std::uint64_t{0}, 8);
    option(b, 2, "Intel(R) Core(TM) i5-8250U CPU @ 1.60GHz (with SSE4.2)");
    option(b, 4, "Dumpcap (Wireshark) 4.0.17");
    put(b, 0, 4);
    block(0x0A0D0D0A, b);
    interface(kEthernet, "eth0");
    interface(format_.link_type, "usbmon3");
    interface(format_.link_type, "usbmon0");
    Bytes names;  // a name resolution block with nothing in it
    put(names, 0, 4);
    block(4, names);
    record(Bytes(60, std::byte{0xFF}), 1, 0);
  }

  void record(const Bytes& packet, std::int64_t time_us, std::uint32_t interface) {
    const std::size_t kept = std::min(packet.size(), format_.snap_bytes);
    const auto us = static_cast<std::uint64_t>(time_us);
    const std::uint64_t per_us = format_.nanoseconds ? 1000 : 1;
    Bytes b;
    if (!format_.pcapng) {
      put(b, us / 1'000'000, 4);
      put(b, us % 1'000'000 * per_us, 4);
      put(b, kept, 4);
      put(b, packet.size(), 4);
      put_all(b, ByteView(packet).first(kept));
      flush(b);
      return;
    }
    put(b, interface, 4);
    put(b, us * per_us >> 32, 4);
    put(b, us * per_us & 0xFFFFFFFF, 4);
    put(b, kept, 4);
    put(b, packet.size(), 4);
    put_all(b, ByteView(packet).first(kept));
    block(6, b);
  }

  // Linux: Documentation/usb/usbmon.rst.
  Bytes usbmon(const Event& e) const {
    const bool in = (e.endpoint & 0x80) != 0;
    Bytes b;
    put(b, e.urb, 8);
    b.push_back(std::byte(e.kind));
    put(b, static_cast<std::uint64_t>(e.type), 1);
    put(b, e.endpoint, 1);
    put(b, e.device, 1);
    put(b, kBus, 2);
    b.push_back(e.setup ? std::byte{0} : std::byte{'-'});
    b.push_back(!e.data.empty() ? std::byte{0} : std::byte(in ? '<' : '>'));
    put(b, static_cast<std::uint64_t>(e.time_us / 1'000'000), 8);
    put(b, static_cast<std::uint64_t>(e.time_us % 1'000'000), 4);
    put(b, static_cast<std::uint32_t>(e.kind == 'S' ? -EINPROGRESS : e.status), 4);
    put(b, e.length, 4);
    // Descriptors of isochronous packets stand before the data and are counted with it.
    Bytes descriptors;
    if (e.type == 0 && format_.link_type == kUsbmonMmapped) {
      for (std::uint64_t i = 0; i < 2; ++i) {
        put(descriptors, 0, 4);
        put(descriptors, 192 * i, 4);
        put(descriptors, e.data.size() / 2, 4);
        put(descriptors, 0, 4);
      }
    }
    put(b, e.data.size() + descriptors.size(), 4);
    for (std::size_t i = 0; i < 8; ++i) {
      b.push_back(e.setup ? (*e.setup)[i] : std::byte(e.type == 0 ? i : 0));
    }
    if (format_.link_type == kUsbmonMmapped) {
      put(b, e.type == 1 ? 8 : 0, 4);  // interval
      put(b, 0, 4);                    // start frame
      put(b, 0x200, 4);                // transfer flags
      put(b, e.type == 0 ? 2 : 0, 4);  // descriptors
      put_all(b, descriptors);
    }
    put_all(b, e.data);
    return b;
  }

  // USBPcap: USBPCAP_BUFFER_PACKET_HEADER, always little-endian.
  static Bytes usbpcap_packet(const Event& e, bool from_device, int stage, ByteView data) {
    const bool control = e.type == 2;
    Bytes b;
    put_le(b, control ? 28 : 27, 2);
    put_le(b, e.urb, 8);
    put_le(b, e.status == 0 ? 0 : 0xC0010000, 4);
    put_le(b, control ? 0x08 : 0x09, 2);
    put_le(b, from_device ? 1 : 0, 1);
    put_le(b, kBus, 2);
    put_le(b, e.device, 2);
    put_le(b, e.endpoint, 1);
    put_le(b, static_cast<std::uint64_t>(e.type), 1);
    put_le(b, data.size(), 4);
    if (control) put_le(b, static_cast<std::uint64_t>(stage), 1);
    put_all(b, data);
    return b;
  }
  std::vector<Bytes> usbpcap(const Event& e) const {
    const bool from_device = e.kind != 'S', in = (e.endpoint & 0x80) != 0;
    if (e.type != 2) return {usbpcap_packet(e, from_device, 0, e.data)};
    constexpr int kSetup = 0, kData = 1, kStatus = 2, kComplete = 3;
    if (!from_device) {
      Bytes setup(e.setup->begin(), e.setup->end());
      if (!format_.old_stages) {
        put_all(setup, e.data);
        return {usbpcap_packet(e, false, kSetup, setup)};
      }
      std::vector<Bytes> packets{usbpcap_packet(e, false, kSetup, setup)};
      if (!in && !e.data.empty()) packets.push_back(usbpcap_packet(e, false, kData, e.data));
      return packets;
    }
    if (!format_.old_stages) return {usbpcap_packet(e, true, kComplete, e.data)};
    std::vector<Bytes> packets;
    if (in && !e.data.empty()) packets.push_back(usbpcap_packet(e, true, kData, e.data));
    packets.push_back(usbpcap_packet(e, !in, kStatus, {}));
    return packets;
  }

  std::ofstream file_;
  Format format_;
};

// The packets of one of our recordings, as they would have gone over a bus that others use.
class BusyBus {
 public:
  BusyBus(CaptureWriter& writer, const Format& format) : writer_(writer), format_(format) {}

  void play(const std::filesystem::path& recording) {
    if (!format_.alone) begin();
    CaptureReader reader(recording);
    for (int n = 0; auto packet = reader.next(); ++n) {
      now_us_ = packet->time_us;
      if (!format_.alone && n % 7 == 3) others(n);
      scanner(*packet);
    }
  }

 private:
  // Kernels use the same few addresses again.
  static std::uint64_t address(std::uint64_t id) { return 0xFFFF888104A0C000 + 0xC0 * (id % 3); }

  void event(Event e) {
    e.time_us = now_us_;
    writer_.write(e);
  }
  void begin() {
    // Ends never, as long as nobody moves the mouse; so does one without an answer.
    event({.urb = 0x101, .type = 1, .device = kMouse, .endpoint = 0x81, .length = 8});
    event({.urb = 0x102, .type = 3, .device = kScanner + 20, .endpoint = 0x82, .length = 512});
    // Six bytes to a device that is no scanner.
    const Bytes six(6, std::byte{0x41});
    event({.urb = 0x103, .device = kSerialAdapter, .endpoint = 0x02, .length = 6, .data = six});
    event({.urb = 0x103, .kind = 'C', .device = kSerialAdapter, .endpoint = 0x02, .length = 6});
    // The end of what began before the capture did.
    event({.urb = 0x104, .kind = 'C', .endpoint = 0x82, .length = 8, .data = Bytes(8)});
  }
  void others(int n) {
    event({.urb = 0x201, .type = 0, .device = kCamera, .endpoint = 0x83, .length = 384});
    event({.urb = 0x201,
           .kind = 'C',
           .type = 0,
           .device = kCamera,
           .endpoint = 0x83,
           .length = 384,
           .data = Bytes(384, std::byte{0x12})});
    Bytes wrapper(31, std::byte{0x28});
    event({.urb = 0x301, .device = kDisk, .endpoint = 0x01, .length = 31, .data = wrapper});
    if (n % 2 == 0)
      event({.urb = 0x301, .kind = 'E', .device = kDisk, .endpoint = 1, .status = -2});
    event({.urb = 0x301, .kind = 'C', .device = kDisk, .endpoint = 0x01, .length = 31});
    if (n % 3 != 0) return;
    // GET_STATUS to the scanner itself, by a tool that looks at the bus.
    Event status{.urb = 0x401, .type = 2, .endpoint = 0x80, .length = 2};
    status.setup.emplace();
    (*status.setup)[0] = std::byte{0x80};
    (*status.setup)[6] = std::byte{2};
    event(status);
    status.kind = 'C';
    status.setup.reset();
    status.data = Bytes(2);
    event(status);
  }

  void scanner(const UsbPacket& packet) {
    Event e{.urb = address(packet.id),
            .kind = packet.submission ? 'S' : 'C',
            .type = static_cast<int>(packet.type),
            .endpoint = packet.endpoint,
            .status = packet.status,
            .length = packet.length.value_or(0),
            .setup = packet.setup,
            .data = packet.data};
    if (packet.submission) asked_ = e.length;
    const bool long_in = packet.type == UsbTransferType::kBulk && (e.endpoint & 0x80) != 0 &&
                         asked_ > kMostUrbBytes && format_.link_type != kUsbPcap;
    if (!long_in) return event(e);
    // Several in flight; those behind a short one are taken back.
    bool ended = false;
    for (std::size_t at = 0, i = 0; at < asked_; at += kMostUrbBytes, ++i) {
      Event part = e;
      part.urb += 0x10 * i;
      part.length = static_cast<std::uint32_t>(std::min(kMostUrbBytes, asked_ - at));
      if (part.kind == 'C') {
        const std::size_t left = packet.data.size() - std::min(at, packet.data.size());
        const auto n = static_cast<std::ptrdiff_t>(std::min<std::size_t>(left, part.length));
        const auto from =
            packet.data.begin() + static_cast<std::ptrdiff_t>(packet.data.size() - left);
        part.data.assign(from, from + n);
        if (ended) part.status = i % 2 == 0 ? -ENOENT : -ECONNRESET;
        ended = ended || left < part.length;
        part.length = static_cast<std::uint32_t>(n);
      }
      event(part);
    }
  }

  CaptureWriter& writer_;
  Format format_;
  std::int64_t now_us_ = 1;
  std::size_t asked_ = 0;
};

constexpr Format kFormats[] = {{"UsbmonPcap", kUsbmon},
                               {"UsbmonPcapBig", kUsbmon, false, true},
                               {"UsbmonPcapNanoseconds", kUsbmon, false, false, true},
                               {"UsbmonPcapng", kUsbmon, true},
                               {"MmappedPcap", kUsbmonMmapped},
                               {"MmappedPcapBig", kUsbmonMmapped, false, true},
                               {"MmappedPcapNanoseconds", kUsbmonMmapped, false, false, true},
                               {"MmappedPcapNanosecondsBig", kUsbmonMmapped, false, true, true},
                               {"MmappedPcapng", kUsbmonMmapped, true},
                               {"MmappedPcapngBig", kUsbmonMmapped, true, true},
                               {"MmappedPcapngNanoseconds", kUsbmonMmapped, true, false, true},
                               {"UsbPcapPcapStages", kUsbPcap, false, false, false, true},
                               {"UsbPcapPcap", kUsbPcap},
                               {"UsbPcapPcapngStages", kUsbPcap, true, false, true, true},
                               {"UsbPcapPcapng", kUsbPcap, true, false, true}};

ScanRequest request_for(const std::string& unit) {
  ScanRequest request = small_request();
  if (unit == "crystalscan3600") {
    request.resolution_dpi = 300;
    request.area = {3.0, 4.0, 4.0, 3.0};
  } else {
    request.resolution_dpi = 1000;  // READs longer than one transfer of the kernel's
  }
  return request;
}

// A scan of each unit, recorded once.
struct Recorded {
  test::TempDir dir;
  std::filesystem::path file = dir / "scan.pcapng";
  Outcome live;

  explicit Recorded(const std::string& unit) {
    const auto clock = std::make_shared<VirtualClock>();
    auto usb = std::make_unique<RecordingTransport>(
        sim::open_simulated_unit("sim:" + unit + "?noise=0&film=none"), *clock, file,
        SessionHeader{"sim:" + unit, "2026-11-24T00:00:00Z", ""});
    live = scan_of(*open_family(std::move(usb), clock, {"sim:test", "2026-11-24T00:00:00Z"}),
                   request_for(unit));
  }
};

const Recorded& recorded(const std::string& unit) {
  static const Recorded coolscan("ls5000"), pie("crystalscan3600");
  return unit == "ls5000" ? coolscan : pie;
}

void capture(const std::string& unit, const Format& format, const std::filesystem::path& to) {
  CaptureWriter writer(to, format);
  BusyBus(writer, format).play(recorded(unit).file);
}

std::vector<std::string> commands_in(const std::filesystem::path& file) {
  std::vector<std::string> commands;
  show_session(file, [&](const ShownExchange& e) {
    // What was asked of the unit as of any USB device is not a command.
    if (!e.command.starts_with("control ")) commands.push_back(e.command_hex);
  });
  return commands;
}

using ForeignCase = std::tuple<Format, const char*>;
class ForeignCapture : public testing::TestWithParam<ForeignCase> {};

TEST_P(ForeignCapture, IsImportedFoundWholeAndPlays) {
  const auto& [format, unit] = GetParam();
  const test::TempDir dir;
  const std::filesystem::path foreign = dir / "foreign", imported = dir / "imported.pcapng";
  capture(unit, format, foreign);
  const Recorded& own = recorded(unit);
  ASSERT_TRUE(own.live.complete);
  EXPECT_EQ(commands_in(foreign), commands_in(own.file));

  const RewriteResult result = rewrite_session(foreign, imported, {});
  EXPECT_GT(result.n_packets_left_out, result.n_packets / 10) << "others stay outside";
  const SessionCheck ours = check_session(own.file);
  for (const std::filesystem::path& file : {foreign, imported}) {
    SCOPED_TRACE(file);
    const SessionCheck check = check_session(file);
    EXPECT_TRUE(check.problems.empty()) << check.problems.front();
    EXPECT_EQ(check.session.device, ours.session.device);
    EXPECT_EQ(check.n_failed_transfers, 0);
    EXPECT_EQ(check.n_not_ready, ours.n_not_ready);
    EXPECT_EQ(check.n_refused, ours.n_refused);
    const OpenedScanner opened = open_scanner("replay:" + file.string(), {});
    EXPECT_TRUE(scan_of(*opened.scanner, request_for(unit)).samples == own.live.samples);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ForeignCapture,
                         testing::Combine(testing::ValuesIn(kFormats),
                                          testing::Values("ls5000", "crystalscan3600")),
                         [](const auto& one) {
                           const std::string unit = std::get<1>(one.param);
                           return std::string(std::get<0>(one.param).name) +
                                  (unit == "ls5000" ? "Coolscan" : "Pie");
                         });

TEST(ForeignCaptures, OneThatWasCutToASizeSaysSo) {
  const test::TempDir dir;
  for (Format format : kFormats) {
    SCOPED_TRACE(format.name);
    format.snap_bytes = 96;
    const std::filesystem::path file = dir / format.name;
    capture("ls5000", format, file);
    const SessionCheck check = check_session(file);
    ASSERT_FALSE(check.problems.empty());
    EXPECT_NE(check.problems[0].find("limit of packet size"), std::string::npos)
        << check.problems[0];
    try {
      const OpenedScanner opened = open_scanner("replay:" + file.string(), {});
      (void)scan_of(*opened.scanner, request_for("ls5000"));
      FAIL();
    } catch (const DeviceError& error) {
      EXPECT_NE(std::string(error.what()).find("limit of packet size"), std::string::npos)
          << error.what();
    }
  }
}

TEST(ForeignCaptures, WhatEndsInTheMiddleIsReadUpToThere) {
  const test::TempDir dir;
  for (const Format& format : kFormats) {
    SCOPED_TRACE(format.name);
    const std::filesystem::path file = dir / format.name;
    capture("ls5000", format, file);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) * 2 / 3 + 1);
    EXPECT_GT(commands_in(file).size(), 30U);
    EXPECT_FALSE(check_session(file).problems.empty());
    // Whatever the driver was told up to there, the replay ends with a sentence.
    EXPECT_THROW(
        (void)scan_of(*open_scanner("replay:" + file.string(), {}).scanner, request_for("ls5000")),
        DeviceError);
  }
}

}  // namespace
}  // namespace reseau
