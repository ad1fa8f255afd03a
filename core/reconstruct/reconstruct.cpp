#include "core/reconstruct/reconstruct.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <Eigen/Dense>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/reconstruct/blurred_cell.h"
#include "core/reconstruct/element_field.h"
#include "core/reconstruct/sharpness.h"

namespace reseau {
namespace {

using Clock = std::chrono::steady_clock;

// Tiles are fixed to the frame, not to threads or to the lines that happen to be there, so that the
// bytes are the same however the work is divided.
constexpr int kTileWidth = 512, kTileHeight = 192;
// The map is evaluated every so many pixels and interpolated between: a bend of 4 px in 90 px errs
// by 0.04 px, any real film by less than 0.001.
constexpr int kMapStep = 4;
constexpr int kRefinements = 2;
// Colour directions whose contrast the blur has cut below 3 % are not brought back.
constexpr double kRidge = 1e-3;
// Elements reach so many periods: bicubic 2, refinement and unmixing 1 each, collection 1.
constexpr double kReachPeriods = 2 + kRefinements + 1 + 1;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Setup {
  const LineSource& source;
  const Registration& registration;
  const ReconstructOptions& options;
  const BlurredCell& cell;
  Vec2 silver_shift_px;  // where the silver picture lies relative to RGB
  SilverWeights silver_from_rgb;
  bool infrared = true;
  int margin_px = 0;
};

// Silver transmittance of rows [first, first + n), 1 = clear film; negative marks a pixel without
// knowledge (clipped in a channel that it is made of).
std::vector<float> silver_rows(const Setup& setup, int first, int n,
                               std::array<std::size_t, 4>* clipped, int count_first,
                               int count_end) {
  const LineFormat& format = setup.source.format();
  const auto width = static_cast<std::size_t>(format.width_px);
  std::vector<std::uint16_t> raw(format.samples_per_line() * static_cast<std::size_t>(n));
  setup.source.read(first, n, raw);
  const double black = setup.options.black_level;
  const auto scale = static_cast<float>(1 / (setup.options.white_level - black));
  const auto level =
      static_cast<float>((setup.infrared ? 0 : setup.silver_from_rgb.offset) - black);
  std::vector<float> silver(width * static_cast<std::size_t>(n), level * scale);
  constexpr std::array<Channel, 4> kOrder{Channel::kRed, Channel::kGreen, Channel::kBlue,
                                          Channel::kInfrared};
  for (std::size_t y = 0; y < static_cast<std::size_t>(n); ++y) {
    const int line = first + static_cast<int>(y);
    float* out = silver.data() + y * width;
    for (std::size_t c = 0; c < 4; ++c) {
      const int plane = format.plane_of(kOrder[c]);
      if (plane < 0) continue;
      const std::uint16_t* in =
          raw.data() + (y * format.channels.size() + static_cast<std::size_t>(plane)) * width;
      if (clipped != nullptr && line >= count_first && line < count_end) {
        (*clipped)[c] += static_cast<std::size_t>(std::count(in, in + width, std::uint16_t{65535}));
      }
      const std::vector<float>& table = setup.options.tone.table(static_cast<int>(c));
      if (setup.infrared) {
        if (c != 3) continue;
        for (std::size_t x = 0; x < width; ++x) out[x] += scale * table[in[x]];
      } else if (c < 3) {
        const auto weight = scale * static_cast<float>(setup.silver_from_rgb.weights[c]);
        for (std::size_t x = 0; x < width; ++x) out[x] += weight * table[in[x]];
      }
    }
  }
  return silver;
}

struct ScreenPoint {
  float u, v;
};

// Screen coordinates of a rectangle of pixels relative to a whole period near it, so that float
// holds them well.
class TileCoordinates {
 public:
  TileCoordinates(const ScreenMap& map, Vec2 shift_px, int x0, int y0, int width, int height)
      : columns_((width + kMapStep - 1) / kMapStep + 1), nodes_() {
    const int rows = (height + kMapStep - 1) / kMapStep + 1;
    const Vec2 base = map.screen_from_scan({static_cast<double>(x0), static_cast<double>(y0)});
    const Vec2 origin{std::floor(base.x), std::floor(base.y)};
    nodes_.reserve(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns_; ++i) {
        const Vec2 p{static_cast<double>(x0 + i * kMapStep),
                     static_cast<double>(y0 + j * kMapStep)};
        const Vec2 s = map.screen_from_scan(p - shift_px) - origin;
        nodes_.push_back({static_cast<float>(s.x), static_cast<float>(s.y)});
        lowest_ = {std::min(lowest_.x, s.x), std::min(lowest_.y, s.y)};
        highest_ = {std::max(highest_.x, s.x), std::max(highest_.y, s.y)};
      }
    }
  }
  [[nodiscard]] Vec2 lowest() const { return lowest_; }
  [[nodiscard]] Vec2 highest() const { return highest_; }

