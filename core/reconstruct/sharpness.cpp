#include "core/reconstruct/sharpness.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "core/reconstruct/blank_blocks.h"
#include "core/reconstruct/channel_offsets.h"
#include "core/reconstruct/clear_elements.h"
#include "core/reconstruct/measure_tiles.h"
#include "core/reconstruct/sharpness_fit.h"
#include "core/reconstruct/tile_blur.h"
#include "core/screen/element_model.h"
#include "core/screen/lattice_search.h"
#include "core/screen/screen_pattern.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDefaultSigmaPx = 0.7;
// A film is not always as well in focus as the target was.
constexpr double kFocusSdPx = 0.15;
// Discs of defocus are a lens's, and a lens loses light to diffraction besides, which no scan
// shows: at f/4 to f/9 and 4000 dpi some 4 to 10 % goes farther than a period.
constexpr double kLensFarShare = 0.05;
constexpr double kMeasuredSdPx = 0.1;  // surer than this, or it is not called measured
using Columns = ElementModel::Columns;

// Light of each element in one channel of a tile (intensity x response), by least squares.
Eigen::Vector3d element_light(const ScreenTile& tile, std::size_t channel, const Columns& a) {
  return a.householderQr().solve(weighted_amplitudes(tile.amplitude[channel]));
}

