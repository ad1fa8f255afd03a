#include "core/reconstruct/live_picture.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <future>
#include <utility>

#include "core/base/parallel.h"
#include "core/line/first_lines.h"
#include "core/reconstruct/rendering.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/tile_renderer.h"

namespace reseau {
namespace {

// Rendered at once: no fewer lines, which would be mostly margin, and no more, for the memory.
constexpr int kFewestLines = 32, kMostLines = 192;
constexpr int kLiveTileWidth = 512;

ReconstructOptions draft_of(ReconstructOptions options) {
  options.quality = Quality::kDraft;
  options.demosaic.reset();
  options.deconvolution = Deconvolution::kNone;
  options.frame = {};
  options.exact = false;
  return options;
}

}  // namespace

LivePicture::LivePicture(const LineSource& source, const ReconstructOptions& options,
                         LiveTileSink& sink)
    : source_(source), options_(draft_of(options)), sink_(sink) {
  thread_ = std::jthread([this](const std::stop_token& stop) noexcept { run(stop); });
}

void LivePicture::take(std::shared_ptr<const RegistrationSnapshot> snapshot) {
  {
    const std::scoped_lock lock(mutex_);
    if (report_.lock_lines == 0) report_.lock_lines = source_.committed();
    snapshot_ = std::move(snapshot);
  }
  changed_.notify_all();
}

void LivePicture::stop() { thread_.request_stop(); }

LiveReport LivePicture::report() const {
  const std::scoped_lock lock(mutex_);
  return report_;
}

void LivePicture::run(const std::stop_token& stop) noexcept {
  std::string why;
  try {
    paint(stop);
    return;
  } catch (const std::exception& error) {
    why = error.what();
  } catch (...) {
    why = "It failed for an unknown reason.";
  }
  const std::scoped_lock lock(mutex_);
  report_.why_not = std::move(why);
}

std::shared_ptr<const RegistrationSnapshot> LivePicture::wait_for_map(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, stop, [this] { return snapshot_ != nullptr; });
  return stop.stop_requested() ? nullptr : snapshot_;
}

std::shared_ptr<const RegistrationSnapshot> LivePicture::newest() const {
  const std::scoped_lock lock(mutex_);
  return snapshot_;
}

std::unique_ptr<const Rendering> LivePicture::measure(int n_lines,
                                                      const RegistrationSnapshot& snapshot,
                                                      const std::stop_token& stop) const {
  ReconstructionReport unread;
  return std::make_unique<const Rendering>(FirstLines(source_, n_lines), snapshot.registration,
                                           options_, unread, stop);
}

void LivePicture::paint(const std::stop_token& stop) {
  if (wait_for_map(stop) == nullptr) return;
  const int height = source_.format().n_lines;
  sink_.begin(source_.format().width_px, height);
  std::unique_ptr<const Rendering> rendering;
  std::future<std::unique_ptr<const Rendering>> better;
  std::shared_ptr<const RegistrationSnapshot> used;
  int measured = 0, reach = 0;
  for (int done = 0; done < height;) {
    const int need = std::min(height, done + kFewestLines + reach);
    const int have = source_.wait_committed(need, stop);
    if (stop.stop_requested() || have < need) return;
    const auto snapshot = newest();
    if (rendering == nullptr) {
      measured = have;
      rendering = measure(have, *snapshot, stop);
    } else if (have >= 2 * measured && !better.valid()) {
      // Lines go on coming, and go on with what there is, while that is made.
      measured = have;
      better = std::async(std::launch::async,
                          [this, have, snapshot, &stop] { return measure(have, *snapshot, stop); });
    }
    if (better.valid() && better.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
      rendering = better.get();
    if (stop.stop_requested()) return;
    reach = rendering->renderer(snapshot->registration.map).reach_px();
    int end = have == height ? height : (have - reach) / kFewestLines * kFewestLines;
    end = std::min(end, done + kMostLines);
    if (end <= done) continue;
    const int head = paint_band(done, end, *rendering, *snapshot, stop);
    if (stop.stop_requested()) return;
    const std::scoped_lock lock(mutex_);
    if (snapshot != used) ++report_.n_maps;
    used = snapshot;
    if (done >= report_.lock_lines) {
      report_.largest_lag_lines = std::max(report_.largest_lag_lines, head - done);
    }
    report_.n_lines = done = end;
  }
}

int LivePicture::paint_band(int first, int end, const Rendering& rendering,
                            const RegistrationSnapshot& snapshot, const std::stop_token& stop) {
  const TileRenderer renderer = rendering.renderer(snapshot.registration.map);
  // Lines that come meanwhile must not be there in one place and missing in another.
  const FirstLines lines(source_, std::min(source_.committed(), end + renderer.reach_px()));
  const int width = source_.format().width_px;
  const int n_tiles = (width + kLiveTileWidth - 1) / kLiveTileWidth;
  pixels_.resize(static_cast<std::size_t>(n_tiles));
  const auto rect = [&](int tile) {
    const int x0 = tile * kLiveTileWidth;
    return PixelBounds{x0, first, std::min(width, x0 + kLiveTileWidth), end};
  };
  with_threads(options_.n_threads, [&] {
    const SilverRows silver(rendering.silver(lines, renderer), first, end);
    parallel_for(n_tiles, [&](int tile) {
      if (stop.stop_requested()) return;
      const PixelBounds bounds = rect(tile);
      std::vector<float>& pixels = pixels_[static_cast<std::size_t>(tile)];
      const auto stride = static_cast<std::ptrdiff_t>(bounds.width()) * 3;
      pixels.resize(static_cast<std::size_t>(stride * bounds.height()));
      renderer.render(silver, bounds, pixels.data(), stride);
    });
  });
  const int head = source_.committed();
  for (int tile = 0; tile < n_tiles && !stop.stop_requested(); ++tile) {
    const PixelBounds bounds = rect(tile);
    sink_.tile({bounds.x0, bounds.y0, bounds.width(), bounds.height(),
                pixels_[static_cast<std::size_t>(tile)], snapshot.n_lines, source_.committed()});
    const std::scoped_lock lock(mutex_);
    ++report_.n_tiles;
  }
  return head;
}

}  // namespace reseau
