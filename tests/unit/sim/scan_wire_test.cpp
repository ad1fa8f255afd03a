// SCAN, the cooperation records and image data, down to every byte.
#include <vector>

#include <gtest/gtest.h>

#include "drivers/sim/simulate.h"
#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

constexpr std::string_view kReadRecord27 = "28008700000000002180";
constexpr std::string_view kReadRecord18 = "28008700000000001880";

// A unit in focus, measuring in optical pixels.
SimHost ready_host(const std::string& name) {
  SimHost host(name);
  host.send("151000001400", "000000080000000000000001030600000fa00000");
  host.send("e000c100000000000900", "00000000d100000000");
  EXPECT_EQ(host.status("c10000000000"), SimHost::kGoodStatus);
  host.wait_ready();
  return host;
}

std::uint32_t white_balance(SimHost& host, int colour) {
  std::string cdb = "28008c00010300000a80";
  cdb[9] = static_cast<char>('0' + colour);
  const Exchange e = host.run(cdb, 10);
  EXPECT_EQ(to_hex(e.data).substr(0, 12), "8c2000000004");
  return get32(e.data, 6);
}

// Sets the windows of these colours alike, each at its white-balance exposure.
void set_windows(SimHost& host, const std::vector<int>& ids, WindowList window) {
  for (const int id : ids) {
    window.id = id;
    window.exposure = white_balance(host, id);
    ASSERT_EQ(host.run(kSetWindow, 0, window.list()).status, SimHost::kGoodStatus);
  }
}

// Repeats SCAN until the unit has nothing more to ask; returns the records without header.
std::vector<std::string> start(SimHost& host, const std::string& ids) {
  std::vector<std::string> records;
  const std::string cdb = "1b0000000" + std::to_string(ids.size() / 2) + "00";
  for (int round = 0; round < 16; ++round) {
    const Exchange e = host.send(cdb, ids);
    if (e.status == SimHost::kGoodStatus) break;
    if (e.status.substr(0, 6) != "020980") {
      ADD_FAILURE() << e.status;
      break;
    }
    const bool long_record = e.status.substr(6, 2) == "06";
    const Exchange r = host.run(long_record ? kReadRecord27 : kReadRecord18, long_record ? 33 : 24);
    EXPECT_EQ(r.status, SimHost::kGoodStatus);
    records.push_back(to_hex(r.data).substr(12));
    EXPECT_EQ(records.back().substr(2, 8), e.status.substr(2, 8)) << "the record repeats the sense";
  }
  host.wait_ready();
  return records;
}

Exchange read_image(SimHost& host, std::size_t bytes) {
  Bytes cdb = from_hex("28000000000100000080");
  cdb[6] = static_cast<std::uint8_t>(bytes >> 16);
  cdb[7] = static_cast<std::uint8_t>(bytes >> 8 & 0xff);
  cdb[8] = static_cast<std::uint8_t>(bytes & 0xff);
  return host.run(to_hex(cdb), bytes);
}

TEST(Scan, PaddedLineLengthsOfTheSpecification) {
  struct Case {
    const char *model, *ids;
    int dpi, depth;
    std::uint32_t height;
    std::size_t data_bytes, line_bytes;
  };
  const Case cases[] = {
      {"ls5000", "09010203", 285, 16, 5959, 2248, 2560},
      {"ls5000", "09010203", 4000, 16, 40, 31568, 31744},
      {"ls5000", "010203", 4000, 16, 40, 23676, 24064},
      {"ls50", "01020309", 4000, 14, 40, 31568, 31744},
      {"ls50", "010203", 4000, 14, 40, 23676, 24064},
      {"ls50", "010203", 4000, 8, 40, 11838, 12288},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::string(c.model) + " " + c.ids + " " + std::to_string(c.dpi));
    SimHost host = ready_host(std::string("sim:") + c.model + "?cells=1");
    std::vector<int> ids;
    for (const std::uint8_t id : from_hex(c.ids)) ids.push_back(id);
    set_windows(host, ids, {.dpi = c.dpi, .depth = c.depth, .height = c.height});
    const std::vector<std::string> records = start(host, c.ids);
    ASSERT_EQ(records.size(), 1U);
    EXPECT_EQ(records[0].substr(10, 2), "08");
    EXPECT_EQ(std::stoul(records[0].substr(26, 4), nullptr, 16), c.line_bytes - c.data_bytes);
    const std::size_t lines = c.height / (4000 / static_cast<std::size_t>(c.dpi));
    std::size_t got = 0;
    while (got < lines * c.line_bytes) {
      const std::size_t step = std::min(lines * c.line_bytes - got, 16 * c.line_bytes);
      const Exchange e = read_image(host, step);
      ASSERT_EQ(e.status, SimHost::kGoodStatus);
      ASSERT_EQ(e.data.size(), step);
      EXPECT_EQ(to_hex(ByteView(e.data).subspan(c.data_bytes, 2)), "aa55") << "garbage in the pad";
      got += step;
    }
    EXPECT_EQ(read_image(host, c.line_bytes).status, "02052c0000000000");
  }
}

