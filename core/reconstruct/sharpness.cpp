#include "core/reconstruct/sharpness.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/reconstruct/blank_blocks.h"
#include "core/reconstruct/clear_elements.h"
#include "core/reconstruct/sharpness_fit.h"
#include "core/screen/element_model.h"
#include "core/screen/lattice_search.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDefaultSigmaPx = 0.7;
constexpr double kMeasuredSdPx = 0.1;  // surer than this, or it is not called measured
constexpr int kTilesAcross = 14;

struct TilePlace {
  int x, y;
};
struct MeasuredTiles {
  std::vector<ScreenTile> tiles;
  std::vector<Vec2> middles;  // [px]
};

std::vector<TilePlace> tile_places(int width, int height, int size) {
  std::vector<TilePlace> places;
  const int nx = std::clamp(width / size, 1, kTilesAcross);
  const int ny = std::clamp(height / size, 1, kTilesAcross);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const long long x = nx > 1 ? static_cast<long long>(i) * (width - size) / (nx - 1) : 0;
      const long long y = ny > 1 ? static_cast<long long>(j) * (height - size) / (ny - 1) : 0;
      places.push_back({static_cast<int>(x), static_cast<int>(y)});
    }
  }
  return places;
}

MeasuredTiles measure_tiles(const LineSource& source, const Registration& registration,
                            const ToneCurves& tone, const std::stop_token& stop) {
  const LineFormat& format = source.format();
  const double period = std::max(registration.period_px[0], registration.period_px[1]);
  const int size = std::min(
      {std::max(64, static_cast<int>(std::ceil(6 * period))), format.width_px, source.committed()});
  const std::vector<TilePlace> places = tile_places(format.width_px, source.committed(), size);
  std::vector<ScreenTile> tiles(places.size());
  std::vector<std::size_t> row_starts;  // tiles of one row share their lines
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i == 0 || places[i].y != places[i - 1].y) row_starts.push_back(i);
  }
  parallel_for(static_cast<int>(row_starts.size()), [&](int row) {
    const auto r = static_cast<std::size_t>(row);
    if (stop.stop_requested()) return;
    LinearReader reader(source, tone);
    LinearRows rows;
    const std::size_t end = r + 1 < row_starts.size() ? row_starts[r + 1] : places.size();
    reader.read(places[row_starts[r]].y, size, rows);
    for (std::size_t i = row_starts[r]; i < end; ++i) {
      tiles[i] = measure_screen_tile(rows, places[i].x, size, registration.map);
    }
  });
  std::vector<Vec2> middles;
  middles.reserve(places.size());
  for (const TilePlace& place : places)
    middles.push_back({place.x + 0.5 * (size - 1), place.y + 0.5 * (size - 1)});
  return {std::move(tiles), std::move(middles)};
}

using Amplitudes = ElementModel::Amplitudes;
using Columns = ElementModel::Columns;

// Light of each element in one channel of a tile (intensity x response), by least squares.
Eigen::Vector3d element_light(const ScreenTile& tile, std::size_t channel, const Columns& a) {
  return a.householderQr().solve(weighted_amplitudes(tile.amplitude[channel]));
}

