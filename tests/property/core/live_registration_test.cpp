// Snapshots while lines arrive, and a final map that does not depend on how they did.
#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "drivers/sim/simulate.h"

namespace reseau {
namespace {

// Commits lines only as they are asked for, so many at a time.
class ChunkedSource final : public LineSource {
 public:
  ChunkedSource(const LineSource& whole, int chunk) : whole_(whole), chunk_(chunk) {}
  [[nodiscard]] const LineFormat& format() const override { return whole_.format(); }
  [[nodiscard]] int committed() const override { return committed_; }
  int wait_committed(int n_lines, const std::stop_token& stop) const override {
    (void)stop;
    const int whole_chunks = (n_lines + chunk_ - 1) / chunk_ * chunk_;
    committed_ = std::max(committed_, std::min(whole_.format().n_lines, whole_chunks));
    return committed_;
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override {
    EXPECT_LE(first + n, committed_) << "lines were read before they were there";
    whole_.read(first, n, out);
  }

 private:
  const LineSource& whole_;
  int chunk_;
  mutable int committed_ = 0;
};

using Snapshots = std::vector<std::shared_ptr<const RegistrationSnapshot>>;

sim::SimulatedScan film(const std::string& settings) {
  return sim::simulate_frame(
      sim::parse_sim_spec("ls5000?width_px=700&height_px=900&scene=natural&angle=23&" + settings));
}

Registration run(const LineSource& source, Snapshots* snapshots) {
  RegisterOptions options;
  if (snapshots != nullptr) {
    options.on_snapshot = [&](std::shared_ptr<const RegistrationSnapshot> snapshot) {
      snapshots->push_back(std::move(snapshot));
    };
  }
  return register_screen(source, options, {}, {});
}

// rms distance of a snapshot from the truth in the lines that it holds for [px]; whole periods and
// turns of the pattern aside.
double off_px(const RegistrationSnapshot& snapshot, const sim::SimulatedScan& scan) {
  const ScreenMap& map = snapshot.registration.map;
  double best = 1e300;
  for (const double sign : {1.0, -1.0}) {
    double sum = 0;
    int n = 0;
    Vec2 whole;
    for (int y = 20; y < snapshot.n_lines; y += 12) {
      for (int x = 20; x + 20 < scan.format.width_px; x += 12, ++n) {
        const auto truth = scan.truth.screen_from_scan(x, y);
        const Vec2 p{double(x), double(y)};
        Vec2 off = map.screen_from_scan(p) - sign * Vec2{truth.u, truth.v};
        if (n == 0) whole = {std::round(off.x), std::round(off.y)};
        const Vec2 px = map.jacobian(p).inverse() * (off - whole);
        sum += dot(px, px);
      }
    }
    best = std::min(best, std::sqrt(sum / n));
  }
  return best;
}

TEST(LiveRegistration, LocksWithin300LinesAndFollowsBlockByBlock) {
  struct Film {
    std::string settings;
    double bar_px;
  };
  for (const Film& test : {Film{"", 0.02}, Film{"warp_px=4&warp_length_px=700", 0.1},
                           Film{"wave_px=0.4&wave_lines=220", 0.4}}) {
    const sim::SimulatedScan scan = film(test.settings);
    const MemoryLineSource whole(scan.format, scan.samples);
    Snapshots snapshots;
    ASSERT_TRUE(run(ChunkedSource(whole, 64), &snapshots).found) << test.settings;
    ASSERT_FALSE(snapshots.empty()) << test.settings;
    EXPECT_LE(snapshots.front()->n_lines, 300) << test.settings;
    double worst = 0;
    int before = 0;
    for (const auto& snapshot : snapshots) {
      EXPECT_GT(snapshot->n_lines, before);
      EXPECT_LE(snapshot->n_lines - before, before == 0 ? 300 : 2 * kSnapshotLines);
      before = snapshot->n_lines;
      EXPECT_EQ(snapshot->registration.screen, "dufaycolor");
      worst = std::max(worst, off_px(*snapshot, scan));
    }
    EXPECT_EQ(before, scan.format.n_lines);
    fmt::print("{}: {} snapshots, first after {} lines, at most {:.4f} px rms off\n", test.settings,
               snapshots.size(), snapshots.front()->n_lines, worst);
    EXPECT_LT(worst, test.bar_px) << test.settings;
  }
}

TEST(LiveRegistration, TheFinalMapDoesNotDependOnHowLinesArrive) {
  const sim::SimulatedScan scan = film("warp_px=3&warp_length_px=500&noise=0.01");
  const MemoryLineSource whole(scan.format, scan.samples);
  const Registration expected = run(whole, nullptr);
  ASSERT_TRUE(expected.found);
  Snapshots first;
  for (const int chunk : {1, 7, 64, 333, 900}) {
    Snapshots snapshots;
    const Registration found = run(ChunkedSource(whole, chunk), &snapshots);
    ASSERT_TRUE(found.found) << chunk;
    for (int y = 0; y < scan.format.n_lines; y += 37) {
      for (int x = 0; x < scan.format.width_px; x += 41) {
        const Vec2 p{double(x), double(y)};
        ASSERT_EQ(found.map.screen_from_scan(p), expected.map.screen_from_scan(p)) << chunk;
        ASSERT_EQ(found.uncertainty.at(p).xx, expected.uncertainty.at(p).xx) << chunk;
      }
    }
    EXPECT_EQ(found.residual_px, expected.residual_px) << chunk;
    // And neither do the snapshots.
    if (first.empty()) first = snapshots;
    ASSERT_EQ(snapshots.size(), first.size()) << chunk;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const Vec2 p{300, first[i]->n_lines - 1.0};
      EXPECT_EQ(snapshots[i]->n_lines, first[i]->n_lines) << chunk;
      EXPECT_EQ(snapshots[i]->registration.map.screen_from_scan(p),
                first[i]->registration.map.screen_from_scan(p))
          << chunk;
    }
  }
}

}  // namespace
}  // namespace reseau