// The planes come red, green, blue, infrared whatever the list says, mirrored along the line, big
// endian; what they hold is the film.
TEST(Scan, LineByLineDataIsTheFilmMirrored) {
  const std::string film = "ls5000?width_px=200&height_px=100&noise=0&angle=31&seed=4";
  SimHost host = ready_host("sim:" + film);
  const std::vector<int> ids{9, 3, 1, 2};
  set_windows(host, ids, {.x = 20, .y = 10, .width = 101, .height = 7});
  start(host, "09030102");
  const std::size_t line_bytes = 1024;
  const Exchange e = read_image(host, 7 * line_bytes);
  ASSERT_EQ(e.data.size(), 7 * line_bytes);
  const SimulatedScan scan = simulate_window(
      parse_sim_spec(film), {.x_px = 20, .y_px = 10, .width_px = 101, .n_lines = 7});
  for (std::size_t y = 0; y < 7; ++y) {
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::size_t x = 0; x < 101; ++x) {
        const std::uint32_t wire = get16(e.data, y * line_bytes + (c * 101 + 100 - x) * 2);
        ASSERT_NEAR(wire, scan.samples[(y * 4 + c) * 101 + x], 1) << y << " " << c << " " << x;
      }
    }
  }
}

TEST(Scan, OneWindowAlone) {
  SimHost host = ready_host("sim:ls5000?width_px=64&height_px=64&cells=1");
  set_windows(host, {2}, {.composition = 2, .width = 30, .height = 4});
  start(host, "02");
  EXPECT_EQ(read_image(host, 4 * 512).data.size(), 2048U);
}

TEST(Scan, ExposureScalesTheImageAndClips) {
  for (const auto& [factor, expected] : {std::pair{0.25, 0.225}, {1.0, 0.9}, {2.0, 1.0}}) {
    SimHost host =
        ready_host("sim:ls5000?film=none&rebate_px=30&width_px=100&height_px=100&noise=0");
    const auto exposure = static_cast<std::uint32_t>(factor * white_balance(host, 9));
    WindowList window{.id = 9, .width = 8, .height = 1, .exposure = exposure};
    host.run(kSetWindow, 0, window.list());
    start(host, "09");
    const Exchange e = read_image(host, 512);
    EXPECT_NEAR(get16(e.data, 0) / 65535.0, expected, 2e-3) << factor;
  }
}

TEST(Scan, EightBitOddWidthHasAPadBytePerColour) {
  SimHost host = ready_host("sim:ls50?width_px=64&height_px=64&noise=0");
  set_windows(host, {1, 2, 3}, {.depth = 8, .width = 31, .height = 2});
  const std::vector<std::string> records = start(host, "010203");
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].substr(10, 2), "09") << "each colour's start, and the line's end";
  EXPECT_EQ(records[0].substr(14, 4), "0001");
  EXPECT_EQ(records[0].substr(26, 4), "01a0");  // 512 - 3 * 32
  const Exchange e = read_image(host, 1024);
  ASSERT_EQ(e.data.size(), 1024U);
  for (std::size_t colour = 0; colour < 3; ++colour) {
    EXPECT_EQ(e.data[colour * 32], 0xaa);
  }
  EXPECT_EQ(e.data[96], 0xaa);
}

TEST(Scan, EachJobIsAskedForOnceEvenOfAHostThatReadsNoRecord) {
  SimHost host = ready_host("sim:ls5000?width_px=64&height_px=64");
  set_windows(host, {1, 2, 3}, {.width = 32, .height = 2});
  EXPECT_EQ(host.send("1b0000000300", "010203").status, "0209800601000000");
  EXPECT_EQ(to_hex(host.run("28008700000000000680", 6).data), "87080000001b");
  EXPECT_EQ(host.status("1b0000000000"), SimHost::kGoodStatus) << "0 windows: the last list";
  host.wait_ready();
  EXPECT_EQ(read_image(host, 512).status, SimHost::kGoodStatus);
}

TEST(Scan, RectanglesOfFramesAreCheckedAndKept) {
  SimHost host = ready_host("sim:ls5000?width_px=64&height_px=64");
  const Bytes one = from_hex("0014 01 00 00000000 00000000 00001746 00000F69");
  EXPECT_EQ(host.run("2a008800000300001400", 0, one).status, SimHost::kGoodStatus);
  Bytes kept = from_hex("8800 00000014");
  kept.insert(kept.end(), one.begin(), one.end());
  EXPECT_EQ(host.run("28008800000300001a80", 26).data, kept);
  EXPECT_EQ(host.run("2a008800000300000400", 0, from_hex("00040000")).status, "0205260000000000")
      << "no frame at all";
  Bytes wrong = one;
  wrong[1] = 0x12;
  EXPECT_EQ(host.run("2a008800000300001400", 0, wrong).status, "0205260000000000");
}