// Response of each channel to each clear element: with infrared, the light in R, G, B regressed on
// the silver; without, the direction of each element's light is known and its size is not, so the
// brightest tiles count as clear.
Response fit_response(const std::vector<ScreenTile>& tiles, const ElementModel& model,
                      const std::array<double, 4>& sigma_px, bool infrared) {
  std::array<Columns, 4> columns;
  for (std::size_t c = 0; c < 4; ++c)
    columns[c] = model.columns(sigma_px[c] > 0 ? sigma_px[c] : kDefaultSigmaPx);
  std::array<Eigen::Vector3d, 3> sum_xt;   // per element: sum of light (R, G, B) times silver
  std::array<Eigen::Matrix3d, 3> scatter;  // per element: sum of light light^T
  std::array<double, 3> sum_tt{};
  std::array<std::vector<double>, 3> size;
  for (std::size_t k = 0; k < 3; ++k) {
    sum_xt[k].setZero();
    scatter[k].setZero();
  }
  for (const ScreenTile& tile : tiles) {
    if (!tile.used) continue;
    Eigen::Matrix3d light;  // column c: the three elements in channel c
    for (std::size_t c = 0; c < 3; ++c)
      light.col(static_cast<Eigen::Index>(c)) = element_light(tile, c, columns[c]);
    const Eigen::Vector3d silver =
        infrared ? element_light(tile, 3, columns[3]) : Eigen::Vector3d::Zero();
    const double weight = tile_weight(tile, infrared ? 3 : 1);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Eigen::Vector3d x = light.row(i).transpose();
      sum_xt[k] += weight * silver(i) * x;
      sum_tt[k] += weight * silver(i) * silver(i);
      scatter[k] += weight * x * x.transpose();
      size[k].push_back(x.norm());
    }
  }
  Response response{};
  for (std::size_t k = 0; k < 3; ++k) {
    Eigen::Vector3d p;
    if (infrared) {
      p = sum_xt[k] / std::max(sum_tt[k], 1e-30);
    } else {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter[k]);
      p = eigen.eigenvectors().col(2);
      if (p.sum() < 0) p = -p;
      const auto high = size[k].begin() + static_cast<std::ptrdiff_t>(size[k].size() * 95 / 100);
      std::nth_element(size[k].begin(), high, size[k].end());
      p *= *high;
    }
    for (std::size_t c = 0; c < 3; ++c) response[k][c] = p(static_cast<Eigen::Index>(c));
  }
  return response;
}

// Where a detail of RGB at p is found in infrared: p + shift [px]. Zero when the picture does not
// tell it to a tenth of a pixel.
Vec2 infrared_shift(const std::vector<ScreenTile>& tiles, const std::array<double, 3>& weights,
                    const Registration& registration) {
  std::array<double, 2> phase{};
  for (std::size_t h = 0; h < 2; ++h) {
    // silver from RGB = rho * infrared + kappa * mean; kappa takes what imperfect weights leave.
    Eigen::Matrix2cd normal = Eigen::Matrix2cd::Zero();
    Eigen::Vector2cd right = Eigen::Vector2cd::Zero();
    double energy = 0;
    int n = 0;
    for (const ScreenTile& tile : tiles) {
      if (!tile.used) continue;
      std::complex<double> from_rgb = 0;
      for (std::size_t c = 0; c < 3; ++c) from_rgb += weights[c] * tile.fundamental[c][h];
      const Eigen::Vector2cd row(tile.fundamental[3][h],
                                 std::complex<double>(tile.amplitude[3][0]));
      normal += row.conjugate() * row.transpose();
      right += row.conjugate() * from_rgb;
      energy += std::norm(from_rgb);
      ++n;
    }
    if (n < 8) return {};
    const double spread = normal.determinant().real() / std::max(normal(1, 1).real(), 1e-30);
    if (!(spread > 1e-9)) return {};
    const Eigen::Vector2cd fit = normal.fullPivLu().solve(right);
    const double residual = std::max(energy - (right.adjoint() * fit)(0).real(), 1e-6 * energy);
    const double sd_cycles = std::sqrt(residual / (n - 2) / spread) / std::abs(fit(0)) / (2 * kPi);
    if (!(sd_cycles * registration.period_px[h] < 0.1)) return {};
    phase[h] = std::arg(fit(0)) / (2 * kPi);
  }
  // RGB shows at p what infrared shows at p + shift: a phase of +f . shift.
  const Vec2 f_u = registration.lattice_cy_per_px[0], f_v = registration.lattice_cy_per_px[1];
  const Vec2 shift = Mat2{f_u.x, f_u.y, f_v.x, f_v.y}.inverse() * Vec2{phase[0], phase[1]};
  return norm(shift) < 1 ? shift : Vec2{};
}