// Response of each channel to each clear element: with infrared, the light in R, G, B regressed on
// the silver; without, the direction of each element's light is known and its size is not, so the
// brightest tiles count as clear.
Response fit_response(const std::vector<ScreenTile>& tiles, const ElementModel& model,
                      BlurShape shape, const std::array<double, 4>& far_share,
                      const std::array<double, 4>& sigma_px, bool infrared) {
  std::array<Columns, 4> columns;
  for (std::size_t c = 0; c < 4; ++c) {
    shape.far_share = far_share[c];
    columns[c] = model.columns(sigma_px[c] > 0 ? sigma_px[c] : kDefaultSigmaPx, shape);
  }
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

struct ChannelShift {
  Vec2 px;
  std::optional<Vec2> sd_px;  // none where it is not told
};

// Where a detail of RGB at p is found in infrared: p + shift [px]. Zero when the picture does not
// tell it to a tenth of a pixel.
ChannelShift infrared_shift(const std::vector<ScreenTile>& tiles,
                            const std::array<double, 3>& weights,
                            const Registration& registration) {
  std::array<double, 2> phase{}, variance{};
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
    variance[h] = 0.5 * sd_cycles * sd_cycles;  // half of a complex error turns the phase
  }
  // RGB shows at p what infrared shows at p + shift: a phase of +f . shift.
  const Vec2 f_u = registration.lattice_cy_per_px[0], f_v = registration.lattice_cy_per_px[1];
  const Mat2 px_per_cycle = Mat2{f_u.x, f_u.y, f_v.x, f_v.y}.inverse();
  const Vec2 shift = px_per_cycle * Vec2{phase[0], phase[1]};
  if (!(norm(shift) < 1)) return {};
  const auto sd = [&](double by_u, double by_v) {
    return std::sqrt(by_u * by_u * variance[0] + by_v * by_v * variance[1]);
  };
  return {shift, Vec2{sd(px_per_cycle.a, px_per_cycle.b), sd(px_per_cycle.c, px_per_cycle.d)}};
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
                        const BlurShape& shape, double sigma_px) {
  using Modes = Eigen::Matrix<double, kTileAmplitudes, 4>;
  Modes modes;
  modes.leftCols<3>() = model.columns(sigma_px, shape);
  modes(0, 3) =
      0.5 * (pattern.fourier(line_color, -1, 0) + pattern.fourier(line_color, 1, 0)).real();
  const Mat2 t = linear.transposed();
  for (int i = 1; i < kTileAmplitudes; ++i) {
    const HarmonicIndex h = kTileHarmonics[static_cast<std::size_t>(i - 1)];
    const Vec2 f = t * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
    const double otf = shape.transfer(f, sigma_px);
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

std::vector<BlurPlace> places_of(const BlurSurface& surface, Vec2 frame_px) {
  constexpr int kPlaces = 5;
  std::vector<BlurPlace> places;
  for (int j = 0; j < kPlaces; ++j) {
    for (int i = 0; i < kPlaces; ++i) {
      const Vec2 p{(i + 0.5) / kPlaces * frame_px.x, (j + 0.5) / kPlaces * frame_px.y};
      places.push_back({p, surface.sigma_px(p), surface.sd_px(p)});
    }
  }
  return places;
}

struct FoundBlur {
  SharpnessFit fit;
  BlurField field;
};

// A frame whose blur is alike to this everywhere is fitted as one.
constexpr double kSteadyPx = 0.03;
// Only a change like this shows the shape of what changes; no scanner is sharper than this in
// focus.
constexpr double kLeastDriftPx = 0.3, kLeastInFocusPx = 0.3;
// Fewer units of chi-squared per tile and channel do not make a Gaussian a disc.
constexpr double kDiscGain = 0.5;

// Widths, blurs and how they change; the fit is repeated under what it found where the blur is not
// the same everywhere, because a mean of blurs is not a blur.
FoundBlur find_blur(const MeasuredTiles& measured, SharpnessTask task, Vec2 frame_px) {
  FoundBlur found{fit_sharpness(task, measured.tiles), {}};
  const auto field_under = [&](const BlurShape& shape) {
    const ElementModel model(task.linear, found.fit.printed.pattern(found.fit.widths));
    return fit_blur_field(measured, BlurTable(model, shape), found.fit.sigma, task.n_channels,
                          frame_px);
  };
  found.field = field_under(found.fit.shape);
  double least = 1e30, most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::array<double, 2> range = found.field.surface[c].range_px();
    least = std::min(least, range[0]);
    most = std::max(most, range[1]);
  }
  if (most - least < kSteadyPx) return found;
  const auto n_used =
      static_cast<double>(std::count_if(measured.tiles.begin(), measured.tiles.end(),
                                        [](const ScreenTile& tile) { return tile.used; }));
  for (int round = 0; round < 2; ++round) {
    double best = found.field.misfit - (round == 0 ? 3 * kDiscGain * n_used : 0);
    BlurShape shape = found.fit.shape;
    for (double in_focus_px = kLeastInFocusPx; most - least > kLeastDriftPx && in_focus_px < most;
         in_focus_px *= 1.15) {
      BlurShape trial = found.fit.shape;
      trial.in_focus_px = in_focus_px;
      BlurField field = field_under(trial);

      if (field.misfit < best) {
        best = field.misfit;
        shape = trial;
        found.field = std::move(field);
      }
    }
    task.printed = found.fit.printed;
    task.shape = shape;
    std::array<BlurSurface, 4> surface = found.field.surface;
    const std::array<double, 4> about = found.fit.sigma;
    task.relative_blur = [&](std::size_t tile, std::size_t channel) {
      return surface[channel].sigma_px(measured.middles[tile]) / about[channel];
    };
    found.fit = fit_sharpness(task, measured.tiles);
    found.field = field_under(found.fit.shape);
  }
  return found;
}

}  // namespace