TEST(Scan, Ls50LookupTableIsAppliedAndDepthsAgree) {
  SimHost host = ready_host("sim:ls50?width_px=64&height_px=64&noise=0");
  Bytes inverse;
  for (std::uint32_t v = 0; v < 16384; ++v) put16(inverse, 16383 - v);
  Exchange sent = host.run("2a000300020100800000", 0, inverse);
  EXPECT_EQ(sent.status, SimHost::kGoodStatus);
  EXPECT_EQ(host.run("28000300020100800080", 32768).data, inverse);
  const auto line = [&host](int depth, std::size_t bytes) {
    set_windows(host, {1, 2}, {.depth = depth, .width = 32, .height = 1});
    start(host, "0102");
    return read_image(host, bytes).data;
  };
  const Bytes with_table = line(14, 512), eight = line(8, 512);
  inverse.clear();
  for (std::uint32_t v = 0; v < 16384; ++v) put16(inverse, v);
  host.run("2a000300020100800000", 0, inverse);
  const Bytes plain = line(14, 512);
  for (std::size_t x = 0; x < 32; ++x) {
    EXPECT_EQ(get16(plain, 64 + 2 * x) + get16(with_table, 64 + 2 * x), 16383U);
    EXPECT_EQ(get16(plain, 2 * x), get16(with_table, 2 * x)) << "red has its own table";
    EXPECT_EQ(eight[32 + x], get16(with_table, 64 + 2 * x) >> 6);
  }
  inverse[0] = 0x40;
  EXPECT_EQ(host.run("2a000300020100800000", 0, inverse).status, "0205260000000000");
  EXPECT_EQ(host.status("2a000300020100800200"), "0205240000000000") << "length";
}

TEST(Scan, MultipleReadingsRepeatTheVisibleColoursOnly) {
  SimHost host = ready_host("sim:ls5000?width_px=200&height_px=64&border_px=0&noise=0.02");
  set_windows(host, {9, 1, 2, 3}, {.width = 100, .height = 3, .bytes_40_to_44 = "2000011202"});
  const std::vector<std::string> records = start(host, "09010203");
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0],
            "0209800201"
            "0064"
            "0009"
            "10"
            "0003"
            "03"
            "0000000000");
  // 800 + 224 with infrared, twice 600 + 424 without.
  EXPECT_EQ(records[1],
            "0609800601"
            "28"
            "00"
            "0000"
            "0000"
            "0000"
            "01a8"
            "0000"
            "00e0"
            "0000"
            "0000"
            "00000000");
  const Exchange e = read_image(host, 3 * 3 * 1024);
  ASSERT_EQ(e.data.size(), 9216U);
  int differing = 0;
  for (std::size_t x = 0; x < 100; ++x) {
    const int first = static_cast<int>(get16(e.data, 2 * x));
    const int second = static_cast<int>(get16(e.data, 1024 + 2 * x));
    EXPECT_NEAR(first, second, 12000);
    differing += first != second ? 1 : 0;
  }
  EXPECT_GT(differing, 90) << "each reading has its own noise";
  EXPECT_EQ(to_hex(ByteView(e.data).subspan(1024 + 600, 2)), "aa55");
}

class TwoLines : public testing::TestWithParam<const char*> {};

// A unit's lines differ by its own curves unless line_response says 0; the film's scan knows of
// them only where it has as many lines.
INSTANTIATE_TEST_SUITE_P(
    Sensors, TwoLines,
    testing::Values("&line_response=0", "&sensor_lines=2&line_response=1&line_gain=0.03",
                    "&sensor_lines=2&line_response=0&stagger_px=0.4&stagger_x_px=-0.2",
                    "&sensor_lines=2&line_response=0&optics=coolscan&focus_curve_um=40"));

TEST_P(TwoLines, InterleaveFilmLinesPerPixel) {
  const std::string film = std::string("ls5000?width_px=200&height_px=100&noise=0") + GetParam();
  SimHost host = ready_host("sim:" + film);
  set_windows(host, {1, 2, 3}, {.y = 4, .width = 64, .height = 5, .bytes_40_to_44 = "0000010240"});
  const std::vector<std::string> records = start(host, "010203");
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0].substr(10, 2), "88") << "line end and a surplus line at the bottom";
  EXPECT_EQ(records[0].substr(42, 4), "0001");
  EXPECT_EQ(records[1].substr(0, 18), "070980070001010100");
  const Exchange e = read_image(host, 3 * 1024);
  ASSERT_EQ(e.data.size(), 3072U);
  const SimulatedScan scan =
      simulate_window(parse_sim_spec(film), {.y_px = 4, .width_px = 64, .n_lines = 6});
  for (std::size_t y = 0; y < 6; ++y) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t x = 0; x < 64; ++x) {
        const std::size_t at = y / 2 * 1024 + (c * 128 + (63 - x) * 2 + y % 2) * 2;
        ASSERT_NEAR(get16(e.data, at), scan.samples[(y * 4 + c) * 64 + x], 1);
      }
    }
  }
}