// The blur of one channel in one tile alone; sd 0 when the tile does not tell.
BlurSample tile_blur(const ScreenTile& tile, std::size_t channel, const ElementModel& model,
                     double about_px) {
  const Amplitudes even = weighted_amplitudes(tile.amplitude[channel]),
                   odd = weighted_amplitudes(tile.odd[channel]);
  // What is not the pattern's shows in the odd amplitudes, and looks the same in the even ones.
  const double variance = odd.tail<kTileAmplitudes - 1>().squaredNorm() / (kTileAmplitudes - 1) +
                          tile.variance[channel] / tile.n_effective + 1e-12;
  const auto cost = [&](double sigma) {
    const Columns columns = model.columns(sigma);
    const Amplitudes rest = even - columns * columns.householderQr().solve(even);
    return rest.squaredNorm() / variance;
  };
  double low = std::max(kLeastSigmaPx, about_px / 2.5),
         high = std::min(kMostSigmaPx, about_px * 2.5);
  constexpr int kSteps = 12;
  double best = 1e300, at = about_px;
  const double step = std::log(high / low) / kSteps;
  for (int i = 0; i <= kSteps; ++i) {
    const double sigma = low * std::exp(i * step), value = cost(sigma);
    if (value < best) {
      best = value;
      at = sigma;
    }
  }
  low = at * std::exp(-step);
  high = at * std::exp(step);
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 14; ++i) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    (cost(a) < cost(b) ? high : low) = cost(a) < cost(b) ? b : a;
  }
  at = 0.5 * (low + high);
  constexpr double kStep = 0.02;
  const double curvature = (cost(at + kStep) - 2 * cost(at) + cost(at - kStep)) / (kStep * kStep);
  BlurSample sample;
  if (!(curvature > 0)) return sample;
  // A model that does not fit is to be trusted less.
  const double misfit = std::max(1.0, cost(at) / (kTileAmplitudes - 4));
  const double sd = std::sqrt(2 * misfit / curvature);
  if (!(sd < 0.2 * about_px)) return sample;
  sample.variance_px2 = at * at;
  // Steps of the search bound what a perfect tile can tell.
  sample.sd = 2 * at * std::hypot(sd, 0.001);
  return sample;
}

// Blur by place. The widths are those of the whole picture.
void fit_field(const MeasuredTiles& measured, const ElementModel& model, std::size_t n_channels,
               Vec2 frame_px, Sharpness& result) {
  SharpnessReport& report = result.report;
  std::array<std::vector<BlurSample>, 4> samples;
  const auto n = measured.tiles.size();
  std::vector<std::array<BlurSample, 4>> found(n);
  parallel_for(static_cast<int>(n), [&](int i) {
    const auto t = static_cast<std::size_t>(i);
    if (!measured.tiles[t].used) return;
    for (std::size_t c = 0; c < n_channels; ++c) {
      found[t][c] = tile_blur(measured.tiles[t], c, model, report.sigma_px[c]);
      found[t][c].at_px = measured.middles[t];
    }
  });
  for (const auto& tile : found) {
    for (std::size_t c = 0; c < n_channels; ++c) {
      if (tile[c].sd > 0) samples[c].push_back(tile[c]);
    }
  }
  for (std::size_t c = 0; c < n_channels; ++c) {
    BlurSurface& surface = result.field[c];
    surface = BlurSurface(report.sigma_px[c]);
    if (c < 3 && samples[c].size() >= 6) {
      const BlurSurface own =
          fit_blur_surface(samples[c], frame_px, BlurSurface::kMostDegree, nullptr);
      // A constant is known better from all amplitudes together.
      if (own.degree() > 0) surface = own;
    }
  }
  if (n_channels == 4) {
    const BlurSurface rgb =
        BlurSurface::mixed(BlurSurface::mixed(result.field[0], 1.0 / 3, result.field[1], 1.0 / 3),
                           1, result.field[2], 1.0 / 3);
    if (rgb.degree() > 0) {
      // Infrared that shows too little by place has the shape of RGB, and its own size.
      double of_rgb = 0;
      for (std::size_t c = 0; c < 3; ++c) of_rgb += report.sigma_px[c] * report.sigma_px[c] / 3;
      const double scale = report.sigma_px[3] * report.sigma_px[3] / of_rgb;
      result.field[3] = samples[3].size() >= 6
                            ? fit_blur_surface(samples[3], frame_px, 2, &rgb)
                            : BlurSurface::mixed(rgb, scale, BlurSurface(report.sigma_px[3]), 0);
    }
  }
  for (std::size_t c = 0; c < n_channels; ++c) {
    report.sigma_range_px[c] = result.field[c].range_px();
    report.field_degree[c] = result.field[c].degree();
  }
}

