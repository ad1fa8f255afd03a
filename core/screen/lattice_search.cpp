#include "core/screen/lattice_search.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <unsupported/Eigen/FFT>

#include "core/base/parallel.h"

namespace reseau {
namespace {

using Complex = std::complex<float>;
// A peak sums 5 x 5 bins of two spectra, 72 on average where there is only noise.
constexpr double kNoisePower = 110;
constexpr double kLowestFrequency = 0.028;  // periods up to 35 px

// Mean silver, of full scale, below which a tile is left alone: black film shows 0.003 and noise.
constexpr double kBlack = 0.004;

struct Tile {
  int x = 0, y = 0;
  double light = 0;
};

// Power of the two colour signals of a tile: red against the others, green against blue. Both are
// ratios to the silver, so that the picture itself drops out.
struct Spectra {
  int size = 0;
  std::vector<float> red;         // |F(R' - (G' + B') / 2)|^2, [ky][kx]
  std::vector<float> green_blue;  // |F(G' - B')|^2

  [[nodiscard]] float at(const std::vector<float>& power, int kx, int ky) const {
    const int mask = size - 1;
    return power[static_cast<std::size_t>(ky & mask) * static_cast<std::size_t>(size) +
                 static_cast<std::size_t>(kx & mask)];
  }
};

std::vector<Tile> choose_tiles(const LinearRows& rows, int size, int most_tiles) {
  const int nx = std::max(1, (rows.width_px - size) / (size / 2) + 1);
  const int ny = std::max(1, (rows.n - size) / (size / 2) + 1);
  std::vector<Tile> tiles;
  // At most a few hundred candidates however large the frame is.
  const int step =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(nx * static_cast<double>(ny) / 400))));
  for (int j = 0; j < ny; j += step) {
    for (int i = 0; i < nx; i += step) {
      Tile tile{std::min(i * size / 2, rows.width_px - size),
                std::min(j * size / 2, rows.n - size)};
      for (int y = 0; y < size; y += 8) {
        const float* s = rows.row(3, tile.y + y) + tile.x;
        for (int x = 0; x < size; x += 4) tile.light += std::min(static_cast<double>(s[x]), 0.3);
      }
      tiles.push_back(tile);
    }
  }
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const Tile& a, const Tile& b) { return a.light > b.light; });
  // Bright ones first, but spread: a scene may be one saturated colour in one corner.
  std::vector<Tile> chosen;
  for (const double distance : {1.0, 0.5}) {
    for (const Tile& tile : tiles) {
      if (static_cast<int>(chosen.size()) >= (size > kSmallestTilePx ? most_tiles : 3 * most_tiles))
        break;
      const bool near = std::any_of(chosen.begin(), chosen.end(), [&](const Tile& other) {
        return std::abs(tile.x - other.x) < distance * size &&
               std::abs(tile.y - other.y) < distance * size;
      });
      if (!near && tile.light > 0) chosen.push_back(tile);
    }
  }
  return chosen;
}

