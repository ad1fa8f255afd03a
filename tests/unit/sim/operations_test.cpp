// Operations (focus, eject, timers) and the data types beside the image.
#include <gtest/gtest.h>

#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

std::string set(SimHost& host, std::string_view op, std::string_view block) {
  return host.send("e000" + std::string(op) + "00000000000900", block).status;
}
std::string execute(SimHost& host) { return host.status("c10000000000"); }
std::string get(SimHost& host, std::string_view op) {
  return to_hex(host.run("e100" + std::string(op) + "00000000000900", 9).data);
}

TEST(Operations, ExecuteNeedsParametersOnce) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(execute(host), "02052c0000000000");
  EXPECT_EQ(set(host, "b4", "000000025800000001"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  EXPECT_EQ(get(host, "b4"), "000000025800000001");
  EXPECT_EQ(execute(host), "02052c0000000000");
}

TEST(Operations, RangesAndLengths) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(set(host, "c1", "000000014300000000"), SimHost::kGoodStatus);
  EXPECT_EQ(set(host, "c1", "000000014400000000"), "0205260000000000");
  EXPECT_EQ(set(host, "b4", "000000003b00000001"), "0205260000000000");
  EXPECT_EQ(set(host, "b4", "0000000e1100000001"), "0205260000000000");
  EXPECT_EQ(set(host, "a0", "0000000f6a00000000"), "0205260000000000");
  EXPECT_EQ(host.status("e000b400000000000500"), "0205240000000000") << "needs 9";
  EXPECT_EQ(host.status("e000c100000000000e00"), "0205240000000000") << "13 at most";
  EXPECT_EQ(host.status("e000d100000000000900"), "0205240000000000") << "no load on a strip";
  EXPECT_EQ(host.status("e000e100000000000900"), "0205240000000000");
}

TEST(Operations, AutofocusFindsTheFocusAndReportsIt) {
  SimHost host("sim:ls5000?busy_polls=3");
  EXPECT_EQ(get(host, "c1"), "00000000c000000000");
  EXPECT_EQ(set(host, "a0", "00000007b500000ba3"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(host.test_unit_ready(), "0202040100000000");
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
  EXPECT_EQ(get(host, "c1"), "00000000d100000000");
  EXPECT_EQ(get(host, "a0"), "00000007b500000ba3");
}

TEST(Operations, AutofocusOutsideTheFramesFailsAtOnce) {
  SimHost host("sim:ls5000");
  // One frame, 1000 addresses down the film.
  EXPECT_EQ(host.send("2a008f00000300000c00", "000a0100000003e80001000d").status,
            SimHost::kGoodStatus);
  EXPECT_EQ(set(host, "a0", "00000007b500000100"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), "0201610201000000");
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
  EXPECT_EQ(get(host, "c1"), "00000000c000000000") << "nothing moved";
}

TEST(Operations, AFailedAutofocusTellsWhyOnce) {
  SimHost host("sim:ls5000?focus_fails=1&busy_polls=1");
  EXPECT_EQ(set(host, "a0", "00000007b500000ba3"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0202040100000000");
  EXPECT_EQ(host.test_unit_ready(), "0202040200000000");
  EXPECT_EQ(host.status("1d0400000000"), "0201610201000000");
  EXPECT_EQ(host.status("1d0400000000"), SimHost::kGoodStatus);
}

TEST(Operations, EjectEndsWithoutAMedium) {
  SimHost host("sim:ls5000?busy_polls=2");
  EXPECT_EQ(host.status("e000d000000000000000"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0202040101000000");
  EXPECT_EQ(host.test_unit_ready(), "0202040101000000");
  EXPECT_EQ(host.test_unit_ready(), "02023a0001000000");
  EXPECT_EQ(host.run("1201c1005780", 87).data[75], 0);
}

TEST(Operations, InitialiseForgetsTheMeasurementUnit) {
  SimHost host("sim:ls5000?busy_polls=0");
  host.send("151000001400", "000000080000000000000001030600000fa00000");
  EXPECT_EQ(host.status("e0008000000000000000"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0206290000000000");
  EXPECT_EQ(get16(host.run("1a1003001400", 20).data, 16), 1200U);
}

TEST(Operations, AbortStopsAMovement) {
  SimHost host("sim:ls5000?busy_polls=100");
  EXPECT_EQ(set(host, "c0", "000000100000000000"), SimHost::kGoodStatus);
  EXPECT_EQ(execute(host), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), "0202040100000000");
  EXPECT_EQ(host.status("c00000000000"), SimHost::kGoodStatus);
  EXPECT_EQ(host.test_unit_ready(), SimHost::kGoodStatus);
  EXPECT_EQ(host.status("c00000000000"), SimHost::kGoodStatus) << "good even when nothing runs";
}

TEST(DataTypes, HeadersLengthsAndShortReads) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(to_hex(host.run("28008c00090300000a80", 10).data), "8c20000000040005055a");
  EXPECT_EQ(to_hex(host.run("28008c00090300000680", 6).data), "8c2000000004");
  const Exchange more = host.run("28008c00090300001080", 16);
  EXPECT_EQ(more.data.size(), 10U);
  EXPECT_EQ(more.status, "022b4b0000000000");
  EXPECT_EQ(host.status("28008c00090100000a80"), "0205240000000000") << "element size";
  EXPECT_EQ(host.status("28008c00070300000a80"), "0205240000000000") << "colour";
  EXPECT_EQ(to_hex(host.run("28008800000300000680", 6).data), "880000000004") << "no rectangles";
  EXPECT_EQ(to_hex(host.run("28009300000100000c80", 12).data), "930000000006035f033a026d");
  EXPECT_EQ(host.run("28009100030100009e80", 158).data.size(), 158U);
  EXPECT_EQ(host.status("28000300010100800080"), "0205240000000000") << "no LUT";
  SimHost ls50("sim:ls50");
  EXPECT_EQ(ls50.status("28009100010100009e80"), "0205240000000000") << "no CCD curves";
}

TEST(DataTypes, PerforationTableHasASwappedHeader) {
  SimHost host("sim:ls5000");
  EXPECT_EQ(to_hex(host.run("28008e00000000000680", 6).data), "008e00000004");
  EXPECT_EQ(to_hex(host.run("28008e00000000000980", 9).data),
            "8e0000000004"
            "000001");
  EXPECT_EQ(to_hex(host.run("28008e00000000000a80", 10).data),
            "008e00000004"
            "000001"
            "04");
}

TEST(DataTypes, FrameTableOfPowerOnAndOfTheHost) {
  SimHost host("sim:ls5000?adapter=sa21");
  EXPECT_EQ(to_hex(host.run("28008f00000300003a80", 58).data),
            "8f0000000034"
            "00320600"
            "0000000000000000"
            "0000174700080000"
            "00002e8e00100000"
            "000045d500180000"
            "00005d1c00200000"
            "0000746300280000");
  EXPECT_EQ(host.send("2a008f00000300000c00",
                      "000a010000001000"
                      "00050203")
                .status,
            SimHost::kGoodStatus);
  EXPECT_EQ(to_hex(host.run("28008f00000300001280", 18).data),
            "8f000000000c"
            "000a0100"
            "00001000"
            "00050203");
  EXPECT_EQ(host.send("2a008f00000300000400", "00020000").status, "0205260000000000");
  EXPECT_EQ(host.send("2a008f00000300000c00",
                      "000b010000001000"
                      "00050203")
                .status,
            "0205260000000000");
}

}  // namespace
}  // namespace reseau::sim
