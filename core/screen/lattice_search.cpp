#include "core/screen/lattice_search.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/line_hypothesis.h"
#include "core/screen/tile_spectra.h"

namespace reseau {
namespace {

// Periods up to 35 px; a screen of lines alone may be coarser.
constexpr double kLowestFrequency = 0.028, kLowestLineFrequency = 0.012;
// Of lines alone: how many peaks are tried and what each must have, and the share of what
// alternates that they must explain. What explains more than the last is no screen of lines.
constexpr std::size_t kMostLinePeaks = 3, kMostLineTiles = 8;
constexpr double kFewPeriods = 5;
constexpr double kLeastLinePower = 10 * kNoisePower, kLeastLinesExplained = 0.12,
                 kPlainlyExplained = 0.4;

// The strongest peak that no small harmonic of the lattice explains, over the lattice's own power.
double foreign_power(const std::vector<SpectralPeak>& peaks, const Carriers& lattice, double own,
                     int size) {
  for (const SpectralPeak& peak : peaks) {  // strongest first
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

}  // namespace

ColorSeries series_from_response(const Response& response, ScreenLayout layout, int special_color,
                                 const Carriers& carriers, double sigma_px) {
  const SiteSeries& sites = site_series(layout);
  const std::array<int, 3> colors = site_colors(layout, special_color);
  ColorSeries series;
  const auto transfer = [&](Vec2 f) {
    return std::exp(-2 * std::numbers::pi * std::numbers::pi * sigma_px * sigma_px * dot(f, f));
  };
  if (layout == ScreenLayout::kLines) {
    series.lines = true;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double light = response[k][c];
        const int site = static_cast<int>(k);
        series.mean[c] += sites[k][0] * light;
        series.harmonic[c][0] += light * transfer(2.0 * carriers.v) * line_harmonic(site, 2);
        series.harmonic[c][1] += light * transfer(carriers.v) * line_harmonic(site, 1);
      }
    }
    return series;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double light = response[static_cast<std::size_t>(colors[k])][c];
      series.mean[c] += sites[k][0] * light;
      for (std::size_t i = 0; i < kSeries; ++i) {
        const HarmonicIndex h = kDifferences[i];
        static_assert(kDifferences[3].v == kTileHarmonics[3].v && kSeries == 4);
        const Vec2 f =
            static_cast<double>(h.u) * carriers.u + static_cast<double>(h.v) * carriers.v;
        series.harmonic[c][i] += light * sites[k][i + 1] * transfer(f);
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
  const std::vector<SearchTile> tiles = choose_tiles(rows, size, most_tiles);
  std::vector<Spectra> of_tiles(tiles.size());
  parallel_for(static_cast<int>(tiles.size()), [&](int t) {
    const auto at = static_cast<std::size_t>(t);
    of_tiles[at] = spectra_of(rows, tiles[at], size);
  });
  std::vector<SearchTile> used;
  std::vector<Spectra> spectra;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    if (of_tiles[t].size == 0) continue;
    spectra.push_back(std::move(of_tiles[t]));
    used.push_back(tiles[t]);
  }
  if (used.empty()) {
    result.dark = true;
    result.reason =
        "The picture is black or clipped everywhere: there is no light to see a réseau by.";
    return result;
  }
  const Spectra total = total_of(spectra, size);
  const std::vector<SpectralPeak> peaks = find_peaks(total, 16, kLowestFrequency);
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
  result.reason = rows.grey ? "No réseau was found: no pattern repeats in two directions."
                            : "No réseau was found: no colour pattern repeats in two directions.";
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
  const auto take = [&](const LatticeHypothesis& judged, const Carriers& carriers, double score) {
    best = judged.explained;
    result.found = judged.colors_fit;
    result.reason =
        judged.colors_fit
            ? ""
            : "No réseau was found: the periodic pattern does not have the colours of a screen "
              "that was made.";
    result.seed.grey = rows.grey;
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
    result.seed.foreign = foreign_power(peaks, carriers, score + kNoisePower, size);
    result.seed.confidence = -std::expm1(-score / 100);
  };
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (hypotheses[k] && hypotheses[k]->explained > best)
      take(*hypotheses[k], candidates[k].carriers, candidates[k].score);
  }
  // Lines alone explain at most half of what any other screen shows.
  std::vector<SpectralPeak> strong = find_peaks(total, kMostLinePeaks, kLowestLineFrequency);
  std::erase_if(strong, [](const auto& peak) { return peak.power() < kLeastLinePower; });
  std::vector<LatticeHypothesis> lines(strong.size());
  if (best < kPlainlyExplained && !rows.grey) {
    parallel_for(static_cast<int>(strong.size()), [&](int k) {
      const auto at = static_cast<std::size_t>(k);
      std::vector<TileCorner> corners;
      std::vector<Vec2> frequencies;
      // The middle half of a tile where that holds a few periods.
      const bool half = norm(strong[at].frequency) * size / 2 > kFewPeriods;
      for (std::size_t t = 0; t < std::min(used.size(), kMostLineTiles); ++t) {
        const int inset = half ? size / 4 : 0;
        corners.push_back({used[t].x + inset, used[t].y + inset});
        frequencies.push_back(local_frequency(spectra[t], strong[at].frequency));
      }
      lines[at] = judge_lines(rows, corners, frequencies, half ? size / 2 : size, infrared);
    });
  }
  for (std::size_t k = 0; k < strong.size(); ++k) {
    if (!lines[k].colors_fit || !(lines[k].explained > std::max(best, kLeastLinesExplained)))
      continue;
    lines[k].other_explained = result.seed.layout == ScreenLayout::kLines
                                   ? result.seed.other_explained
                                   : result.seed.explained;
    take(lines[k], carriers_of_lines(strong[k].frequency), strong[k].power() - kNoisePower);
  }
  return result;
}

}  // namespace reseau