// Linear samples over silver, relative to their mean in the tile, Hann-windowed; where the silver
// is dark the ratio is only noise and is faded out.
bool tile_signals(const LinearRows& rows, const Tile& tile, int size, std::vector<Complex>& out) {
  double sum_s = 0, sum_ss = 0;
  std::array<double, 3> sum_cs{};
  for (int y = 0; y < size; ++y) {
    const float* s = rows.row(3, tile.y + y) + tile.x;
    for (int x = 0; x < size; ++x) {
      sum_s += static_cast<double>(s[x]);
      sum_ss += static_cast<double>(s[x]) * static_cast<double>(s[x]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const float* value = rows.row(static_cast<int>(c), tile.y + y) + tile.x;
      for (int x = 0; x < size; ++x)
        sum_cs[c] += static_cast<double>(s[x]) * static_cast<double>(value[x]);
    }
  }
  if (!(sum_s > 0)) return false;
  const double mean_s = sum_s / (static_cast<double>(size) * size);
  if (mean_s < kBlack) return false;
  std::array<double, 3> ratio{};
  for (std::size_t c = 0; c < 3; ++c) {
    ratio[c] = sum_cs[c] / sum_ss;
    if (!(ratio[c] > 1e-4)) return false;
  }
  const auto dark = static_cast<float>(0.25 * mean_s);
  out.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  double weight_sum = 0;
  std::complex<double> mean = 0;
  std::vector<float> weights(out.size());
  for (int y = 0; y < size; ++y) {
    const double wy = std::sin(std::numbers::pi * (y + 0.5) / size);
    const float* row[4];
    for (int c = 0; c < 4; ++c) row[c] = rows.row(c, tile.y + y) + tile.x;
    for (int x = 0; x < size; ++x) {
      const double wx = std::sin(std::numbers::pi * (x + 0.5) / size);
      const float s = row[3][x];
      const float inverse = s > 0 ? s / (s * s + dark * dark) : 0.0F;
      const float r = row[0][x] * inverse / static_cast<float>(ratio[0]);
      const float g = row[1][x] * inverse / static_cast<float>(ratio[1]);
      const float b = row[2][x] * inverse / static_cast<float>(ratio[2]);
      const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                             static_cast<std::size_t>(x);
      weights[at] = static_cast<float>(wx * wx * wy * wy);
      out[at] = {std::clamp(r - 0.5F * (g + b), -4.0F, 4.0F), std::clamp(g - b, -4.0F, 4.0F)};
      mean += static_cast<double>(weights[at]) * std::complex<double>(out[at]);
      weight_sum += static_cast<double>(weights[at]);
    }
  }
  const Complex center(mean / weight_sum);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (out[i] - center) * weights[i];
  return true;
}

void fft_2d(std::vector<Complex>& data, int size) {
  Eigen::FFT<float> fft;
  const auto n = static_cast<std::size_t>(size);
  std::vector<Complex> in(n), out(n);
  for (std::size_t y = 0; y < n; ++y) {
    std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(y * n), n, in.begin());
    fft.fwd(out, in);
    std::copy_n(out.begin(), n, data.begin() + static_cast<std::ptrdiff_t>(y * n));
  }
  for (std::size_t x = 0; x < n; ++x) {
    for (std::size_t y = 0; y < n; ++y) in[y] = data[y * n + x];
    fft.fwd(out, in);
    for (std::size_t y = 0; y < n; ++y) data[y * n + x] = out[y];
  }
}

float median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Two real signals ride in one complex transform; symmetry takes them apart.
Spectra tile_spectra(std::vector<Complex>& signal, int size) {
  fft_2d(signal, size);
  Spectra spectra;
  spectra.size = size;
  spectra.red.resize(signal.size());
  spectra.green_blue.resize(signal.size());
  const int mask = size - 1;
  for (int ky = 0; ky < size; ++ky) {
    for (int kx = 0; kx < size; ++kx) {
      const auto n = static_cast<std::size_t>(size);
      const Complex plus = signal[static_cast<std::size_t>(ky) * n + static_cast<std::size_t>(kx)];
      const Complex minus = std::conj(
          signal[static_cast<std::size_t>(-ky & mask) * n + static_cast<std::size_t>(-kx & mask)]);
      const std::size_t at = static_cast<std::size_t>(ky) * n + static_cast<std::size_t>(kx);
      spectra.red[at] = std::norm(0.5F * (plus + minus));
      spectra.green_blue[at] = std::norm(0.5F * (plus - minus));
    }
  }
  // Each signal in units of its own noise floor, so that no tile shouts down the others.
  for (auto* power : {&spectra.red, &spectra.green_blue}) {
    const float floor = std::max(median(*power), 1e-20F);
    for (float& value : *power) value /= floor;
  }
  return spectra;
}

