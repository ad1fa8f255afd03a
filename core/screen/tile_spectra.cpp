#include "core/screen/tile_spectra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include <unsupported/Eigen/FFT>

namespace reseau {
namespace {

using ComplexF = std::complex<float>;
constexpr int kSmallTilePx = 64;  // of which three times as many are looked at

// Mean silver, of full scale, below which a tile is left alone: black film shows 0.003 and noise.
constexpr double kBlack = 0.004;

// Linear samples over silver, relative to their mean in the tile, Hann-windowed; where the silver
// is dark the ratio is only noise and is faded out.
bool tile_signals(const LinearRows& rows, const SearchTile& tile, int size,
                  std::vector<ComplexF>& out) {
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
  const ComplexF center(mean / weight_sum);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (out[i] - center) * weights[i];
  return true;
}

void fft_2d(std::vector<ComplexF>& data, int size) {
  Eigen::FFT<float> fft;
  const auto n = static_cast<std::size_t>(size);
  std::vector<ComplexF> in(n), out(n);
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

float middle_of(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Two real signals ride in one complex transform; symmetry takes them apart.
Spectra tile_spectra(std::vector<ComplexF>& signal, int size) {
  fft_2d(signal, size);
  Spectra spectra;
  spectra.size = size;
  spectra.red.resize(signal.size());
  spectra.green_blue.resize(signal.size());
  const int mask = size - 1;
  for (int ky = 0; ky < size; ++ky) {
    for (int kx = 0; kx < size; ++kx) {
      const auto n = static_cast<std::size_t>(size);
      const ComplexF plus = signal[static_cast<std::size_t>(ky) * n + static_cast<std::size_t>(kx)];
      const ComplexF minus = std::conj(
          signal[static_cast<std::size_t>(-ky & mask) * n + static_cast<std::size_t>(-kx & mask)]);
      const std::size_t at = static_cast<std::size_t>(ky) * n + static_cast<std::size_t>(kx);
      spectra.red[at] = std::norm(0.5F * (plus + minus));
      spectra.green_blue[at] = std::norm(0.5F * (plus - minus));
    }
  }
  // Each signal in units of its own noise floor, so that no tile shouts down the others.
  for (auto* power : {&spectra.red, &spectra.green_blue}) {
    const float floor = std::max(middle_of(*power), 1e-20F);
    for (float& value : *power) value /= floor;
  }
  return spectra;
}

// One tile in full light must not outweigh the rest; smooth, so that a peak stays one peak.
float limited(float power) {
  constexpr float kMost = 3000;
  return kMost * power / (kMost + power);
}

}  // namespace

std::vector<SearchTile> choose_tiles(const LinearRows& rows, int size, int most_tiles) {
  const int nx = std::max(1, (rows.width_px - size) / (size / 2) + 1);
  const int ny = std::max(1, (rows.n - size) / (size / 2) + 1);
  std::vector<SearchTile> tiles;
  // At most a few hundred candidates however large the frame is.
  const int step =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(nx * static_cast<double>(ny) / 400))));
  for (int j = 0; j < ny; j += step) {
    for (int i = 0; i < nx; i += step) {
      SearchTile tile{std::min(i * size / 2, rows.width_px - size),
                      std::min(j * size / 2, rows.n - size)};
      for (int y = 0; y < size; y += 8) {
        const float* s = rows.row(3, tile.y + y) + tile.x;
        for (int x = 0; x < size; x += 4) tile.light += std::min(static_cast<double>(s[x]), 0.3);
      }
      tiles.push_back(tile);
    }
  }
  std::stable_sort(tiles.begin(), tiles.end(),
                   [](const SearchTile& a, const SearchTile& b) { return a.light > b.light; });
  // Bright ones first, but spread: a scene may be one saturated colour in one corner.
  std::vector<SearchTile> chosen;
  for (const double distance : {1.0, 0.5}) {
    for (const SearchTile& tile : tiles) {
      if (static_cast<int>(chosen.size()) >= (size > kSmallTilePx ? most_tiles : 3 * most_tiles))
        break;
      const bool near = std::any_of(chosen.begin(), chosen.end(), [&](const SearchTile& other) {
        return std::abs(tile.x - other.x) < distance * size &&
               std::abs(tile.y - other.y) < distance * size;
      });
      if (!near && tile.light > 0) chosen.push_back(tile);
    }
  }
  return chosen;
}

Spectra spectra_of(const LinearRows& rows, const SearchTile& tile, int size) {
  std::vector<ComplexF> signal;
  return tile_signals(rows, tile, size, signal) ? tile_spectra(signal, size) : Spectra{};
}

Spectra total_of(const std::vector<Spectra>& tiles, int size) {
  Spectra total;
  total.size = size;
  total.red.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  total.green_blue.resize(total.red.size());
  for (const Spectra& tile : tiles) {
    for (std::size_t i = 0; i < total.red.size(); ++i) {
      total.red[i] += limited(tile.red[i]);
      total.green_blue[i] += limited(tile.green_blue[i]);
    }
  }
  for (auto* power : {&total.red, &total.green_blue}) {
    const float floor = std::max(middle_of(*power), 1e-20F);
    for (float& value : *power) value /= floor;
  }
  return total;
}

std::vector<SpectralPeak> find_peaks(const Spectra& s, std::size_t n_peaks,
                                     double lowest_frequency) {
  std::vector<SpectralPeak> peaks;
  const int half = s.size / 2;
  const auto sum = [&](int kx, int ky) { return s.at(s.red, kx, ky) + s.at(s.green_blue, kx, ky); };
  for (int ky = 0; ky <= half; ++ky) {
    for (int kx = -half; kx < half; ++kx) {
      if (ky == 0 && kx <= 0) continue;
      const double f = std::hypot(kx, ky) / s.size;
      if (f < lowest_frequency) continue;
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
      SpectralPeak peak;
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
  std::stable_sort(peaks.begin(), peaks.end(), [](const SpectralPeak& a, const SpectralPeak& b) {
    return a.power() > b.power();
  });
  // Film that bends spreads a line over several bins: keep the strongest of a group.
  std::vector<SpectralPeak> apart;
  for (const SpectralPeak& peak : peaks) {
    const bool near = std::any_of(apart.begin(), apart.end(), [&](const SpectralPeak& other) {
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

}  // namespace reseau