Sharpness measure_sharpness(const LineSource& source, const Registration& registration,
                            const ToneCurves& tone, const UnitSharpness& unit, double black_level,
                            double light, const std::stop_token& stop) {
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
  const Mat2 linear{registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                    registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y};
  const Vec2 frame_px{static_cast<double>(source.format().width_px),
                      static_cast<double>(source.committed())};
  std::array<std::optional<BlurSurface>, 4> of_frame;  // as calibration has it
  SharpnessTask task;
  task.linear = linear;
  task.n_channels = n_channels;
  for (std::size_t c = 0; c < n_channels; ++c) {
    const auto of_unit = result.report.of_unit[c] = unit_blur(unit.transfer[c], linear);
    if (!of_unit) continue;
    result.far_share[c] = of_unit->far_share;
    result.field[c] = BlurSurface(of_unit->sigma_px);
    result.report.origin[c] = "profile";
    result.report.sigma_px[c] = of_unit->sigma_px;
    result.report.sigma_sd_px[c] = task.prior.sd_px[c] = std::hypot(of_unit->sd_px, kFocusSdPx);
    result.report.sigma_range_px[c] = {of_unit->sigma_px, of_unit->sigma_px};
    task.prior.sigma_px[c] = of_unit->sigma_px;
    if (c == 3) task.prior.infrared = true;
    if (!unit.field[c]) continue;
    of_frame[c] = unit_surface(*of_unit, *unit.field[c], frame_px);
    if (!of_frame[c]) continue;
    result.field[c] = *of_frame[c];
    result.report.sigma_range_px[c] = of_frame[c]->range_px();
    result.report.field_degree[c] = of_frame[c]->degree();
  }
  result.printed = task.printed = printed_screen(registration.screen);
  if (result.printed.lines) result.report.widths = result.printed.usual;

  const MeasuredTiles measured = measure_tiles(source, registration, tone, stop);
  const std::vector<ScreenTile>& tiles = measured.tiles;
  if (stop.stop_requested()) return result;
  result.dark_noise = noise_of_dark(tiles, black_level, light);
  if (std::none_of(tiles.begin(), tiles.end(), [](const ScreenTile& t) { return t.used; }))
    return result;
  result.noise_ratio = calmest_noise(tiles);
  FoundBlur found = find_blur(measured, task, frame_px);
  const SharpnessFit& fit = found.fit;
  const PrintedScreen& printed = result.printed = fit.printed;
  double pooled = 0, pooled_weight = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    pooled += fit.sigma[c] / (fit.sd[c] * fit.sd[c]);
    pooled_weight += 1 / (fit.sd[c] * fit.sd[c]);
  }
  pooled /= pooled_weight;
  for (std::size_t c = 0; c < n_channels; ++c) {
    const bool own = fit.sd[c] < kMeasuredSdPx;
    // What calibration says of the channel is worth more than what its neighbours show.
    const bool others = !result.report.of_unit[c] && 1 / std::sqrt(pooled_weight) < kMeasuredSdPx;
    if (!own && !others) continue;
    result.report.origin[c] = own ? "measured" : "pooled";
    result.report.sigma_px[c] = own ? fit.sigma[c] : (c == 3 ? kInfraredSofter : 1.0) * pooled;
    result.report.sigma_sd_px[c] = fit.sd[c];
  }
  result.shape = fit.shape;
  if (std::isfinite(fit.shape.in_focus_px)) {
    for (std::size_t c = 0; c < n_channels; ++c) {
      if (!result.report.of_unit[c]) result.far_share[c] = kLensFarShare;
    }
  }
  result.report.in_focus_px = fit.shape.in_focus_px;
  result.report.stretch = fit.shape.stretch;
  result.report.stretch_sd = fit.stretch_sd;
  if (printed.lines) result.report.widths = fit.widths;
  const ScreenPattern pattern = printed.pattern(fit.widths);
  const ElementModel model(linear, pattern);
  for (std::size_t c = 0; c < n_channels; ++c) {
    // What of calibration the scan itself does not tell stays, and so does a constant.
    if (found.field.surface[c].degree() > 0) {
      result.field[c] = found.field.surface[c];
    } else if (!of_frame[c] || result.report.origin[c] != "profile") {
      result.field[c] = BlurSurface(result.report.sigma_px[c]);
    }
    result.report.sigma_range_px[c] = result.field[c].range_px();
    result.report.field_degree[c] = result.field[c].degree();
    if (result.field[c].degree() > 0) result.report.field[c] = places_of(result.field[c], frame_px);
  }
  if (printed.lines) {
    result.line_alternation = line_alternation(tiles, model, linear, pattern, printed.colors[0],
                                               fit.shape, result.report.sigma_px[infrared ? 3 : 1]);
  }
  result.response =
      fit_response(tiles, model, fit.shape, result.far_share, result.report.sigma_px, infrared);
  if (!infrared) {
    scale_to_clear(source, registration, tone, pattern, stop, result.response);
  }
  std::array<double, 3> weights{};
  if (silver_weights(result.response, weights)) result.silver_from_rgb = weights;
  result.report.channel_offsets =
      channel_offsets(measured, registration, pattern, infrared, frame_px);
  if (infrared) {
    const ChannelShift shift = infrared_shift(tiles, result.silver_from_rgb, registration);
    result.report.infrared_shift_px = shift.px;
    result.report.infrared_shift_sd_px = shift.sd_px;
  }
  return result;
}

}  // namespace reseau
