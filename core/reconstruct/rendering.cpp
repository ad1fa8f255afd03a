#include "core/reconstruct/rendering.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/reconstruct/blank_blocks.h"
#include "core/reconstruct/sharpness.h"

namespace reseau {
namespace {

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

// Of full scale; less is no light that a scan of 16 bits could tell.
constexpr double kLeastWhite = 1e-6;

void check_options(const ReconstructOptions& options) {
  if (!(options.white_level >= kLeastWhite) || !std::isfinite(options.white_level)) {
    throw InputError("The level of clear film must be a number, a millionth at least.");
  }
  if (!(options.black_level >= 0 && options.black_level <= options.white_level - kLeastWhite)) {
    throw InputError("The level without light must lie between 0 and that of clear film.");
  }
  if (options.blur_px && !(*options.blur_px > 0 && *options.blur_px <= 10)) {
    throw InputError("The blur must be a number of pixels above 0 and at most 10.");
  }
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

Sharpness measure(const LineSource& source, const Registration& registration,
                  const ReconstructOptions& options, ReconstructionReport& report,
                  const std::stop_token& stop) {
  const auto start = std::chrono::steady_clock::now();
  Sharpness sharpness;
  with_threads(options.n_threads, [&] {
    sharpness =
        measure_sharpness(source, registration, options.tone, options.unit, options.black_level,
                          options.white_level - options.black_level, stop);
  });
  report.sharpness = sharpness.report;
  report.seconds_sharpness =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return sharpness;
}

}  // namespace

Rendering::Rendering(const LineSource& source, const Registration& registration,
                     const ReconstructOptions& options, ReconstructionReport& report,
                     const std::stop_token& stop)
    : options_(options), infrared_(source.format().plane_of(Channel::kInfrared) >= 0) {
  check_options(options);
  const Sharpness sharpness = measure(source, registration, options, report, stop);
  report.from_infrared = infrared_;
  if (!infrared_) {
    report.silver_from_rgb =
        options.silver_from_rgb.value_or(SilverWeights{sharpness.silver_from_rgb, 0});
  }
  silver_from_rgb_ = report.silver_from_rgb.weights;
  offset_ = (infrared_ ? 0 : report.silver_from_rgb.offset) - options.black_level;
  blur_ = sharpness.field[3];
  if (options.blur_px) {
    blur_ = BlurSurface(*options.blur_px);
  } else if (!infrared_) {
    blur_ = BlurSurface::mixed(
        BlurSurface::mixed(sharpness.field[0], 1.0 / 3, sharpness.field[1], 1.0 / 3), 1,
        sharpness.field[2], 1.0 / 3);
  }
  std::array<double, 2> range = blur_.range_px();
  if (blur_.degree() == 0) {
    report.skipped.emplace_back("table of simulated screens: the blur is the same everywhere");
  } else if (!options.exact && range[1] - range[0] < kSameBlurPx) {
    range.fill(0.5 * (range[0] + range[1]));
    blur_ = BlurSurface(range[0]);
    report.skipped.emplace_back(
        "table of simulated screens: the blur changes by less than 0.02 px over the frame");
  }
  BlurShape shape = sharpness.shape;
  const std::array<double, 4>& far = sharpness.far_share;
  shape.far_share = infrared_ ? far[3] : (far[0] + far[1] + far[2]) / 3;
  const Mat2 linear{registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                    registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y};
  pattern_ = sharpness.printed.pattern(sharpness.report.widths.value_or(sharpness.printed.usual));
  if (registration.map.is_affine())
    report.skipped.emplace_back("displacement grid: an affine map explains the réseau");
  if (infrared_) shift_px_ = sharpness.report.infrared_shift_px;
  demosaic_ = demosaic_of(options.quality, options.demosaic);
  const double noise_ratio = std::clamp(sharpness.noise_ratio, kLeastNoise, kMostNoise);
  report.deconvolution = options.deconvolution.value_or(
      demosaic_ == Demosaic::kJoint && range[0] >= kSoftBlurPx && noise_ratio <= kLittleNoise
          ? Deconvolution::kWiener
          : Deconvolution::kNone);
  with_threads(options.n_threads, [&] {
    levels_.emplace(*pattern_,
                    BlurLevelSettings{linear, noise_ratio, range[0], range[1], shape, 1.15,
                                      demosaic_ == Demosaic::kJoint, shift_px_,
                                      sharpness.line_alternation > kLeastAlternation ? 1.0 : 0.0,
                                      sharpness.printed.colors[0], report.deconvolution});
  });
  report_conditioning(levels_->levels().back(), report);
  for (const BlurLevel& level : levels_->levels()) {
    if (!level.sharpening) continue;
    report.sharpening_noise_gain =
        std::max(report.sharpening_noise_gain, level.sharpening->noise_gain());
    report.sharpening_iterations = level.sharpening->iterations();
  }
  noise_sd_ = report.sharpening_noise_gain * noise_ratio;
  if (!options.exact && sharpness.dark_noise > 0 &&
      sharpness.dark_noise <= BlankBlocks::kMostNoise) {
    blank_noise_sd_ = report.sharpening_noise_gain * sharpness.dark_noise;
    report.skipped.emplace_back(
        "elements and detail in places darker than 1 % of clear film that show only noise");
  }
  const Mat2 scan_from_screen = linear.inverse();
  period_px_ = {Vec2{scan_from_screen.a, scan_from_screen.c},
                Vec2{scan_from_screen.b, scan_from_screen.d}};
  if (report.deconvolution != Deconvolution::kNone) sharpener_.emplace(*levels_, blur_, period_px_);
}

TileRenderer Rendering::renderer(const ScreenMap& map) const {
  TileSettings settings{map, *pattern_, *levels_, blur_, shift_px_, demosaic_, noise_sd_, {}};
  settings.blank_noise_sd = blank_noise_sd_;
  std::copy(options_.output_from_process.begin(), options_.output_from_process.end(),
            settings.output_from_process.begin());
  return TileRenderer(settings);
}

SilverSettings Rendering::silver(const LineSource& source, const TileRenderer& renderer) const {
  return {&source,    &options_.tone,      options_.white_level - options_.black_level,
          infrared_,  silver_from_rgb_,    offset_,
          period_px_, renderer.reach_px(), sharpener_ ? &*sharpener_ : nullptr};
}

}  // namespace reseau
