// The provisional picture of a scan whose lines are still coming.
#include "core/reconstruct/live_picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/line/memory_line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "tests/support/picture.h"
#include "tests/support/synthetic_scan.h"

namespace reseau {
namespace {

constexpr int kMostLagLines = 128;

// Lines become committed when the test says so.
class GrowingSource final : public LineSource {
 public:
  explicit GrowingSource(const LineSource& whole) : whole_(whole) {}
  [[nodiscard]] const LineFormat& format() const override { return whole_.format(); }
  [[nodiscard]] int committed() const override {
    const std::scoped_lock lock(mutex_);
    return committed_;
  }
  int wait_committed(int n_lines, const std::stop_token& stop) const override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, stop, [&] { return committed_ >= n_lines; });
    return committed_;
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override {
    if (first + n > committed()) throw std::logic_error("lines were read before they were there");
    whole_.read(first, n, out);
  }
  void commit(int n_lines) {
    {
      const std::scoped_lock lock(mutex_);
      committed_ = std::max(committed_, std::min(n_lines, whole_.format().n_lines));
    }
    changed_.notify_all();
  }

 private:
  const LineSource& whole_;
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  int committed_ = 0;
};

// Keeps the provisional picture. May hold on to a tile, or throw at one.
class KeepingSink final : public LiveTileSink {
 public:
  void begin(int width_px, int height_px) override {
    const std::scoped_lock lock(mutex_);
    width_px_ = width_px;
    rgb_.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3, 0);
    times_.assign(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), 0);
  }
  void tile(const LiveTile& tile) override {
    std::unique_lock lock(mutex_);
    if (fails_) throw std::runtime_error("The page is gone.");
    for (int y = 0; y < tile.height_px; ++y) {
      for (int x = 0; x < tile.width_px; ++x) {
        const auto at =
            static_cast<std::size_t>(tile.y_px + y) * static_cast<std::size_t>(width_px_) +
            static_cast<std::size_t>(tile.x_px + x);
        ++times_[at];
        std::copy_n(tile.rgb.begin() + (static_cast<std::ptrdiff_t>(y) * tile.width_px + x) * 3, 3,
                    rgb_.begin() + static_cast<std::ptrdiff_t>(at) * 3);
      }
    }
    if (tile.x_px + tile.width_px == width_px_) end_ = tile.y_px + tile.height_px;
    ++n_tiles_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !held_; });
  }

  // Waits until the first lines up to n are there; false when they do not come.
  bool wait_for(int n_lines) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::minutes(2), [&] { return end_ >= n_lines; });
  }
  bool wait_for_a_tile() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::minutes(2), [&] { return n_tiles_ > 0; });
  }
  void hold(bool held) {
    {
      const std::scoped_lock lock(mutex_);
      held_ = held;
    }
    changed_.notify_all();
  }
  void fail() { fails_ = true; }
  // When all threads are done.
  [[nodiscard]] const std::vector<float>& rgb() const { return rgb_; }
  [[nodiscard]] bool every_pixel_once() const {
    return !times_.empty() && std::ranges::all_of(times_, [](int n) { return n == 1; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int width_px_ = 0, end_ = 0, n_tiles_ = 0;
  bool held_ = false, fails_ = false;
  std::vector<float> rgb_;
  std::vector<int> times_;
};

// A film with a picture on it; the first lines black, so that the lock comes late.
MemoryLineSource film(int n_lines, int n_black) {
  test::SyntheticScan scan;
  scan.width_px = 560;
  scan.height_px = n_lines;
  scan.scene = [n_black](double x, double y) -> std::array<double, 3> {
    if (y < n_black) return {0.0004, 0.0004, 0.0004};
    const double a = 0.5 + 0.3 * std::sin(x / 60) * std::cos(y / 70);
    return {a, 0.5 + 0.3 * std::sin((x + y) / 90), 0.9 - a};
  };
  return scan.render();
}

// The one that most tests look at.
const MemoryLineSource& short_film() {
  static const MemoryLineSource film_500 = film(500, 0);
  return film_500;
}

std::vector<float> final_picture(const LineSource& source, const Registration& registration) {
  test::MemorySink picture;
  static_cast<void>(reconstruct(source, registration, {}, picture, {}, {}));
  return picture.rgb;
}

std::vector<float> offline_picture(const LineSource& source) {
  return final_picture(source, register_screen(source, {}, {}, {}));
}

// Registers and renders while another thread commits lines, as a running scan does.
struct LiveRun {
  LiveReport report;
  bool kept_up = true;
  std::vector<float> picture;

  // The head is never more than kMostLagLines ahead of what the sink has got, once `locked` lines
  // are there.
  LiveRun(const LineSource& whole, KeepingSink& sink, int locked) {
    GrowingSource source(whole);
    LivePicture live(source, {}, sink);
    std::jthread scanner([&] {
      const int n_lines = whole.format().n_lines;
      for (int line = 0; line < n_lines; line += 8) {
        if (line >= locked && kept_up) kept_up = sink.wait_for(line + 8 - kMostLagLines);
        source.commit(line + 8);
      }
    });
    RegisterOptions options;
    options.on_snapshot = [&](auto snapshot) { live.take(std::move(snapshot)); };
    const Registration registration = register_screen(source, options, {}, {});
    scanner.join();
    kept_up = kept_up && sink.wait_for(whole.format().n_lines);
    picture = final_picture(source, registration);
    report = live.report();
  }
};

double rms_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(LivePicture, EveryLineIsThereWithin128OfTheHeadAndTheFinalPictureIsTheSame) {
  const MemoryLineSource whole = film(700, 0);
  KeepingSink sink;
  const LiveRun run(whole, sink, 256 + kMostLagLines);
  EXPECT_TRUE(run.kept_up);
  EXPECT_TRUE(sink.every_pixel_once());
  EXPECT_EQ(run.report.why_not, "");
  EXPECT_EQ(run.report.n_lines, 700);
  EXPECT_GE(run.report.n_maps, 1);
  EXPECT_LE(run.report.largest_lag_lines, kMostLagLines);
  EXPECT_EQ(run.picture, offline_picture(whole));
  const double off = rms_difference(sink.rgb(), run.picture);
  fmt::print("{} tiles, {} maps, locked after {} lines, {} lines behind at most, {:.4f} rms off\n",
             run.report.n_tiles, run.report.n_maps, run.report.lock_lines,
             run.report.largest_lag_lines, off);
  EXPECT_LT(off, 0.02);
}

TEST(LivePicture, LinesFromBeforeALateLockComeWithIt) {
  const MemoryLineSource whole = film(900, 300);
  KeepingSink sink;
  const LiveRun run(whole, sink, 512 + kMostLagLines);
  EXPECT_TRUE(run.kept_up);
  EXPECT_TRUE(sink.every_pixel_once());
  EXPECT_GE(run.report.lock_lines, 512);
}

TEST(LivePicture, ASinkThatHangsHoldsUpNeitherRegistrationNorTheFinalPicture) {
  const MemoryLineSource& whole = short_film();
  KeepingSink sink;
  sink.hold(true);
  GrowingSource source(whole);
  LivePicture live(source, {}, sink);
  RegisterOptions options;
  options.on_snapshot = [&](auto snapshot) { live.take(std::move(snapshot)); };
  source.commit(300);
  std::jthread scanner([&] {
    EXPECT_TRUE(sink.wait_for_a_tile());  // and there it hangs
    source.commit(500);
  });
  const Registration registration = register_screen(source, options, {}, {});
  live.stop();
  EXPECT_EQ(final_picture(source, registration), offline_picture(whole));
  EXPECT_EQ(live.report().n_lines, 0);
  sink.hold(false);
}

TEST(LivePicture, EndsAtOnceWhateverItWaitsFor) {
  const MemoryLineSource& whole = short_film();
  GrowingSource source(whole);
  KeepingSink sink;
  { const LivePicture waits_for_a_map(source, {}, sink); }
  RegisterOptions options;
  LivePicture waits_for_lines(source, {}, sink);
  std::stop_source stop;
  options.on_snapshot = [&](auto snapshot) { waits_for_lines.take(std::move(snapshot)); };
  source.commit(300);
  std::jthread registering(
      [&] { static_cast<void>(register_screen(source, options, {}, stop.get_token())); });
  EXPECT_TRUE(sink.wait_for_a_tile());
  stop.request_stop();
}

TEST(LivePicture, ASinkThatThrowsEndsTheProvisionalPictureOnly) {
  const MemoryLineSource& whole = short_film();
  KeepingSink sink;
  sink.fail();
  LiveReport report;
  {
    LivePicture live(whole, {}, sink);
    RegisterOptions options;
    options.on_snapshot = [&](auto snapshot) { live.take(std::move(snapshot)); };
    EXPECT_TRUE(register_screen(whole, options, {}, {}).found);
    while (report.why_not.empty()) report = live.report();
  }
  EXPECT_EQ(report.why_not, "The page is gone.");
  EXPECT_EQ(report.n_tiles, 0);
}

}  // namespace
}  // namespace reseau
