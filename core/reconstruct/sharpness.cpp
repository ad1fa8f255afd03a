#include "core/reconstruct/sharpness.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>
#include <tbb/parallel_for.h>

#include "core/reconstruct/screen_tile.h"
#include "core/screen/lattice_search.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_pattern.h"

namespace reseau {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDefaultSigmaPx = 0.7;
constexpr double kLeastSigmaPx = 0.2, kMostSigmaPx = 4.0;
constexpr int kTilesAcross = 14;
// The printed widths are not exactly those of the pattern: amplitudes are believed to this much of
// the mean, however little noise there is.
constexpr double kModelError = 0.004;

struct TilePlace {
  int x, y;
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

std::vector<ScreenTile> measure_tiles(const LineSource& source, const Registration& registration,
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
  tbb::parallel_for(std::size_t{0}, row_starts.size(), [&](std::size_t r) {
    if (stop.stop_requested()) return;
    LinearReader reader(source, tone);
    LinearRows rows;
    const std::size_t end = r + 1 < row_starts.size() ? row_starts[r + 1] : places.size();
    reader.read(places[row_starts[r]].y, size, rows);
    for (std::size_t i = row_starts[r]; i < end; ++i) {
      tiles[i] = measure_screen_tile(rows, places[i].x, size, registration.map);
    }
  });
  return tiles;
}

// The ideal amplitudes of the three elements under a Gaussian blur, as columns, weighed so that the
// squared length of a residual is its energy in the picture.
class BlurModel {
 public:
  using Columns = Eigen::Matrix<double, kTileAmplitudes, 3>;
  explicit BlurModel(const Mat2& linear) : linear_(linear) {}

  [[nodiscard]] Columns columns(double sigma_px) const {
    const ScreenPattern& pattern = ScreenPattern::dufaycolor();
    const Mat2 t = linear_.transposed();
    Columns a;
    for (int k = 0; k < 3; ++k) {
      a(0, k) = pattern.area(k);
      for (int i = 1; i < kTileAmplitudes; ++i) {
        const HarmonicIndex h = kTileHarmonics[static_cast<std::size_t>(i - 1)];
        const Vec2 f = t * Vec2{static_cast<double>(h.u), static_cast<double>(h.v)};
        a(i, k) = std::numbers::sqrt2 * pattern.fourier(k, h.u, h.v).real() *
                  std::exp(-2 * kPi * kPi * sigma_px * sigma_px * dot(f, f));
      }
    }
    return a;
  }

