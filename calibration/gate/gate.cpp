#include "calibration/gate/gate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "calibration/gate/gate_level.h"
#include "calibration/gate/gate_response.h"

namespace reseau {
namespace {

using gate::Exposed;
using gate::Reduced;

constexpr std::array<const char*, kGateChannels> kNames{"red", "green", "blue", "infrared"};

std::string sentence(std::size_t channel, const char* text) {
  std::string out(kNames[channel]);
  return out.append(": ").append(text);
}

// The brightest that is not clipped.
const Reduced* brightest(const std::vector<Reduced>& all) {
  const Reduced* best = nullptr;
  for (const Reduced& one : all) {
    if (one.level.clipped) continue;
    if (best == nullptr || one.level.level > best->level.level) best = &one;
  }
  return best;
}

// Mean over pixels around each, narrower at the ends.
std::vector<double> smooth(const std::vector<double>& values, std::size_t half) {
  std::vector<double> sums(values.size() + 1, 0.0);
  std::partial_sum(values.begin(), values.end(), sums.begin() + 1);
  std::vector<double> out(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t reach = std::min({half, i, values.size() - 1 - i});
    out[i] = (sums[i + reach + 1] - sums[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return out;
}

void find_flat(const Reduced& scan, double dark, GateChannel& out) {
  const double mean = scan.level.level - dark;
  if (!(mean > 0)) return;
  std::vector<double> light = scan.columns;
  for (double& column : light) {
    column -= dark;
    if (!(column > 0.01 * mean)) return;  // something covers the frame
  }
  for (const double column : light) out.flat_gain.push_back(mean / column);
  const double scale = static_cast<double>(out.flat_gain.size()) /
                       std::accumulate(out.flat_gain.begin(), out.flat_gain.end(), 0.0);
  for (double& gain : out.flat_gain) gain *= scale;
  out.flat_gain_sd = scan.column_sd / mean;
  constexpr std::size_t kHalf = 32;  // px, over which shading is even
  std::vector<double> wide = smooth(light, kHalf);
  double squares = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    const double d = light[i] / wide[i] - 1;
    squares += d * d;
  }
  const double n = static_cast<double>(light.size());
  out.pixel_rms = std::sqrt(std::max(0.0, squares / n - out.flat_gain_sd * out.flat_gain_sd));
  std::ranges::sort(wide);
  const std::size_t tenth = wide.size() / 20;  // middles of the outer tenths
  out.shading = 1 - wide[tenth] / wide[wide.size() - 1 - tenth];
}

void find_lines(const Reduced& scan, int sensor_lines, int width_px, double dark,
                GateChannel& out) {
  const double mean = scan.level.level - dark;
  const auto turns = static_cast<std::size_t>(std::max(1, sensor_lines == 2 ? 2 : 1));
  if (!(mean > 0) || scan.lines.size() < 4 * turns) return;
  std::array<double, 2> sum{}, squares{}, n{};
  for (std::size_t l = 0; l < scan.lines.size(); ++l) {
    sum[l % turns] += scan.lines[l];
    n[l % turns] += 1;
  }
  for (std::size_t l = 0; l < scan.lines.size(); ++l) {
    const double d = scan.lines[l] - sum[l % turns] / n[l % turns];
    squares[l % turns] += d * d;
  }
  double scatter = 0;
  for (std::size_t k = 0; k < turns; ++k)
    scatter += squares[k] / (n[k] - 1) / static_cast<double>(turns);
  const double by_noise = scan.level.variance / width_px;
  out.lamp_rms = std::sqrt(std::max(0.0, scatter - by_noise)) / mean;
  if (turns == 1) return;
  double middle = 0;
  for (std::size_t k = 0; k < turns; ++k)
    middle += (sum[k] / n[k] - dark) / static_cast<double>(turns);
  for (std::size_t k = 0; k < turns; ++k) {
    const double sd = std::sqrt(std::max(squares[k] / (n[k] - 1), by_noise) / n[k]);
    out.line_gains.push_back({(sum[k] / n[k] - dark) / middle, sd / middle});
  }
}

}  // namespace

GateResult measure_gate(const std::vector<GateScan>& scans) {
  GateResult out;
  bool other_width = false;
  for (std::size_t c = 0; c < kGateChannels; ++c) {
    GateChannel& channel = out.channels[c];
    std::vector<Reduced> reduced;
    std::vector<Exposed> exposed;
    int sensor_lines = 0;
    int width_px = 0;
    std::array<std::optional<double>, kGateChannels> first{};
    for (const GateScan& scan : scans) {
      const auto samples = static_cast<std::size_t>(std::max(0, scan.width_px)) *
                           static_cast<std::size_t>(std::max(0, scan.n_lines));
      if (samples == 0 || scan.light[c].size() != samples) continue;
      if (width_px != 0 && scan.width_px != width_px) {
        other_width = true;
        continue;
      }
      if (width_px == 0) first = scan.exposure_us;
      width_px = scan.width_px;
      sensor_lines = scan.sensor_lines;
      reduced.push_back(gate::reduce(scan, c));
      const GateLevel& level = reduced.back().level;
      channel.levels.push_back(level);
      if (!level.clipped && level.exposure_us) {
        exposed.push_back({level.level, level.level_sd, scan.exposure_us});
      }
    }
    if (reduced.empty()) continue;
    gate::fit_response(exposed, c, first, channel);
    if (!channel.dark) {
      out.remarks.push_back(sentence(
          c, "the dark level cannot be told without scans of two exposures that are known."));
    }
    const double dark = channel.dark ? channel.dark->value : 0.0;
    channel.noise = gate::fit_noise(channel.levels, dark);
    if (!channel.noise) {
      out.remarks.push_back(
          sentence(c, "noise against level cannot be told without scans of two levels."));
    }
    const Reduced* best = brightest(reduced);
    if (best == nullptr) {
      out.remarks.push_back(
          sentence(c, "all scans are clipped; expose so that bare light stays below full scale."));
      continue;
    }
    find_flat(*best, dark, channel);
    if (channel.flat_gain.empty()) {
      out.remarks.push_back(sentence(c, "something covers part of the frame; no flat field."));
    }
    find_lines(*best, sensor_lines, width_px, dark, channel);
  }
  if (other_width) {
    out.remarks.emplace_back(
        "Scans of another width than the first were left out: their pixels are others.");
  }
  return out;
}

}  // namespace reseau
