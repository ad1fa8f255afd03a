// Commands of a unit that is not scanning: pages, start-up, gating, measurement units, windows.
#include <gtest/gtest.h>

#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

std::string page(SimHost& host, std::string_view cdb, std::size_t n) {
  const Exchange e = host.run(cdb, n);
  EXPECT_EQ(e.status, SimHost::kGoodStatus);
  return to_hex(e.data);
}

TEST(Inquiry, PagesOfTheLs5000AreThoseOfTheRecordedUnit) {
  SimHost host("sim:ls5000?film=empty");
  EXPECT_EQ(page(host, "120000002480", 36),
            "068002021f0000004e696b6f6e2020204c532d35303030204544202020202020312e3033");
  EXPECT_EQ(page(host, "120100001780", 23), "0600001300014041475051606162c1d1e1e3f0f8e2fbfc");
  EXPECT_EQ(page(host, "120101000d80", 13), "06010009083336537472697000");
  EXPECT_EQ(page(host, "1201d1001c80", 28),
            "06d10018035242462043200000004009040000000103ffffff000000");
  EXPECT_EQ(
      page(host, "1201c1005780", 87),
      "06c1005303003d000f0000010001010003310fa00fa0005a00000000000000000000000000000f6a0fa00fa000"
      "5a000000000000000000000000000017470000174700000000006100612800000001430000100f6a0102");
}

TEST(Inquiry, PagesOfTheLs50) {
  SimHost host("sim:ls50?film=empty");
  EXPECT_EQ(page(host, "120100001580", 21),
            "060000110001404146505160"
            "61c1d1e1f0e2f8fbfc");
  EXPECT_EQ(
      page(host, "1201c1005780", 87),
      "06c1005303003a000f0000004001010001310fa00fa0005a00000000000000000000000000000f6a0fa00fa000"
      "5a0000000000000000000000000000174700001747000000000061006106000000014300000e0f6a0001");
  EXPECT_EQ(page(host, "1201e1002780", 39),
            "06e1002381048c9090da73000e0e000000000e000300000001001900030045000000"
            "00000c0400");
  EXPECT_EQ(host.status("1201e3000480"), "0205240000000000") << "no CCD curves on this model";
}

TEST(Inquiry, FilmAndAdapterShowOnTheAddressPage) {
  SimHost roll("sim:ls5000"), strip("sim:ls5000?adapter=sa21");
  const std::string a = page(roll, "1201c1005780", 87), b = page(strip, "1201c1005780", 87);
  EXPECT_EQ(a.substr(92, 8), "0003d1a6");
  EXPECT_EQ(a.substr(148, 4), "2828");
  EXPECT_EQ(b.substr(92, 8), "0000ba38");  // (6 + 2) * 5959
  EXPECT_EQ(b.substr(148, 4), "0606");
}

TEST(Inquiry, LongerThanThePageIsCutAndShorterIsHeaded) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(page(host, "1201d100ff80", 255).size(), 56U);
  EXPECT_EQ(page(host, "1201d1000480", 4), "06d10018");
}

TEST(Inquiry, AnotherLunAnswersThatNobodyIsThere) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(page(host, "122000002480", 36).substr(0, 2), "7f");
  EXPECT_EQ(host.status("002000000000"), "0205250000000000");
}

TEST(Unit, UnknownCommandsAreRefused) {
  SimHost host("sim:ls5000");
  for (const char* cdb : {"040000000000", "1c0000000000", "3b000000000000000000", "a00000000000"}) {
    EXPECT_EQ(host.status(cdb), "0205200000000000") << cdb;
  }
}

