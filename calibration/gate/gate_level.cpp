#include "calibration/gate/gate_level.h"

#include <algorithm>
#include <cmath>

namespace reseau::gate {
namespace {

constexpr double kMostClipped = 1e-3;  // of the samples at one end of the scale
// Lines that far apart are of the same line of the sensor, whatever the unit has: 3 lines in
// groups of 12, 2 lines in turn.
constexpr int kSameSensorLine = 36;

// Lines from one to the next of the same sensor line.
int repeat_of(const GateScan& scan) {
  if (scan.sensor_lines == 1 || scan.sensor_lines == 2) return scan.sensor_lines;
  if (scan.n_lines > kSameSensorLine) return kSameSensorLine;
  return scan.n_lines > 2 ? 2 : 1;
}

// From differences of lines, which hold neither pattern nor shading; the lamp's own change from
// line to line goes with the mean of each difference.
void find_noise(const GateScan& scan, const std::vector<float>& light,
                const std::vector<double>& lines, GateLevel& level) {
  const auto width = static_cast<std::size_t>(scan.width_px);
  const auto repeat = static_cast<std::size_t>(repeat_of(scan));
  const auto n_lines = static_cast<std::size_t>(scan.n_lines);
  if (width < 2) return;
  double squares = 0, freedom = 0;
  for (std::size_t block = 0; block + repeat < n_lines; block += 2 * repeat) {
    for (std::size_t l = block; l < std::min(block + repeat, n_lines - repeat); ++l) {
      const double apart = lines[l + repeat] - lines[l];
      const float* a = light.data() + l * width;
      const float* b = light.data() + (l + repeat) * width;
      double sum = 0;
      for (std::size_t i = 0; i < width; ++i) {
        const double d = static_cast<double>(b[i]) - static_cast<double>(a[i]) - apart;
        sum += d * d;
      }
      squares += sum;
      freedom += static_cast<double>(width - 1);
    }
  }
  if (!(freedom > 0)) return;
  level.variance = squares / freedom / 2;
  level.variance_sd = level.variance * std::sqrt(2 / freedom);
}

}  // namespace

Reduced reduce(const GateScan& scan, std::size_t channel) {
  Reduced out;
  out.level.exposure_us = scan.exposure_us[channel];
  const std::vector<float>& light = scan.light[channel];
  const auto width = static_cast<std::size_t>(scan.width_px);
  const auto n_lines = static_cast<std::size_t>(scan.n_lines);
  out.columns.assign(width, 0);
  out.lines.assign(n_lines, 0);
  std::size_t low = 0, high = 0;
  for (std::size_t l = 0; l < n_lines; ++l) {
    const float* row = light.data() + l * width;
    double sum = 0;
    for (std::size_t i = 0; i < width; ++i) {
      const float v = row[i];
      low += v <= 0 ? 1 : 0;
      high += v >= 1 ? 1 : 0;
      sum += static_cast<double>(v);
      out.columns[i] += static_cast<double>(v);
    }
    out.lines[l] = sum / static_cast<double>(width);
    out.level.level += out.lines[l];
  }
  out.level.level /= static_cast<double>(n_lines);
  for (double& column : out.columns) column /= static_cast<double>(n_lines);
  const double most = kMostClipped * static_cast<double>(width * n_lines);
  out.level.clipped = static_cast<double>(low) > most || static_cast<double>(high) > most ||
                      !std::isfinite(out.level.level);
  find_noise(scan, light, out.lines, out.level);
  double squares = 0;
  for (const double line : out.lines) {
    squares += (line - out.level.level) * (line - out.level.level);
  }
  // Of the lines as they scatter, the lamp included.
  const double n = static_cast<double>(n_lines);
  const double by_lines = n_lines > 1 ? squares / (n - 1) / n : 0;
  const double by_noise = out.level.variance / static_cast<double>(width * n_lines);
  out.level.level_sd = std::sqrt(std::max(by_lines, by_noise));
  out.column_sd = std::sqrt(out.level.variance / n);
  return out;
}

}  // namespace reseau::gate
