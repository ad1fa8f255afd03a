#include "core/reconstruct/reconstruct.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/reconstruct/frame_renderer.h"
#include "core/reconstruct/rendering.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/tile_renderer.h"

namespace reseau {
namespace {

using Clock = std::chrono::steady_clock;

// Tiles are fixed to the frame, not to threads or to the lines that happen to be there, so that the
// bytes are the same however the work is divided.
constexpr int kTileWidth = 512, kTileHeight = 192;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Job {
  const LineSource& source;
  const ReconstructOptions& options;
  const TileRenderer& renderer;
  const SilverSettings& silver;
  RgbRowSink& sink;
  const ProgressFn& progress;
  const std::stop_token& stop;
};

// What was met in a picture.
struct Counts {
  std::array<std::size_t, 4> clipped{};  // samples R G B IR at full scale
  double of_samples = 0;                 // of a channel
  std::size_t blank = 0;                 // pixels
  double of_pixels = 0;

  void add_clipped(const std::array<std::size_t, 4>& more) {
    for (std::size_t c = 0; c < 4; ++c) clipped[c] += more[c];
  }
};

// Enough tiles at a time to keep many threads busy, few enough to bound memory.
int bands_at_once(int n_tiles_x) { return std::clamp(32 / n_tiles_x, 1, 16); }

// Pixel by pixel as in the scan: each band of tiles reads its own lines.
Counts render_scan(const Job& job) {
  const int width = job.source.format().width_px, height = job.source.committed();
  const int n_tiles_x = (width + kTileWidth - 1) / kTileWidth;
  const int step = bands_at_once(n_tiles_x) * kTileHeight;
  Counts counts;
  counts.of_pixels = counts.of_samples = static_cast<double>(width) * height;
  std::vector<float> picture;
  for (int first = 0; first < height; first += step) {
    if (job.stop.stop_requested()) return counts;
    const int end = std::min(height, first + step);
    picture.resize(static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width) * 3);
    const int n_bands = (end - first + kTileHeight - 1) / kTileHeight;
    std::vector<std::array<std::size_t, 4>> band_clipped(static_cast<std::size_t>(n_bands));
    std::vector<std::size_t> band_blank(static_cast<std::size_t>(n_bands));
    with_threads(job.options.n_threads, [&] {
      parallel_for(n_bands, [&](int band) {
        const int y0 = first + band * kTileHeight, y1 = std::min(height, y0 + kTileHeight);
        const SilverRows silver(job.silver, y0, y1);
        band_clipped[static_cast<std::size_t>(band)] = silver.clipped();
        std::vector<std::size_t> tile_blank(static_cast<std::size_t>(n_tiles_x));
        parallel_for(n_tiles_x, [&](int tile) {
          const int x0 = tile * kTileWidth, x1 = std::min(width, x0 + kTileWidth);
          tile_blank[static_cast<std::size_t>(tile)] = job.renderer.render(
              silver, {x0, y0, x1, y1},
              picture.data() + (static_cast<std::ptrdiff_t>(y0 - first) * width + x0) * 3,
              static_cast<std::ptrdiff_t>(width) * 3);
        });
        band_blank[static_cast<std::size_t>(band)] =
            std::accumulate(tile_blank.begin(), tile_blank.end(), std::size_t{0});
      });
    });
    for (const auto& clipped : band_clipped) counts.add_clipped(clipped);
    for (const std::size_t blank : band_blank) counts.blank += blank;
    job.sink.rows(first, end - first, picture);
    if (job.progress) job.progress(static_cast<double>(end) / height);
  }
  return counts;
}

// Turned or scaled: a tile may need any lines, so the silver of all that are needed is kept.
Counts render_frame(const Job& job, const PictureFrame& frame, const ScreenMap& map,
                    std::vector<std::string>& skipped) {
  const FrameRenderer renderer(job.renderer, frame, map, job.source.format().width_px,
                               job.source.committed(), job.options.exact);
  if (renderer.step_px() > 1) {
    skipped.push_back("all but every " + std::to_string(renderer.step_px()) +
                      ". pixel and row: the picture is too small to show them");
  }
  const int width = frame.width_px(), height = frame.height_px();
  // Tiles of the picture behind which about as many pixels of the scan lie as in one of its own.
  const int side = std::clamp(static_cast<int>(512 * frame.scale()), 16, 512);
  const PixelBounds lines = renderer.scan_rect({0, 0, width, height});
  const SilverRows silver(job.silver, lines.y0, std::max(lines.y1, lines.y0 + 1));
  const int n_tiles_x = (width + side - 1) / side;
  const int step = bands_at_once(n_tiles_x) * side;
  Counts counts;
  counts.add_clipped(silver.clipped());
  counts.of_samples = static_cast<double>(job.source.format().width_px) * lines.height();
  std::vector<float> picture;
  for (int first = 0; first < height; first += step) {
    if (job.stop.stop_requested()) return counts;
    const int end = std::min(height, first + step);
    picture.resize(static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width) * 3);
    const int n_bands = (end - first + side - 1) / side;
    std::vector<FrameRenderer::Work> work(static_cast<std::size_t>(n_bands * n_tiles_x));
    with_threads(job.options.n_threads, [&] {
      parallel_for(n_bands * n_tiles_x, [&](int tile) {
        const int x0 = tile % n_tiles_x * side, y0 = first + tile / n_tiles_x * side;
        work[static_cast<std::size_t>(tile)] = renderer.render(
            silver, {x0, y0, std::min(width, x0 + side), std::min(end, y0 + side)},
            picture.data() + (static_cast<std::ptrdiff_t>(y0 - first) * width + x0) * 3,
            static_cast<std::ptrdiff_t>(width) * 3);
      });
    });
    for (const FrameRenderer::Work& of_tile : work) {
      counts.blank += of_tile.blank_pixels;
      counts.of_pixels += static_cast<double>(of_tile.pixels);
    }
    job.sink.rows(first, end - first, picture);
    if (job.progress) job.progress(static_cast<double>(end) / height);
  }
  return counts;
}

}  // namespace

ReconstructionReport reconstruct(const LineSource& source, const Registration& registration,
                                 const ReconstructOptions& options, RgbRowSink& sink,
                                 const ProgressFn& progress, const std::stop_token& stop) {
  CHECK(registration.found);
  const LineFormat& format = source.format();
  const int height = source.committed();
  const PictureFrame frame(options.frame, registration, format.width_px, height);
  ReconstructionReport report;

  const auto start = Clock::now();
  const Rendering rendering(source, registration, options, report, stop);
  const TileRenderer renderer = rendering.renderer(registration.map);
  const SilverSettings silver_settings = rendering.silver(source, renderer);

  const Job job{source, options, renderer, silver_settings, sink, progress, stop};
  report.width_px = frame.width_px();
  report.height_px = frame.height_px();
  report.turned_deg = frame.turned_deg();
  sink.begin(frame.width_px(), frame.height_px());
  const Counts counts = frame.is_scan()
                            ? render_scan(job)
                            : render_frame(job, frame, registration.map, report.skipped);
  if (stop.stop_requested()) return report;
  report.seconds_render = seconds_since(start) - report.seconds_sharpness;
  sink.end();
  for (std::size_t c = 0; c < 4; ++c) {
    report.clipped_fraction[c] =
        static_cast<double>(counts.clipped[c]) / std::max<double>(1, counts.of_samples);
  }
  report.blank_fraction = static_cast<double>(counts.blank) / std::max<double>(1, counts.of_pixels);
  return report;
}

}  // namespace reseau