  // x, y relative to the corner.
  [[nodiscard]] ScreenPoint at(int x, int y) const {
    const int i = x / kMapStep, j = y / kMapStep;
    const float fx = static_cast<float>(x - i * kMapStep) / kMapStep;
    const float fy = static_cast<float>(y - j * kMapStep) / kMapStep;
    const ScreenPoint* a =
        &nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                static_cast<std::size_t>(i)];
    const ScreenPoint* b = a + columns_;
    const auto mix = [&](float p, float q, float r, float s) {
      const float top = p + fx * (q - p), bottom = r + fx * (s - r);
      return top + fy * (bottom - top);
    };
    return {mix(a[0].u, a[1].u, b[0].u, b[1].u), mix(a[0].v, a[1].v, b[0].v, b[1].v)};
  }

 private:
  int columns_;
  std::vector<ScreenPoint> nodes_;
  Vec2 lowest_{1e30, 1e30}, highest_{-1e30, -1e30};
};

// One tile: rows [y0, y1) of columns [x0, x1), written into rows of `out` that start at y0.
void render_tile(const Setup& setup, const std::vector<float>& silver, int silver_first,
                 int silver_rows_n, int x0, int x1, int y0, int y1, float* out) {
  const int width = setup.source.format().width_px;
  const int left = std::max(0, x0 - setup.margin_px), right = std::min(width, x1 + setup.margin_px);
  const int top = silver_first, bottom = silver_first + silver_rows_n;
  const TileCoordinates silver_at(setup.registration.map, setup.silver_shift_px, left, top,
                                  right - left, bottom - top);
  const bool shifted = !(setup.silver_shift_px == Vec2{});
  const std::optional<TileCoordinates> picture_at =
      shifted ? std::optional<TileCoordinates>(std::in_place, setup.registration.map, Vec2{}, left,
                                               top, right - left, bottom - top)
              : std::nullopt;
  ElementField field(ScreenPattern::dufaycolor(), silver_at.lowest(), silver_at.highest());
  for (int y = top; y < bottom; ++y) {
    const float* row = silver.data() + static_cast<std::ptrdiff_t>(y - silver_first) * width;
    for (int x = left; x < right; ++x) {
      const ScreenPoint s = silver_at.at(x - left, y - top);
      field.add(s.u, s.v, row[x], setup.cell.shares(s.u, s.v));
    }
  }
  field.finish(setup.cell.mean_crosstalk(), kRidge, kRefinements);
  const std::array<double, 9>& m = setup.options.output_from_process;
  std::array<float, 9> matrix{};
  std::copy(m.begin(), m.end(), matrix.begin());
  for (int y = y0; y < y1; ++y) {
    float* to = out + (static_cast<std::ptrdiff_t>(y - y0) * width + x0) * 3;
    for (int x = x0; x < x1; ++x) {
      const ScreenPoint s = (shifted ? *picture_at : silver_at).at(x - left, y - top);
      const std::array<float, 3> p = field.at(s.u, s.v);
      *to++ = matrix[0] * p[0] + matrix[1] * p[1] + matrix[2] * p[2];
      *to++ = matrix[3] * p[0] + matrix[4] * p[1] + matrix[5] * p[2];
      *to++ = matrix[6] * p[0] + matrix[7] * p[1] + matrix[8] * p[2];
    }
  }
}