struct Peak {
  Vec2 frequency;
  double red = 0, green_blue = 0;
  [[nodiscard]] double power() const { return red + green_blue; }
};

// One tile in full light must not outweigh the rest; smooth, so that a peak stays one peak.
float limited(float power) {
  constexpr float kMost = 3000;
  return kMost * power / (kMost + power);
}

// Local maxima of the sum spectrum in the upper half-plane, strongest first.
std::vector<Peak> find_peaks(const Spectra& s, std::size_t n_peaks) {
  std::vector<Peak> peaks;
  const int half = s.size / 2;
  const auto sum = [&](int kx, int ky) { return s.at(s.red, kx, ky) + s.at(s.green_blue, kx, ky); };
  for (int ky = 0; ky <= half; ++ky) {
    for (int kx = -half; kx < half; ++kx) {
      if (ky == 0 && kx <= 0) continue;
      const double f = std::hypot(kx, ky) / s.size;
      if (f < kLowestFrequency) continue;
      const float value = sum(kx, ky);
      if (value < 6) continue;
      bool is_peak = true;
      for (int j = -2; j <= 2 && is_peak; ++j) {
        for (int i = -2; i <= 2 && is_peak; ++i) {
          if ((i != 0 || j != 0) && sum(kx + i, ky + j) > value) is_peak = false;
        }
      }
      if (!is_peak) continue;
      // The Hann window spreads a line over three bins: power-weighted centre, summed power.
      Peak peak;
      double weight = 0, cx = 0, cy = 0;
      for (int j = -2; j <= 2; ++j) {
        for (int i = -2; i <= 2; ++i) {
          const auto p = static_cast<double>(sum(kx + i, ky + j));
          weight += p;
          cx += p * i;
          cy += p * j;
          peak.red += static_cast<double>(s.at(s.red, kx + i, ky + j));
          peak.green_blue += static_cast<double>(s.at(s.green_blue, kx + i, ky + j));
        }
      }
      peak.frequency = {(kx + cx / weight) / s.size, (ky + cy / weight) / s.size};
      peaks.push_back(peak);
    }
  }
  std::stable_sort(peaks.begin(), peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.power() > b.power(); });
  // Film that bends spreads a line over several bins: keep the strongest of a group.
  std::vector<Peak> apart;
  for (const Peak& peak : peaks) {
    const bool near = std::any_of(apart.begin(), apart.end(), [&](const Peak& other) {
      return std::min(norm(peak.frequency - other.frequency),
                      norm(peak.frequency + other.frequency)) *
                 s.size <
             5;
    });
    if (!near) apart.push_back(peak);
    if (apart.size() == n_peaks) break;
  }
  return apart;
}

// The strongest peak that no small harmonic of the lattice explains, over the lattice's own power.
double foreign_power(const std::vector<Peak>& peaks, const Carriers& lattice, double own,
                     int size) {
  for (const Peak& peak : peaks) {  // strongest first
    bool harmonic = false;
    for (int v = -3; v <= 3; ++v) {
      for (int u = -3; u <= 3; ++u) {
        const Vec2 off = peak.frequency -
                         (static_cast<double>(u) * lattice.u + static_cast<double>(v) * lattice.v);
        // Beyond the sampling a harmonic comes back from the other side.
        const Vec2 folded{off.x - std::round(off.x), off.y - std::round(off.y)};
        harmonic = harmonic || norm(folded) * size < 4;
      }
    }
    if (!harmonic) return peak.power() / std::max(own, 1e-9);
  }
  return 0;
}

Carriers right_handed(Vec2 u, Vec2 v) {
  return cross(u, v) < 0 ? Carriers{u, -1.0 * v} : Carriers{u, v};
}

bool plausible_geometry(Vec2 u, Vec2 v) {
  const double ratio = norm(u) / norm(v);
  const double sine = std::abs(cross(u, v)) / (norm(u) * norm(v));
  return ratio > 0.75 && ratio < 1.34 && sine > 0.95;
}

