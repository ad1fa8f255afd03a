// What our encoders and parsers make of a real session of Nikon Scan on an LS-5000.
#include <array>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "drivers/coolscan/commands.h"
#include "drivers/coolscan/frames.h"
#include "drivers/coolscan/pages.h"
#include "drivers/coolscan/record_layout.h"
#include "drivers/coolscan/records.h"
#include "drivers/coolscan/window.h"
#include "drivers/scsi/sense.h"
#include "tests/unit/drivers/units.h"

namespace reseau::coolscan {
namespace {

struct Exchange {
  int number = 0;
  Cdb cdb = test_unit_ready();
  Bytes out, in;
  Bytes status;
};

class RecordedSession : public testing::Test {
 protected:
  void SetUp() override {
    std::ifstream file(RESEAU_SHARED_DIR "/data/sessions/ls5000-nikonscan4-rgbi4.jsonl");
    if (!file) GTEST_SKIP() << "the recorded session is not here";
    for (std::string line; std::getline(file, line);) {
      const auto json = nlohmann::json::parse(line);
      Exchange exchange;
      exchange.number = json.at("seq");
      exchange.cdb = Cdb(from_hex(json.at("cdb")));
      exchange.out = from_hex(json.value("data_out", ""));
      exchange.in = from_hex(json.value("expected_data_in", ""));
      exchange.status = from_hex(json.value("expected_status", ""));
      exchanges_.push_back(std::move(exchange));
    }
    ASSERT_EQ(exchanges_.size(), 607U);
  }

  template <typename Visit>
  int for_each(int opcode, Visit visit) const {
    int n = 0;
    for (const Exchange& exchange : exchanges_) {
      if (exchange.cdb.opcode() != opcode) continue;
      visit(exchange);
      ++n;
    }
    return n;
  }