// Noise and grain of a pixel's silver over the light there, in the calmest places.
double calmest_noise(const std::vector<ScreenTile>& tiles) {
  std::vector<double> ratio;
  for (const ScreenTile& tile : tiles) {
    const double mean = tile.amplitude[3][0];
    if (tile.used && mean > 0) ratio.push_back(std::sqrt(tile.variance[3]) / mean);
  }
  if (ratio.empty()) return Sharpness{}.noise_ratio;
  const auto calm = ratio.begin() + static_cast<std::ptrdiff_t>(ratio.size() / 10);
  std::nth_element(ratio.begin(), calm, ratio.end());
  return *calm;
}

// Noise of a pixel's silver in the tiles that are darker than a hundredth of clear film: the
// median, so that dust there does not count.
double noise_of_dark(const std::vector<ScreenTile>& tiles, double black_level, double light) {
  std::vector<double> sd;
  for (const ScreenTile& tile : tiles) {
    if ((tile.plain_mean - black_level) / light <= BlankBlocks::kMostMean)
      sd.push_back(tile.plain_noise / light);
  }
  if (sd.empty()) return 0;
  const auto middle = sd.begin() + static_cast<std::ptrdiff_t>(sd.size() / 2);
  std::nth_element(sd.begin(), middle, sd.end());
  return *middle;
}

// Whether the line (red) differs, beside green, from what it is beside blue, more than this model
// of the réseau allows: the mean over the picture of that alternation over the light, less its own
// error.
double line_alternation(const std::vector<ScreenTile>& tiles, const ElementModel& model,
                        const Mat2& linear, const ScreenPattern& pattern, int line_color,
                        double sigma_px) {
  using Modes = Eigen::Matrix<double, kTileAmplitudes, 4>;
  Modes modes;
  modes.leftCols<3>() = model.columns(sigma_px);
  modes(0, 3) =
      0.5 * (pattern.fourier(line_color, -1, 0) + pattern.fourier(line_color, 1, 0)).real();
  const Mat2 t = linear.transposed();
  for (int i = 1; i < kTileAmplitudes; ++i) {
    const HarmonicIndex h = kTileHarmonics[static_cast<std::size_t>(i - 1)];
    const Vec2 f = t * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
    const double otf =
        std::exp(-2 * std::numbers::pi * std::numbers::pi * sigma_px * sigma_px * dot(f, f));
    modes(i, 3) =
        std::numbers::sqrt2 * otf * 0.5 *
        (pattern.fourier(line_color, h.u - 1, h.v) + pattern.fourier(line_color, h.u + 1, h.v))
            .real();
  }
  const Eigen::HouseholderQR<Modes> qr(modes);
  double sum = 0, squares = 0, weights = 0, squared_weights = 0;
  for (const ScreenTile& tile : tiles) {
    const double mean = tile.amplitude[3][0];
    if (!tile.used || !(mean > 0)) continue;
    const Eigen::Vector4d light = qr.solve(weighted_amplitudes(tile.amplitude[3]));
    const double weight = 1 / (tile.variance[3] / (mean * mean) + 1e-4);
    sum += weight * light(3) / mean;
    squares += weight * light(3) * light(3) / (mean * mean);
    weights += weight;
    squared_weights += weight * weight;
  }
  if (!(weights > 0)) return 0;
  const double mean = sum / weights, spread = std::max(squares / weights - mean * mean, 0.0);
  return std::sqrt(std::max(mean * mean - 4 * spread * squared_weights / (weights * weights), 0.0));
}

}  // namespace