// Frequency of a line near f in the spectrum of one tile, to a small part of a bin.
Vec2 local_frequency(const Spectra& s, Vec2 f) {
  const auto power = [&](int kx, int ky) {
    return static_cast<double>(s.at(s.red, kx, ky) + s.at(s.green_blue, kx, ky));
  };
  const int kx = static_cast<int>(std::lround(f.x * s.size)),
            ky = static_cast<int>(std::lround(f.y * s.size));
  int x = kx, y = ky;
  for (int j = -2; j <= 2; ++j) {
    for (int i = -2; i <= 2; ++i) {
      if (power(kx + i, ky + j) > power(x, y)) {
        x = kx + i;
        y = ky + j;
      }
    }
  }
  // Hann: the amplitude ratio r of neighbours gives the offset (2 r - 1) / (1 + r).
  const auto offset = [&](int dx, int dy) {
    const double center = std::sqrt(power(x, y));
    const double before = std::sqrt(power(x - dx, y - dy)),
                 after = std::sqrt(power(x + dx, y + dy));
    const double r = std::max(before, after) / std::max(center, 1e-12);
    const double shift = std::clamp((2 * r - 1) / (1 + r), 0.0, 0.6);
    return after > before ? shift : -shift;
  };
  return {(x + offset(1, 0)) / s.size, (y + offset(0, 1)) / s.size};
}

}  // namespace

ColorSeries series_from_response(const Response& response, ScreenLayout layout, int special_color,
                                 const Carriers& carriers, double sigma_px) {
  const SiteSeries& sites = site_series(layout);
  const std::array<int, 3> colors = site_colors(layout, special_color);
  ColorSeries series;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double light = response[static_cast<std::size_t>(colors[k])][c];
      series.mean[c] += sites[k][0] * light;
      for (std::size_t i = 0; i < kSeries; ++i) {
        const HarmonicIndex h = kDifferences[i];
        static_assert(kDifferences[3].v == kTileHarmonics[3].v && kSeries == 4);
        const Vec2 f =
            static_cast<double>(h.u) * carriers.u + static_cast<double>(h.v) * carriers.v;
        series.harmonic[c][i] +=
            light * sites[k][i + 1] *
            std::exp(-2 * std::numbers::pi * std::numbers::pi * sigma_px * sigma_px * dot(f, f));
      }
    }
  }
  return series;
}

bool silver_weights(const Response& response, std::array<double, 3>& weights) {
  Eigen::Matrix3d p;  // rows: elements
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 3; ++c)
      p(k, c) = response[static_cast<std::size_t>(k)][static_cast<std::size_t>(c)];
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(p);
  if (!p.allFinite() || !(svd.singularValues()(2) > 0.02 * svd.singularValues()(0))) return false;
  const Eigen::Vector3d w = p.colPivHouseholderQr().solve(Eigen::Vector3d::Ones());
  if (!w.allFinite()) return false;
  for (int c = 0; c < 3; ++c) weights[static_cast<std::size_t>(c)] = w(c);
  return true;
}