  std::vector<Exchange> exchanges_;
};

std::string hex(const Cdb& cdb) { return hex_of(cdb.bytes()); }

TEST_F(RecordedSession, EveryCommandOfOursIsEncodedAsNikonScanDoes) {
  int n_encoded = 0;
  for (const Exchange& e : exchanges_) {
    const ByteView c = e.cdb.bytes();
    const auto byte = [&](std::size_t i) { return static_cast<int>(u8_at(c, i)); };
    std::optional<Cdb> ours;
    switch (e.cdb.opcode()) {
      case 0x00:
        ours = test_unit_ready();
        break;
      case 0x12:
        ours = byte(1) == 0 ? inquiry()
                            : inquiry_page(static_cast<std::uint8_t>(byte(2)),
                                           static_cast<std::size_t>(byte(4)));
        break;
      case 0x15:
        ours = mode_select();
        EXPECT_EQ(mode_select_data(4000), e.out);
        break;
      case 0x16:
        ours = reserve_unit();
        break;
      case 0x1B:
        ours = scan(e.out.size());
        break;
      case 0x24:
        ours = set_window();
        break;
      case 0x25:
        // Window 0 was asked for with "all".
        if (byte(1) == 1) ours = get_window(static_cast<Colour>(byte(5)));
        break;
      case 0x28:
        ours = read(static_cast<DataType>(byte(2)), static_cast<Colour>(byte(4)), byte(5),
                    load_be(c, 6, 3));
        break;
      case 0x2A:
        ours = send(static_cast<DataType>(byte(2)), static_cast<Colour>(byte(4)), byte(5),
                    load_be(c, 6, 3));
        break;
      case 0xC1:
        ours = execute();
        break;
      case 0xE0:
        ours = set_parameter(static_cast<Operation>(byte(2)));
        EXPECT_EQ(parameter_data(decode_parameters(e.out)), e.out) << e.number;
        break;
      case 0xE1:
        ours = get_parameter(static_cast<Operation>(byte(2)));
        break;
      default:
        ADD_FAILURE() << "unexpected " << hex(e.cdb);
    }
    if (!ours) continue;
    ++n_encoded;
    EXPECT_EQ(hex(*ours), hex(e.cdb)) << "exchange " << e.number;
  }
  EXPECT_GE(n_encoded, 600);
}

TEST_F(RecordedSession, ElementCodesAreTheRecordedOnes) {
  for_each(0x28, [&](const Exchange& e) {
    const auto type = static_cast<DataType>(u8_at(e.cdb.bytes(), 2));
    if (type != DataType::kWhiteBalanceExposure && type != DataType::kCooperation &&
        type != DataType::kFrameTable) {
      return;
    }
    EXPECT_EQ(element_code(type, 1), u8_at(e.cdb.bytes(), 5)) << e.number;
  });
}

TEST_F(RecordedSession, EveryWindowSurvivesDecodingAndEncoding) {
  std::set<int> resolutions;
  const int n = for_each(0x24, [&](const Exchange& e) {
    const std::optional<Window> window = decode_window(e.out);
    ASSERT_TRUE(window) << e.number;
    resolutions.insert(window->resolution_dpi);
    EXPECT_EQ(hex_of(encode_window(*window), 58), hex_of(e.out, 58)) << e.number;
  });
  EXPECT_GE(n, 20);
  EXPECT_EQ(resolutions, (std::set<int>{97, 285, 4000}));
}

TEST_F(RecordedSession, TheMeteringWindowIsTheDocumentedOne) {
  int n = 0;
  for_each(0x24, [&](const Exchange& e) {
    const std::optional<Window> w = decode_window(e.out);
    if (w->resolution_dpi != 285 || w->colour != Colour::kInfrared) return;
    ++n;
    EXPECT_EQ(w->y_px, 0x79E6);
    EXPECT_EQ(w->height_px, 5959);
    EXPECT_FALSE(w->positive) << "a colour negative";
    EXPECT_TRUE(w->averaging);
  });
  EXPECT_EQ(n, 3);
}

TEST_F(RecordedSession, WindowsAreReadBackAsTheyWereSet) {
  std::map<Colour, Window> set;
  int n_compared = 0;
  for (const Exchange& e : exchanges_) {
    if (e.cdb.opcode() == 0x24) {
      const Window window = *decode_window(e.out);
      set[window.colour] = window;
    } else if (e.cdb.opcode() == 0x25 && u8_at(e.cdb.bytes(), 1) == 1) {
      const std::optional<Window> got = decode_window(e.in);
      const auto sent = got ? set.find(got->colour) : set.end();
      if (sent == set.end()) continue;
      ++n_compared;
      EXPECT_EQ(*got, sent->second) << e.number;
    }
  }
  EXPECT_GE(n_compared, 10);
}

TEST_F(RecordedSession, EveryPageIsWalkedToItsLastByte) {
  std::set<int> codes;
  for_each(0x12, [&](const Exchange& e) {
    if (u8_at(e.cdb.bytes(), 1) == 0 || e.in.size() <= kPageHeadBytes) return;
    const int code = u8_at(e.in, 1);
    codes.insert(code);
    ASSERT_EQ(e.in.size(), kPageHeadBytes + u8_at(e.in, 3));
    if (code == kAddresses) {
      EXPECT_EQ(parse_addresses(e.in).unread_bytes, 0U);
      EXPECT_EQ(parse_addresses(e.in).max_dpi, 4000);
    } else if (code == kWindowAbilities) {
      EXPECT_EQ(parse_window_abilities(e.in).unread_bytes, 0U);
      EXPECT_EQ(hex_of(e.in), hex_of(from_hex(kD1Ls5000)));
    } else if (code == kDuties) {
      EXPECT_EQ(parse_duties(e.in).unread_bytes, 0U);
      EXPECT_EQ(hex_of(e.in, 64), hex_of(from_hex(kE1Ls5000), 64));
    } else if (code == kAdapterName) {
      EXPECT_EQ(parse_name_page(e.in), "36Strip");
    } else if (code == kPageList) {
      const std::vector<std::uint8_t> list = parse_page_list(e.in);
      EXPECT_EQ(list.size(), 19U);
    }
  });
  for (const int code : {kPageList, kAdapterName, kAddresses, kWindowAbilities, kDuties}) {
    EXPECT_TRUE(codes.contains(code)) << code;
  }
}

TEST_F(RecordedSession, CooperationRecordsDescribeTheRecordedLines) {
  std::vector<CooperationRecord> records;
  for_each(0x28, [&](const Exchange& e) {
    if (u8_at(e.cdb.bytes(), 2) != 0x87 || e.in.size() == kDataHeadBytes) return;
    ASSERT_EQ(e.in.size(), kDataHeadBytes + data_length(e.in));
    const std::optional<CooperationRecord> record = parse_cooperation(e.in);
    ASSERT_TRUE(record) << e.number;
    records.push_back(*record);
  });
  // Thumbnail: 6, 1; three metering passes: 6 each; final pass: 2, 6, 7.
  ASSERT_EQ(records.size(), 8U);
  EXPECT_EQ(std::get<PaddingRecord>(records[0]).line_after_bytes, 1024 - 576);
  EXPECT_EQ(std::get<LineRecord>(records[1]), (LineRecord{1, 576, 5800, 16, 145, 0, 0}));
  for (std::size_t i = 2; i <= 4; ++i) {
    const auto padding = std::get<PaddingRecord>(records[i]);
    RecordLayout layout;
    layout.width_px = 281;
    layout.n_colours = 4;
    EXPECT_EQ(padding, computed_padding(layout, 512)) << "what the unit says is what we compute";
    layout.padding = padding;
    EXPECT_EQ(layout.record_bytes(), 2560U);
  }
  EXPECT_EQ(std::get<LineRecord>(records[5]).readings, 4);
  const auto final_padding = std::get<PaddingRecord>(records[6]);
  EXPECT_EQ(final_padding.bottom_lines, 1);
  RecordLayout final_layout;
  final_layout.width_px = 3946;
  final_layout.n_colours = 4;
  final_layout.sensor_lines = 2;
  final_layout.readings = 4;
  final_layout.padding = final_padding;
  EXPECT_EQ(final_layout.record_bytes(), 207872U);
  EXPECT_EQ(std::get<CurveRecord>(records[7]).curve_types[0], 1);
}

TEST_F(RecordedSession, FrameTableAndWhiteBalanceAreRead) {
  std::vector<std::uint64_t> white_balance;
  int n_tables = 0;
  for_each(0x28, [&](const Exchange& e) {
    const int type = u8_at(e.cdb.bytes(), 2);
    if (type == 0x8C) white_balance.push_back(load_be(e.in, kDataHeadBytes, 4));
    if (type != 0x8F || e.in.size() == kDataHeadBytes) return;
    ++n_tables;
    const std::vector<FrameRecord> frames = parse_frame_table(e.in);
    ASSERT_EQ(frames.size(), 40U);
    for (std::size_t k = 0; k < frames.size(); ++k) {
      EXPECT_EQ(frames[k].address_px, static_cast<int>(k) * 5959);
    }
  });
  EXPECT_GE(n_tables, 1);
  ASSERT_GE(white_balance.size(), 4U);
  EXPECT_EQ(white_balance[0], 0xE27CU);
  EXPECT_EQ(white_balance[1], 0xBCE4U);
  EXPECT_EQ(white_balance[2], 0x8056U);
}

TEST_F(RecordedSession, EveryStatusHasASentence) {
  for (const Exchange& e : exchanges_) {
    if (e.status.size() < 5 || u8_at(e.status, 0) == 0) continue;
    const Sense sense = {static_cast<std::uint8_t>(u8_at(e.status, 1) & 0x0F), u8_at(e.status, 2),
                         u8_at(e.status, 3), u8_at(e.status, 4), false};
    EXPECT_EQ(sentence_of(sense).find("does not know"), std::string::npos) << sense.code();
  }
}

}  // namespace
}  // namespace reseau::coolscan