Sharpness measure_sharpness(const LineSource& source, const Registration& registration,
                            const ToneCurves& tone, double black_level, double light,
                            const std::stop_token& stop) {
  Sharpness result;
  const bool infrared = source.format().plane_of(Channel::kInfrared) >= 0;
  const std::size_t n_channels = infrared ? 4 : 3;
  result.response = registration.response;
  result.silver_from_rgb = registration.silver_from_rgb;
  for (std::size_t c = 0; c < n_channels; ++c) {
    result.report.sigma_px[c] = kDefaultSigmaPx;
    result.report.sigma_sd_px[c] = 0.3;
    result.report.origin[c] = "default";
  }
  if (!infrared) result.report.origin[3] = "absent";
  for (std::size_t c = 0; c < n_channels; ++c) {
    result.field[c] = BlurSurface(kDefaultSigmaPx);
    result.report.sigma_range_px[c] = {kDefaultSigmaPx, kDefaultSigmaPx};
  }
  result.printed = printed_screen(registration.screen);
  if (result.printed.lines) result.report.widths = result.printed.usual;

  const MeasuredTiles measured = measure_tiles(source, registration, tone, stop);
  const std::vector<ScreenTile>& tiles = measured.tiles;
  if (stop.stop_requested()) return result;
  result.dark_noise = noise_of_dark(tiles, black_level, light);
  if (std::none_of(tiles.begin(), tiles.end(), [](const ScreenTile& t) { return t.used; }))
    return result;
  result.noise_ratio = calmest_noise(tiles);
  const Mat2 linear{registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                    registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y};
  const SharpnessFit fit = fit_sharpness(result.printed, linear, tiles, n_channels);
  const PrintedScreen& printed = result.printed = fit.printed;
  double pooled = 0, pooled_weight = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    pooled += fit.sigma[c] / (fit.sd[c] * fit.sd[c]);
    pooled_weight += 1 / (fit.sd[c] * fit.sd[c]);
  }
  pooled /= pooled_weight;
  for (std::size_t c = 0; c < n_channels; ++c) {
    const bool own = fit.sd[c] < kMeasuredSdPx;
    const bool others = 1 / std::sqrt(pooled_weight) < kMeasuredSdPx;
    if (!own && !others) continue;
    result.report.origin[c] = own ? "measured" : "pooled";
    result.report.sigma_px[c] = own ? fit.sigma[c] : (c == 3 ? kInfraredSofter : 1.0) * pooled;
    result.report.sigma_sd_px[c] = fit.sd[c];
  }
  if (printed.lines) result.report.widths = fit.widths;
  const ScreenPattern pattern = printed.pattern(fit.widths);
  const ElementModel model(linear, pattern);
  fit_field(
      measured, model, n_channels,
      {static_cast<double>(source.format().width_px), static_cast<double>(source.committed())},
      result);
  if (printed.lines) {
    result.line_alternation = line_alternation(tiles, model, linear, pattern, printed.colors[0],
                                               result.report.sigma_px[infrared ? 3 : 1]);
  }
  result.response = fit_response(tiles, model, result.report.sigma_px, infrared);
  if (!infrared) {
    scale_to_clear(source, registration, tone, pattern, stop, result.response);
  }
  std::array<double, 3> weights{};
  if (silver_weights(result.response, weights)) result.silver_from_rgb = weights;
  if (infrared)
    result.report.infrared_shift_px = infrared_shift(tiles, result.silver_from_rgb, registration);
  return result;
}

}  // namespace reseau
