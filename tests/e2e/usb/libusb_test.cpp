// Our own driver through the real libusb: short packets, time-outs, stalls, a pulled plug.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/e2e/reseau_run.h"
#include "tests/e2e/scan_files.h"
#include "tests/e2e/usb/exported_unit.h"

namespace reseau::testing {
namespace {

const std::vector<std::string> kFilm{"scene=natural", "noise=0", "cells=1", "seed=5"};

std::vector<std::string> with(std::vector<std::string> settings, const std::string& one) {
  settings.push_back(one);
  return settings;
}

// A corner of the first frame into a folder of the unit.
ProcessResult scan(const ExportedUnit& unit) {
  return unit.run({RESEAU_BINARY, "scan", "-d", "usb:04b0:4002", "-x", "3mm", "-y", "2mm",
                   "--resolution", "1000dpi", "--no-reconstruct", "-o", unit.file("scans")});
}

TEST(Libusb, EachOutcomeOfATransferArrivesAsWhatItIs) {
  const ExportedUnit unit("ls5000", kFilm);
  const ProcessResult probe = unit.run({RESEAU_LIBUSB_PROBE});
  EXPECT_EQ(probe.exit_code, 0) << probe.err;
  EXPECT_EQ(probe.out,
            "identity: 16386 512\n"
            "nothing there: timeout\n"
            "command: ok\n"
            "query: ok\n"
            "phase: 03\n"
            "short data: 06 80 02 02 1F 00 00 00 … (36 bytes)\n"
            "status: 00 00 00 00 00 00 00 00\n"
            "after it: timeout\n"
            "no endpoint: stall\n"
            "clear halt: ok\n"
            "command again: ok\n"
            "query again: ok\n"
            "phase again: 01\n");
}

TEST(Libusb, ListAndDoctorSeeTheUnit) {
  const ExportedUnit unit("ls50", kFilm);
  const ProcessResult list = unit.run({RESEAU_BINARY, "list"});
  EXPECT_NE(list.out.find("usb:04b0:4001"), std::string::npos) << list.out;
  const ProcessResult doctor = unit.run({RESEAU_BINARY, "doctor"});
  EXPECT_NE(doctor.out.find("found at /dev/bus/usb/001/002, USB, high speed"), std::string::npos)
      << doctor.out;
}

// Also where each transfer is cut short, and those in flight behind it have begun to receive what
// follows.
TEST(Libusb, AScanGivesTheSamplesOfTheSimulatedUnit) {
  const ExportedUnit unit("ls5000", kFilm), cut("ls5000", with(kFilm, "fragment=2560"));
  const ProcessResult through = scan(unit), in_pieces = scan(cut);
  ASSERT_EQ(through.exit_code, 0) << through.err;
  ASSERT_EQ(in_pieces.exit_code, 0) << in_pieces.err;
  const ProcessResult direct =
      reseau({"scan", "-d", "sim:ls5000?scene=natural&noise=0&cells=1&seed=5", "-x", "3mm", "-y",
              "2mm", "--resolution", "1000dpi", "--no-reconstruct", "-o", unit.file("direct")});
  ASSERT_EQ(direct.exit_code, 0) << direct.err;
  EXPECT_EQ(read_pixels(only_file(unit.file("scans"), ".tif")).samples,
            read_pixels(only_file(unit.file("direct"), ".tif")).samples);
  EXPECT_EQ(read_pixels(only_file(cut.file("scans"), ".tif")).samples,
            read_pixels(only_file(unit.file("direct"), ".tif")).samples);
}

TEST(Libusb, ShortPacketsAndOneStallCostNothing) {
  for (const char* trouble : {"fragment=8192", "stall_after=60"}) {
    const ExportedUnit unit("ls5000", with(kFilm, trouble));
    EXPECT_EQ(scan(unit).exit_code, 0) << trouble;
  }
}

TEST(Libusb, APulledPlugIsSaidAndTheServerLives) {
  ExportedUnit unit("ls5000", with(kFilm, "unplug_after=400"));
  const ProcessResult result = scan(unit);
  EXPECT_EQ(result.exit_code, 9) << result.err;
  EXPECT_NE(result.err.find("unplugged"), std::string::npos) << result.err;
  EXPECT_EQ(unit.stop().exit_code, 0);
}

}  // namespace
}  // namespace reseau::testing