 private:
  Mat2 linear_;
};

using Amplitudes = Eigen::Matrix<double, kTileAmplitudes, 1>;
using Scatter = Eigen::Matrix<double, kTileAmplitudes, kTileAmplitudes>;

Amplitudes weighted_amplitudes(const ScreenTile& tile, std::size_t channel) {
  Amplitudes y;
  y(0) = tile.amplitude[channel][0];
  for (int i = 1; i < kTileAmplitudes; ++i) {
    y(i) = std::numbers::sqrt2 * tile.amplitude[channel][static_cast<std::size_t>(i)];
  }
  return y;
}

// Inverse variance of the weighted amplitudes of a tile: noise and detail, plus the model's own.
double tile_weight(const ScreenTile& tile, std::size_t channel) {
  const double mean = tile.amplitude[channel][0];
  return 1 / (tile.variance[channel] / tile.n_effective + kModelError * kModelError * mean * mean +
              1e-14);
}

struct SigmaFit {
  double sigma = kDefaultSigmaPx, sd = 1e3;
};

// Sum over tiles of y y^T / variance is all that a fit of one sigma needs: what the best three
// intensities leave is the trace of the residual projector with it.
SigmaFit fit_sigma(const Scatter& scatter, const BlurModel& model) {
  const auto cost = [&](double sigma) {
    const BlurModel::Columns a = model.columns(sigma);
    const Eigen::HouseholderQR<BlurModel::Columns> qr(a);
    const Scatter q = qr.householderQ();
    return (q.rightCols<kTileAmplitudes - 3>().transpose() * scatter *
            q.rightCols<kTileAmplitudes - 3>())
        .trace();
  };
  SigmaFit fit;
  double best = 1e300;
  for (double s = kLeastSigmaPx; s <= kMostSigmaPx; s *= 1.04) {
    const double value = cost(s);
    if (value < best) {
      best = value;
      fit.sigma = s;
    }
  }
  double low = std::max(fit.sigma / 1.04, kLeastSigmaPx),
         high = std::min(fit.sigma * 1.04, kMostSigmaPx);
  for (int i = 0; i < 40; ++i) {  // golden section
    const double a = high - 0.618034 * (high - low), b = low + 0.618034 * (high - low);
    if (cost(a) < cost(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  fit.sigma = 0.5 * (low + high);
  // Chi-squared rises by 1 at one standard deviation.
  const double step = 0.02;
  const double curvature =
      (cost(fit.sigma + step) + cost(fit.sigma - step) - 2 * cost(fit.sigma)) / (step * step);
  if (curvature > 0) fit.sd = std::sqrt(2 / curvature);
  return fit;
}

// Light of each element in one channel of a tile (intensity x response), by least squares.
Eigen::Vector3d element_light(const ScreenTile& tile, std::size_t channel,
                              const BlurModel::Columns& a) {
  return a.householderQr().solve(weighted_amplitudes(tile, channel));
}

// Response of each channel to each clear element: with infrared, the light in R, G, B regressed on
// the silver; without, the direction of each element's light is known and its size is not, so the
// brightest tiles count as clear.
Response fit_response(const std::vector<ScreenTile>& tiles, const BlurModel& model,
                      const std::array<double, 4>& sigma_px, bool infrared) {
  std::array<BlurModel::Columns, 4> columns;
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

// RGB alone cannot tell how clear the film is: the brightest answer of a clear element counts as
// full scale.
void scale_to_brightest(Response& response) {
  double brightest = 0;
  for (const auto& element : response) {
    for (const double value : element) brightest = std::max(brightest, value);
  }
  if (!(brightest > 0)) return;
  for (auto& element : response) {
    for (double& value : element) value /= brightest;
  }
}

}  // namespace

Sharpness measure_sharpness(const LineSource& source, const Registration& registration,
                            const ToneCurves& tone, const std::stop_token& stop) {
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

  const std::vector<ScreenTile> tiles = measure_tiles(source, registration, tone, stop);
  if (stop.stop_requested()) return result;
  const BlurModel model({registration.lattice_cy_per_px[0].x, registration.lattice_cy_per_px[0].y,
                         registration.lattice_cy_per_px[1].x, registration.lattice_cy_per_px[1].y});
  std::array<Scatter, 4> scatter;
  Scatter visible = Scatter::Zero();
  int n_used = 0;
  for (std::size_t c = 0; c < n_channels; ++c) {
    scatter[c].setZero();
    for (const ScreenTile& tile : tiles) {
      if (!tile.used) continue;
      const Amplitudes y = weighted_amplitudes(tile, c);
      scatter[c] += tile_weight(tile, c) * y * y.transpose();
      ++n_used;
    }
    if (c < 3) visible += scatter[c];
  }
  if (n_used == 0) return result;
  const SigmaFit pooled = fit_sigma(visible, model);
  for (std::size_t c = 0; c < n_channels; ++c) {
    const SigmaFit own = fit_sigma(scatter[c], model);
    const auto accept = [&](const SigmaFit& fit, const char* origin) {
      result.report.sigma_px[c] = fit.sigma;
      result.report.sigma_sd_px[c] = fit.sd;
      result.report.origin[c] = origin;
    };
    if (own.sd < 0.08 && own.sigma < 0.95 * kMostSigmaPx) {
      accept(own, "measured");
    } else if (pooled.sd < 0.1 && pooled.sigma < 0.95 * kMostSigmaPx) {
      accept(pooled, "pooled");
    }
  }
  result.response = fit_response(tiles, model, result.report.sigma_px, infrared);
  if (!infrared) scale_to_brightest(result.response);
  std::array<double, 3> weights{};
  if (silver_weights(result.response, weights)) result.silver_from_rgb = weights;
  if (infrared)
    result.infrared_shift_px = infrared_shift(tiles, result.silver_from_rgb, registration);
  return result;
}

}  // namespace reseau