LatticeSearch find_lattice(const LinearRows& rows, bool infrared, int largest_tile_px,
                           int most_tiles) {
  LatticeSearch result;
  int size = largest_tile_px;
  while (size > kSmallestTilePx && (size > rows.width_px || size > rows.n)) size /= 2;
  if (size > rows.width_px || size > rows.n) {
    result.reason = "The picture is too small: a réseau can be found from 64 x 64 pixels upwards.";
    return result;
  }
  const std::vector<Tile> tiles = choose_tiles(rows, size, most_tiles);
  Spectra total;
  total.size = size;
  total.red.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  total.green_blue.resize(total.red.size());
  std::vector<Spectra> of_tiles(tiles.size());
  parallel_for(static_cast<int>(tiles.size()), [&](int t) {
    const auto at = static_cast<std::size_t>(t);
    std::vector<Complex> signal;
    if (tile_signals(rows, tiles[at], size, signal)) of_tiles[at] = tile_spectra(signal, size);
  });
  std::vector<Tile> used;
  std::vector<Spectra> spectra;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    if (of_tiles[t].size == 0) continue;
    spectra.push_back(std::move(of_tiles[t]));
    used.push_back(tiles[t]);
    for (std::size_t i = 0; i < total.red.size(); ++i) {
      total.red[i] += limited(spectra.back().red[i]);
      total.green_blue[i] += limited(spectra.back().green_blue[i]);
    }
  }
  if (used.empty()) {
    result.dark = true;
    result.reason =
        "The picture is black or clipped everywhere: there is no light to see a réseau by.";
    return result;
  }
  for (auto* power : {&total.red, &total.green_blue}) {
    const float floor = std::max(median(*power), 1e-20F);
    for (float& value : *power) value /= floor;
  }
  const std::vector<Peak> peaks = find_peaks(total, 16);
  struct Candidate {
    Carriers carriers;
    double score;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    for (std::size_t j = i + 1; j < peaks.size(); ++j) {
      if (!plausible_geometry(peaks[i].frequency, peaks[j].frequency)) continue;
      const double score = std::sqrt(std::max(peaks[i].power() - kNoisePower, 0.0) *
                                     std::max(peaks[j].power() - kNoisePower, 0.0));
      if (score > 0)
        candidates.push_back({right_handed(peaks[i].frequency, peaks[j].frequency), score});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  if (candidates.size() > 6) candidates.resize(6);
  result.reason = "No réseau was found: no colour pattern repeats in two directions.";
  std::vector<std::optional<LatticeHypothesis>> hypotheses(candidates.size());
  parallel_for(static_cast<int>(candidates.size()), [&](int k) {
    const Candidate& candidate = candidates[static_cast<std::size_t>(k)];
    // The middle half of each tile, with the frequencies that this very tile shows.
    std::vector<TileCorner> corners;
    std::vector<Carriers> carriers;
    for (std::size_t t = 0; t < used.size(); ++t) {
      const Carriers own{local_frequency(spectra[t], candidate.carriers.u),
                         local_frequency(spectra[t], candidate.carriers.v)};
      if (!plausible_geometry(own.u, own.v)) continue;
      corners.push_back({used[t].x + size / 4, used[t].y + size / 4});
      carriers.push_back(own);
    }
    if (!corners.empty())
      hypotheses[static_cast<std::size_t>(k)] =
          judge_lattice(rows, corners, carriers, size / 2, infrared);
  });
  double best = 0;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (!hypotheses[k] || !(hypotheses[k]->explained > best)) continue;
    const Candidate& candidate = candidates[k];
    const LatticeHypothesis& judged = *hypotheses[k];
    best = judged.explained;
    result.found = judged.colors_fit;
    result.reason =
        judged.colors_fit
            ? ""
            : "No réseau was found: the periodic pattern does not have the colours of a screen "
              "that was made.";
    result.seed.layout = judged.layout;
    result.seed.special_color = judged.special_color;
    result.seed.explained = judged.explained;
    result.seed.other_explained = judged.other_explained;
    result.seed.carriers = judged.mean_carriers;
    result.seed.at_center = judged.carriers;
    result.seed.center_px = judged.center_px + Vec2{0, static_cast<double>(rows.first)};
    result.seed.screen_at_center = judged.screen_at_center;
    result.seed.response = judged.response;
    result.seed.sigma_px = judged.sigma_px;
    result.seed.foreign =
        foreign_power(peaks, candidate.carriers, candidate.score + kNoisePower, size);
    result.seed.confidence = -std::expm1(-candidate.score / 100);
  }
  return result;
}

}  // namespace reseau