TEST(Unit, PowerOnSequence) {
  SimHost host("sim:ls5000?cold=1");
  EXPECT_EQ(host.status("25000000000000003a80"), "020b3e0000000000");
  EXPECT_EQ(host.test_unit_ready(), "0202050000000000");
  EXPECT_EQ(host.run("120000002480", 36).status, SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0202050000000000");
  EXPECT_EQ(host.test_unit_ready(), "0202050000000000");
  EXPECT_EQ(host.run("120000002480", 36).status, SimHost::kGoodStatus)
      << "INQUIRY runs and leaves the attention";
  EXPECT_EQ(host.status("25000000000000003a80"), "0206290000000000")
      << "the first other command reports it and is not executed";
  EXPECT_EQ(host.run("25000000000000003a80", 58).phase, 3);
}

TEST(Unit, FilmInsertionSequence) {
  SimHost host("sim:ls5000?film_arrives=2&busy_polls=2");
  EXPECT_EQ(host.test_unit_ready(), "02023a0001000000");
  EXPECT_EQ(host.test_unit_ready(), "02023a0001000000");
  EXPECT_EQ(host.test_unit_ready(), "0202040101000000");
  EXPECT_EQ(host.test_unit_ready(), "0202040101000000");
  EXPECT_EQ(host.test_unit_ready(), "0206280001000000");
  EXPECT_EQ(host.test_unit_ready(), "02063f0300000000");
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
}

TEST(Unit, AForbiddenCommandAbortsTheRunningOperation) {
  SimHost host("sim:ls5000?busy_polls=50");
  host.send("e000c100000000000900", "000000012c00000000");
  EXPECT_EQ(host.status("c10000000000"), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0202040100000000");
  EXPECT_EQ(host.run("1201c1000480", 4).phase, 3) << "INQUIRY is allowed";
  EXPECT_EQ(host.status("160000000000"), SimHost::kGoodStatus) << "RESERVE is allowed";
  EXPECT_EQ(host.status("25000000000000003a80"), "02052c0000000000");
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus) << "the operation is gone";
}

TEST(Unit, RequestSenseRepeatsTheLastStatus) {
  SimHost host("sim:ls5000");
  host.status("28000000000000400080");
  const Exchange e = host.run("030000001300", 19);
  EXPECT_EQ(to_hex(e.data),
            "70000500000000"
            "0b"
            "00000000"
            "2c0000000000"
            "00");
}

TEST(ModeSelect, ListLengthsAndUnits) {
  SimHost host("sim:ls5000");
  const std::string list = "0000000800000000000000010306000";
  EXPECT_EQ(host.send("151000001400", list + "00fa00000").status, SimHost::kGoodStatus);
  EXPECT_EQ(to_hex(host.run("1a1003001400", 20).data), "130000080000000000000001030600000fa00000");
  EXPECT_EQ(to_hex(host.run("1a1043001400", 20).data), "13000008000000000000000103060000ffff0000");
  EXPECT_EQ(to_hex(host.run("1a1083001400", 20).data), "1300000800000000000000010306000004b00000");
  EXPECT_EQ(to_hex(host.run("1a1803000c00", 12).data), "0b000000030600000fa00000");
  EXPECT_EQ(host.status("1a10c3001400"), "0205390000000000");
  EXPECT_EQ(host.send("151000000c00", "000000000306000004b00000").status, SimHost::kGoodStatus);
  EXPECT_EQ(host.send("151000000c00", "000000000306000003e80000").status, "0205260000000000");
  EXPECT_EQ(to_hex(host.run("1a1003001400", 20).data), "1300000800000000000000010306000004b00000");
  EXPECT_EQ(host.status("151000000500"), "02051a0000000000");
  EXPECT_EQ(host.status("151100001400"), "0205240000000000");
  EXPECT_EQ(host.status("150000001400"), "0205240000000000");
}

TEST(GetWindow, FormsOfBothModels) {
  SimHost ls5000("sim:ls5000"), ls50("sim:ls50");
  EXPECT_EQ(
      to_hex(ls5000.run("25010000000900003a80", 58).data),
      "003b0fa00000003509000fa00fa0000000000000000000000f6a00001747000000021000000000000000000000"
      "0000000081010202ff000484d1");
  const Exchange all = ls5000.run("25000000000000040080", 1024);
  EXPECT_EQ(all.data.size(), 273U);
  EXPECT_EQ(to_hex(all.data).substr(0, 4), "010f");
  const Exchange one = ls50.run("25010000000200003a80", 58);
  EXPECT_EQ(to_hex(one.data).substr(0, 24), "003800000000003202000fa0");
  EXPECT_EQ(one.data.size(), 58U);
  EXPECT_EQ(ls50.run("25000000000000040080", 1024).data.size(), 258U);
  EXPECT_EQ(ls50.status("25010000000900003a00"), "0205240000000000") << "infrared needs b7";
  EXPECT_EQ(ls50.status("25010000000500003a80"), "0205240000000000");
}

class SetWindow : public testing::Test {
 protected:
  void SetUp() override { host.send("151000001400", "000000080000000000000001030600000fa00000"); }
  std::string set(const WindowList& window, SimHost& h) {
    return h.run(kSetWindow, 0, window.list()).status;
  }
  std::string set(const WindowList& window) { return set(window, host); }
  int granted_dpi() {
    return static_cast<int>(get16(host.run("25010000000100003a80", 58).data, 10));
  }
  SimHost host{"sim:ls5000"};
};

TEST_F(SetWindow, OffLadderResolutionIsRoundedAndSaidSo) {
  EXPECT_EQ(set({.dpi = 4000}), SimHost::kGoodStatus);
  for (const int dpi : {2000, 1000, 666, 500, 400, 333, 285, 250, 90}) {
    EXPECT_EQ(set({.dpi = dpi}), SimHost::kGoodStatus) << dpi;
    EXPECT_EQ(granted_dpi(), dpi);
  }
  EXPECT_EQ(set({.dpi = 1333}), "0201370000000000");
  EXPECT_EQ(granted_dpi(), 2000);
  EXPECT_EQ(set({.dpi = 300}), "0201370000000000");
  EXPECT_EQ(granted_dpi(), 333);
  EXPECT_EQ(set({.dpi = 89}), "0205260000000000");
  EXPECT_EQ(set({.dpi = 4001}), "0205260000000000");
}

TEST_F(SetWindow, Ls50TakesEveryIntegerPitch) {
  SimHost ls50("sim:ls50");
  ls50.send("151000001400", "000000080000000000000001030600000fa00000");
  EXPECT_EQ(set({.dpi = 1333, .depth = 14}, ls50), SimHost::kGoodStatus);
  EXPECT_EQ(set({.dpi = 1333, .depth = 8}, ls50), SimHost::kGoodStatus);
  EXPECT_EQ(set({.dpi = 1333, .depth = 16}, ls50), "0205260000000000");
  EXPECT_EQ(set({.dpi = 1333, .depth = 14, .bytes_40_to_44 = "3081011202"}, ls50),
            "0205260000000000")
      << "no multi-sampling";
  EXPECT_EQ(set({.dpi = 4000, .depth = 14, .bytes_40_to_44 = "0081010240"}, ls50),
            "0205260000000000")
      << "one sensor line";
}

TEST_F(SetWindow, LimitsAndForbiddenBits) {
  EXPECT_EQ(set({.width = 3947}), "0205260000000000");
  EXPECT_EQ(set({.x = 1000, .width = 2946}), SimHost::kGoodStatus);
  EXPECT_EQ(set({.height = 5960}), "0205260000000000");
  EXPECT_EQ(set({.y = 0x3d1a7}), "0205260000000000");
  EXPECT_EQ(set({.dpi = 90, .width = 43}), "0205260000000000") << "less than a pixel";
  EXPECT_EQ(set({.depth = 14}), "0205260000000000");
  EXPECT_EQ(set({.composition = 3}), "0205260000000000");
  EXPECT_EQ(set({.exposure = 0x04000000}), "0205260000000000");
  for (const char* bytes : {"0083010202", "0081800202", "0081110202", "0081050202", "0081010802",
                            "0081010201", "0081010242", "0581010202"}) {
    EXPECT_EQ(set({.bytes_40_to_44 = bytes}), "0205260000000000") << bytes;
  }
  EXPECT_EQ(set({.id = 5}), "0205260000000000");
  const Exchange no_b7 = host.run("24000000000000003a00", 0, WindowList{.id = 9}.list());
  EXPECT_EQ(no_b7.status, "0205240000000000");
}

TEST_F(SetWindow, AShortListLeavesTheRest) {
  EXPECT_EQ(set({.dpi = 500, .exposure = 0x1234}), SimHost::kGoodStatus);
  Bytes list = WindowList{.dpi = 1000}.list();
  list.resize(8 + 6);
  list[7] = 6;
  EXPECT_EQ(host.run("24000000000000000e80", 0, list).status, SimHost::kGoodStatus);
  const Bytes stored = host.run("25010000000100003a80", 58).data;
  EXPECT_EQ(get16(stored, 10), 1000U);
  EXPECT_EQ(get32(stored, 54), 0x1234U);
  list[7] = 7;
  EXPECT_EQ(host.run("24000000000000000e80", 0, list).status, "0205260000000000");
}

TEST_F(SetWindow, ExposureZeroKeepsTheOldOne) {
  EXPECT_EQ(set({.exposure = 0x777}), SimHost::kGoodStatus);
  EXPECT_EQ(set({.exposure = 0}), SimHost::kGoodStatus);
  EXPECT_EQ(get32(host.run("25010000000100003a80", 58).data, 54), 0x777U);
}

}  // namespace
}  // namespace reseau::sim