void report_conditioning(const BlurredCell& cell, ReconstructionReport& report) {
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c(i, j) = cell.mean_crosstalk()[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(c.transpose() * c);
  const Eigen::Vector3d squares = eigen.eigenvalues().cwiseMax(1e-24);
  report.unmix_condition = std::sqrt(squares(2) / squares(0));
  const Eigen::Matrix3d inverse =
      (c.transpose() * c + kRidge * Eigen::Matrix3d::Identity()).inverse() * c.transpose();
  report.unmix_noise_gain = inverse.rowwise().norm().maxCoeff();
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
  ReconstructionReport report;

  auto start = Clock::now();
  Sharpness sharpness;
  with_threads(options.n_threads,
               [&] { sharpness = measure_sharpness(source, registration, options.tone, stop); });
  report.sharpness = sharpness.report;
  report.seconds_sharpness = seconds_since(start);

  start = Clock::now();
  const bool infrared = format.plane_of(Channel::kInfrared) >= 0;
  report.from_infrared = infrared;
  if (!infrared) {
    report.silver_from_rgb =
        options.silver_from_rgb.value_or(SilverWeights{sharpness.silver_from_rgb, 0});
  }
  const double measured_sigma = infrared
                                    ? sharpness.report.sigma_px[3]
                                    : (sharpness.report.sigma_px[0] + sharpness.report.sigma_px[1] +
                                       sharpness.report.sigma_px[2]) /
                                          3;
  const double sigma = options.blur_px.value_or(measured_sigma);
  const Mat2 linear{registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                    registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y};
  const ScreenPattern pattern =
      ScreenPattern::dufaycolor(sharpness.report.red_width, sharpness.report.green_length);
  const BlurredCell cell(pattern, linear, sigma);
  report_conditioning(cell, report);
  if (registration.map.is_affine())
    report.skipped.emplace_back("displacement grid: an affine map explains the réseau");
  const double period = std::max(registration.period_px[0], registration.period_px[1]);
  const Setup setup{source,
                    registration,
                    options,
                    cell,
                    infrared ? sharpness.report.infrared_shift_px : Vec2{},
                    report.silver_from_rgb,
                    infrared,
                    static_cast<int>(std::ceil(kReachPeriods * period)) + 2};

  const int width = format.width_px;
  const int n_tiles_x = (width + kTileWidth - 1) / kTileWidth;
  // Enough tiles at a time to keep many threads busy, few enough to bound memory.
  const int n_bands_at_once = std::clamp(32 / n_tiles_x, 1, 16);
  std::array<std::size_t, 4> clipped{};
  sink.begin(width, height);
  std::vector<float> picture;
  for (int first = 0; first < height; first += n_bands_at_once * kTileHeight) {
    if (stop.stop_requested()) return report;
    const int end = std::min(height, first + n_bands_at_once * kTileHeight);
    picture.resize(static_cast<std::size_t>(end - first) * static_cast<std::size_t>(width) * 3);
    const int n_bands = (end - first + kTileHeight - 1) / kTileHeight;
    std::vector<std::array<std::size_t, 4>> band_clipped(static_cast<std::size_t>(n_bands));
    with_threads(options.n_threads, [&] {
      parallel_for(n_bands, [&](int band) {
        const int y0 = first + band * kTileHeight, y1 = std::min(height, y0 + kTileHeight);
        const int top = std::max(0, y0 - setup.margin_px),
                  bottom = std::min(height, y1 + setup.margin_px);
        const std::vector<float> silver = silver_rows(
            setup, top, bottom - top, &band_clipped[static_cast<std::size_t>(band)], y0, y1);
        parallel_for(n_tiles_x, [&](int tile) {
          const int x0 = tile * kTileWidth, x1 = std::min(width, x0 + kTileWidth);
          render_tile(setup, silver, top, bottom - top, x0, x1, y0, y1,
                      picture.data() + static_cast<std::ptrdiff_t>(y0 - first) * width * 3);
        });
      });
    });
    for (const auto& counts : band_clipped) {
      for (std::size_t c = 0; c < 4; ++c) clipped[c] += counts[c];
    }
    sink.rows(first, end - first, picture);
    if (progress) progress(static_cast<double>(end) / height);
  }
  sink.end();
  for (std::size_t c = 0; c < 4; ++c) {
    report.clipped_fraction[c] =
        static_cast<double>(clipped[c]) / (static_cast<double>(width) * height);
  }
  report.seconds_render = seconds_since(start);
  return report;
}

}  // namespace reseau
