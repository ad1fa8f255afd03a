#include "core/reconstruct/reconstruct.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/frame_renderer.h"
#include "core/reconstruct/sharpness.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/silver_sharpener.h"
#include "core/reconstruct/tile_renderer.h"

namespace reseau {
namespace {

using Clock = std::chrono::steady_clock;

// Tiles are fixed to the frame, not to threads or to the lines that happen to be there, so that the
// bytes are the same however the work is divided.
constexpr int kTileWidth = 512, kTileHeight = 192;
// A blur taken for another that differs by this much changes flat colours by about 0.1.
constexpr double kSameBlurPx = 0.02;
// Less of an alternation between the line beside one square and beside the other is not seen.
constexpr double kLeastAlternation = 0.01;
// What detail kernels take for the place of a colour's light is too rough under a blur above this;
// they do better on silver that was sharpened (reseau bench reconstruction).
constexpr double kSoftBlurPx = 1.2;
// With more noise over the light than this, grain is sharpened with the picture.
constexpr double kLittleNoise = 0.02;
// Noise over the light: what the model of the réseau leaves unexplained however little there is;
// and where a picture drowns.
constexpr double kLeastNoise = 0.002, kMostNoise = 0.5;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void report_conditioning(const BlurLevel& level, ReconstructionReport& report) {
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c(i, j) =
          level.cell.mean_crosstalk()[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(c.transpose() * c);
  const Eigen::Vector3d squares = eigen.eigenvalues().cwiseMax(1e-24);
  report.unmix_condition = std::sqrt(squares(2) / squares(0));
  report.unmix_noise_gain = level.elements.noise_gain();
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

struct Clipped {
  std::array<std::size_t, 4> samples{};  // R G B IR at full scale
  double of_pixels = 0;

  void add(const std::array<std::size_t, 4>& more) {
    for (std::size_t c = 0; c < 4; ++c) samples[c] += more[c];
  }
};

// Enough tiles at a time to keep many threads busy, few enough to bound memory.
int bands_at_once(int n_tiles_x) { return std::clamp(32 / n_tiles_x, 1, 16); }

// Pixel by pixel as in the scan: each band of tiles reads its own lines.
Clipped render_scan(const Job& job) {
  const int width = job.source.format().width_px, height = job.source.committed();
  const int n_tiles_x = (width + kTileWidth - 1) / kTileWidth;
  const int step = bands_at_once(n_tiles_x) * kTileHeight;
  Clipped clipped;
  clipped.of_pixels = static_cast<double>(width) * height;
  std::vector<float> picture;
  for (int first = 0; first < height; first += step) {
    if (job.stop.stop_requested()) return clipped;
    const int end = std::min(height, first + step);
    picture.resize(static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width) * 3);
    const int n_bands = (end - first + kTileHeight - 1) / kTileHeight;
    std::vector<std::array<std::size_t, 4>> band_clipped(static_cast<std::size_t>(n_bands));
    with_threads(job.options.n_threads, [&] {
      parallel_for(n_bands, [&](int band) {
        const int y0 = first + band * kTileHeight, y1 = std::min(height, y0 + kTileHeight);
        const SilverRows silver(job.silver, y0, y1);
        band_clipped[static_cast<std::size_t>(band)] = silver.clipped();
        parallel_for(n_tiles_x, [&](int tile) {
          const int x0 = tile * kTileWidth, x1 = std::min(width, x0 + kTileWidth);
          job.renderer.render(
              silver, {x0, y0, x1, y1},
              picture.data() + (static_cast<std::ptrdiff_t>(y0 - first) * width + x0) * 3,
              static_cast<std::ptrdiff_t>(width) * 3);
        });
      });
    });
    for (const auto& counts : band_clipped) clipped.add(counts);
    job.sink.rows(first, end - first, picture);
    if (job.progress) job.progress(static_cast<double>(end) / height);
  }
  return clipped;
}

// Turned or scaled: a tile may need any lines, so the silver of all that are needed is kept.
Clipped render_frame(const Job& job, const PictureFrame& frame, const ScreenMap& map) {
  const FrameRenderer renderer(job.renderer, frame, map, job.source.format().width_px,
                               job.source.committed());
  const int width = frame.width_px(), height = frame.height_px();
  // Tiles of the picture behind which about as many pixels of the scan lie as in one of its own.
  const int side = std::clamp(static_cast<int>(256 * frame.scale()), 16, 512);
  const PixelBounds lines = renderer.scan_rect({0, 0, width, height});
  const SilverRows silver(job.silver, lines.y0, std::max(lines.y1, lines.y0 + 1));
  const int n_tiles_x = (width + side - 1) / side;
  const int step = bands_at_once(n_tiles_x) * side;
  Clipped clipped;
  clipped.add(silver.clipped());
  clipped.of_pixels = static_cast<double>(job.source.format().width_px) * lines.height();
  std::vector<float> picture;
  for (int first = 0; first < height; first += step) {
    if (job.stop.stop_requested()) return clipped;
    const int end = std::min(height, first + step);
    picture.resize(static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width) * 3);
    const int n_bands = (end - first + side - 1) / side;
    with_threads(job.options.n_threads, [&] {
      parallel_for(n_bands * n_tiles_x, [&](int tile) {
        const int x0 = tile % n_tiles_x * side, y0 = first + tile / n_tiles_x * side;
        renderer.render(silver, {x0, y0, std::min(width, x0 + side), std::min(end, y0 + side)},
                        picture.data() + (static_cast<std::ptrdiff_t>(y0 - first) * width + x0) * 3,
                        static_cast<std::ptrdiff_t>(width) * 3);
      });
    });
    job.sink.rows(first, end - first, picture);
    if (job.progress) job.progress(static_cast<double>(end) / height);
  }
  return clipped;
}

}  // namespace

ReconstructionReport reconstruct(const LineSource& source, const Registration& registration,
                                 const ReconstructOptions& options, RgbRowSink& sink,
                                 const ProgressFn& progress, const std::stop_token& stop) {
  CHECK(registration.found);
  if (!(options.white_level > 0) || !std::isfinite(options.white_level)) {
    throw InputError("The level of clear film must be a positive number.");
  }
  if (!(options.black_level >= 0 && options.black_level < options.white_level)) {
    throw InputError("The level without light must lie between 0 and that of clear film.");
  }
  if (options.blur_px && !(*options.blur_px > 0 && *options.blur_px <= 10)) {
    throw InputError("The blur must be a number of pixels above 0 and at most 10.");
  }
  const LineFormat& format = source.format();
  const int height = source.committed();
  const PictureFrame frame(options.frame, registration, format.width_px, height);
  ReconstructionReport report;

  const double light = options.white_level - options.black_level;
  auto start = Clock::now();
  Sharpness sharpness;
  with_threads(options.n_threads, [&] {
    sharpness = measure_sharpness(source, registration, options.tone, options.unit,
                                  options.black_level, light, stop);
  });
  report.sharpness = sharpness.report;
  report.seconds_sharpness = seconds_since(start);

  start = Clock::now();
  const bool infrared = format.plane_of(Channel::kInfrared) >= 0;
  report.from_infrared = infrared;
  if (!infrared) {
    report.silver_from_rgb =
        options.silver_from_rgb.value_or(SilverWeights{sharpness.silver_from_rgb, 0});
  }
  BlurSurface blur = sharpness.field[3];
  if (options.blur_px) {
    blur = BlurSurface(*options.blur_px);
  } else if (!infrared) {
    blur = BlurSurface::mixed(
        BlurSurface::mixed(sharpness.field[0], 1.0 / 3, sharpness.field[1], 1.0 / 3), 1,
        sharpness.field[2], 1.0 / 3);
  }
  std::array<double, 2> range = blur.range_px();
  if (blur.degree() == 0) {
    report.skipped.emplace_back("table of simulated screens: the blur is the same everywhere");
  } else if (!options.exact && range[1] - range[0] < kSameBlurPx) {
    range.fill(0.5 * (range[0] + range[1]));
    blur = BlurSurface(range[0]);
    report.skipped.emplace_back(
        "table of simulated screens: the blur changes by less than 0.02 px over the frame");
  }
  BlurShape shape = sharpness.shape;
  const std::array<double, 4>& far = sharpness.far_share;
  shape.far_share = infrared ? far[3] : (far[0] + far[1] + far[2]) / 3;
  const Mat2 linear{registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                    registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y};
  const ScreenPattern pattern =
      sharpness.printed.pattern(sharpness.report.widths.value_or(sharpness.printed.usual));
  if (registration.map.is_affine())
    report.skipped.emplace_back("displacement grid: an affine map explains the réseau");
  const Vec2 shift = infrared ? sharpness.report.infrared_shift_px : Vec2{};
  const Demosaic demosaic = demosaic_of(options.quality, options.demosaic);
  const double noise_ratio = std::clamp(sharpness.noise_ratio, kLeastNoise, kMostNoise);
  report.deconvolution = options.deconvolution.value_or(
      demosaic == Demosaic::kJoint && range[0] >= kSoftBlurPx && noise_ratio <= kLittleNoise
          ? Deconvolution::kWiener
          : Deconvolution::kNone);
  std::optional<BlurLevels> levels;
  with_threads(options.n_threads, [&] {
    levels.emplace(pattern,
                   BlurLevelSettings{linear, noise_ratio, range[0], range[1], shape, 1.15,
                                     demosaic == Demosaic::kJoint, shift,
                                     sharpness.line_alternation > kLeastAlternation ? 1.0 : 0.0,
                                     sharpness.printed.colors[0], report.deconvolution});
  });
  report_conditioning(levels->levels().back(), report);
  for (const BlurLevel& level : levels->levels()) {
    if (!level.sharpening) continue;
    report.sharpening_noise_gain =
        std::max(report.sharpening_noise_gain, level.sharpening->noise_gain());
    report.sharpening_iterations = level.sharpening->iterations();
  }
  const double noise_gain = report.sharpening_noise_gain;
  TileSettings tile_settings{registration.map,         pattern, *levels, blur, shift, demosaic,
                             noise_gain * noise_ratio, {}};
  if (!options.exact && sharpness.dark_noise > 0 &&
      sharpness.dark_noise <= BlankBlocks::kMostNoise) {
    tile_settings.blank_noise_sd = noise_gain * sharpness.dark_noise;
    report.skipped.emplace_back(
        "elements and detail in places darker than 1 % of clear film that show only noise");
  }
  std::copy(options.output_from_process.begin(), options.output_from_process.end(),
            tile_settings.output_from_process.begin());
  const TileRenderer renderer(tile_settings);
  const Mat2 scan_from_screen = linear.inverse();
  const std::array<Vec2, 2> period_px{Vec2{scan_from_screen.a, scan_from_screen.c},
                                      Vec2{scan_from_screen.b, scan_from_screen.d}};
  std::optional<SilverSharpener> sharpener;
  if (report.deconvolution != Deconvolution::kNone) sharpener.emplace(*levels, blur, period_px);
  const SilverSettings silver_settings{
      &source,
      &options.tone,
      light,
      infrared,
      report.silver_from_rgb.weights,
      (infrared ? 0 : report.silver_from_rgb.offset) - options.black_level,
      period_px,
      renderer.reach_px(),
      sharpener ? &*sharpener : nullptr};

  const Job job{source, options, renderer, silver_settings, sink, progress, stop};
  report.width_px = frame.width_px();
  report.height_px = frame.height_px();
  report.turned_deg = frame.turned_deg();
  sink.begin(frame.width_px(), frame.height_px());
  const Clipped clipped =
      frame.is_scan() ? render_scan(job) : render_frame(job, frame, registration.map);
  if (stop.stop_requested()) return report;
  sink.end();
  for (std::size_t c = 0; c < 4; ++c) {
    report.clipped_fraction[c] =
        static_cast<double>(clipped.samples[c]) / std::max<double>(1, clipped.of_pixels);
  }
  report.seconds_render = seconds_since(start);
  return report;
}

}  // namespace reseau