TEST(Scan, ThumbnailOfTheStripIndexesTheFrames) {
  SimHost host = ready_host("sim:ls5000?adapter=sa21&frames=3");
  set_windows(host, {1, 2, 3}, {.dpi = 97, .height = 8 * 5959, .bytes_40_to_44 = "0081020202"});
  const std::vector<std::string> records = start(host, "010203");
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0].substr(26, 4), "01c0");
  EXPECT_EQ(records[1], "010980010602400366100091000000000000");  // 870 = 6 * 145 lines
  const std::size_t lines = 8 * 5959 / 41;
  const Exchange e = read_image(host, lines * 1024);
  EXPECT_EQ(e.data.size(), lines * 1024);
  EXPECT_EQ(host.test_unit_ready(), "02063f0300000000");
  const Bytes page = host.run("1201c1005780", 87).data;
  EXPECT_EQ(page[75], 3);
  EXPECT_EQ(get32(page, 46), 5U * 5959);
  // Bare light after the film, dark between the frames.
  const auto red = [&e](std::size_t line) { return get16(e.data, line * 1024 + 48 * 2); };
  EXPECT_GT(red(5959 * 3 / 42 + 20), 50000U);
  EXPECT_LT(red(5959 / 42), 20000U);
}

TEST(Scan, ReadBeforeScanAndRoundingUp) {
  SimHost host = ready_host("sim:ls5000?width_px=64&height_px=64&cells=1");
  EXPECT_EQ(read_image(host, 512).status, "02052c0000000000");
  set_windows(host, {1}, {.width = 30, .height = 4});
  start(host, "01");
  host.out(from_hex("28000000000100010080"));  // 256 bytes: half a line
  host.out(Bytes{0xd0});
  EXPECT_EQ(host.in(1), Bytes{0x03});
  EXPECT_EQ(host.in(1024).size(), 520U) << "a whole line, and the status behind it";
  const Exchange e = read_image(host, 4 * 512);
  EXPECT_EQ(e.data.size(), 3 * 512U) << "what there is";
  EXPECT_EQ(e.status, "022b4b0000000000");
  EXPECT_EQ(read_image(host, 512).status, "02052c0000000000");
}

TEST(Scan, AForbiddenCommandOrAbortEndsAnOpenScan) {
  for (const bool by_abort : {true, false}) {
    SimHost host = ready_host("sim:ls5000?width_px=64&height_px=64&cells=1");
    set_windows(host, {1}, {.width = 30, .height = 4});
    start(host, "01");
    EXPECT_EQ(host.run("25010000000100003a80", 58).phase, 3) << "GET WINDOW is allowed";
    EXPECT_EQ(host.run("1a1003001400", 20).phase, 3) << "MODE SENSE is allowed";
    EXPECT_EQ(read_image(host, 512).data.size(), 512U);
    if (by_abort) {
      EXPECT_EQ(host.status("c00000000000"), SimHost::kGoodStatus);
    } else {
      EXPECT_EQ(host.status("e100c100000000000900"), "02052c0000000000");
    }
    EXPECT_EQ(read_image(host, 512).status, "02052c0000000000");
    EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
  }
}

TEST(Scan, Refusals) {
  SimHost host = ready_host("sim:ls5000");
  set_windows(host, {1, 2, 3}, {});
  EXPECT_EQ(host.send("1b0000000200", "0101").status, "02052c0200000000") << "twice";
  EXPECT_EQ(host.send("1b0000000200", "0001").status, "02052c0200000000") << "default window";
  EXPECT_EQ(host.send("1b0000000100", "04").status, "0205260000000000");
  EXPECT_EQ(host.status("1b0000000500"), "0205240000000000");
  set_windows(host, {2}, {.dpi = 2000});
  EXPECT_EQ(host.send("1b0000000200", "0102").status, "02052c0200000000") << "different windows";
  set_windows(host, {1, 2}, {.composition = 2});
  EXPECT_EQ(host.send("1b0000000200", "0102").status, "0205260200000000");
  SimHost empty("sim:ls5000?film=empty");
  EXPECT_EQ(empty.send("1b0000000100", "01").status, "02023a0001000000");
}

}  // namespace
}  // namespace reseau::sim
