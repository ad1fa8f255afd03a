// Whatever bytes a host sends, the unit stays in one piece: it answers, or the transfer fails.
#include <random>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/unit/sim/sim_host.h"

namespace reseau::sim {
namespace {

class RandomHost {
 public:
  RandomHost(const std::string& name, unsigned seed) : host_(name), random_(seed) {}

  void step() {
    try {
      Bytes cdb = command();
      if (chance(3)) cdb[pick(cdb.size())] = static_cast<std::uint8_t>(pick(256));
      if (chance(1)) cdb.resize(pick(12));
      host_.out(cdb);
      if (chance(1)) host_.out(Bytes(pick(12), static_cast<std::uint8_t>(pick(256))));
      host_.out(Bytes{0xd0});
      for (int n = 0; n < 4; ++n) {
        const Bytes answer = host_.in(chance(1) ? pick(600) : 40000);
        if (answer == Bytes{kPhaseDataOut}) host_.out(data());
        if (last_.starts_with("280000") && answer.size() >= 512) ++n_images_;
      }
    } catch (const DeviceError&) {
      host_.usb().clear_halt(kBulkIn);
      if (chance(2)) host_.usb().reset();
    }
  }

  [[nodiscard]] int n_images() const { return n_images_; }

 private:
  std::size_t pick(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }
  bool chance(int percent) { return pick(100) < static_cast<std::size_t>(percent); }

  // Mostly the next command of a scan, else any.
  Bytes command() {
    static const std::vector<std::string> script{
        "000000000000",         "000000000000",         "151000001400", "24000000000000003a80",
        "24000000000000003a80", "24000000000000003a80", "1b0000000300", "28008700000000002180",
        "1b0000000300",         "28008700000000002180", "1b0000000300", "28008700000000002180",
        "1b0000000300",         "000000000000",         "000000000000", "28000000000100100080",
        "28000000000100100080", "28000000000100100080"};
    if (chance(95)) {
      last_ = script[next_++ % script.size()];
      return from_hex(last_);
    }
    static const std::vector<std::string> commands{
        "030000001300",         "120000002480",         "1201c1005780",
        "151000001400",         "1a1003001400",         "1b0000000300",
        "1b0000000400",         "1d0400000000",         "24000000000000003a80",
        "25000000000000003a80", "28000000000100020080", "28000000000100100080",
        "28008700000000002180", "28008c00010300000a80", "28008e00000000000680",
        "28008f00000300014a80", "2a008f00000300000c00", "28000300010100800080",
        "2a000300010100800000", "c00000000000",         "c10000000000",
        "e000a000000000000900", "e000b400000000000900", "e000c100000000000900",
        "e000d000000000000000", "e100c100000000000900", "e0008000000000000000"};
    last_ = commands[pick(commands.size())];
    return from_hex(last_);
  }

  // Something the last command could want, often enough.
  Bytes data() {
    if (last_.starts_with("24")) {
      const bool new_shape = window_.id >= 3;
      window_.id = window_.id % 3 + 1;
      if (new_shape) {
        window_.dpi = chance(80) ? 4000 : static_cast<int>(pick(5000));
        window_.depth = chance(50) ? 16 : 14;
        window_.width = static_cast<std::uint32_t>(1 + pick(64));
        window_.height = static_cast<std::uint32_t>(1 + pick(40));
        window_.bytes_40_to_44 = chance(70) ? "0081010202" : "3000011040";
      }
      WindowList window = window_;
      if (chance(3)) window.id = 9;
      Bytes list = window.list();
      if (chance(5)) list[pick(list.size())] = static_cast<std::uint8_t>(pick(256));
      return list;
    }
    if (last_.starts_with("1b")) return from_hex("010203");
    if (last_.starts_with("15")) return from_hex("000000080000000000000001030600000fa00000");
    if (last_.starts_with("2a008f")) return from_hex("000a01000000100000050203");
    return Bytes(chance(90) ? 9 : pick(40000) + 1, static_cast<std::uint8_t>(pick(256)));
  }

  SimHost host_;
  std::mt19937 random_;
  std::string last_;
  WindowList window_{.id = 3};
  std::size_t next_ = 0;
  int n_images_ = 0;
};

TEST(WireRandom, SurvivesAnyHost) {
  const char* names[] = {"sim:ls5000?width_px=32&height_px=32&border_px=0&cells=1&busy_polls=1",
                         "sim:ls50?width_px=32&height_px=32&border_px=0&cells=1&old_lut=1&cold=1",
                         "sim:ls5000?film_arrives=3&film=none&width_px=32&height_px=32&stale=700"};
  int n_images = 0;
  for (unsigned seed = 0; seed < 9; ++seed) {
    SCOPED_TRACE(seed);
    RandomHost host(names[seed % 3], seed);
    for (int n = 0; n < 3000; ++n) host.step();
    n_images += host.n_images();
  }
  EXPECT_GT(n_images, 200) << "the walk has to come as far as images";
}

}  // namespace
}  // namespace reseau::sim
