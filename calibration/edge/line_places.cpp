#include "calibration/edge/line_places.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>

namespace reseau {
namespace {

// Of the middle of the profile: where it matches its mirror image.
double middle_of(const ProfileFit& fit, double width_px) {
  const double reach = std::min(fit.reach_px(), 4 * width_px + 1);
  constexpr int kSteps = 200;
  double pull = 0, weight = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double d = reach * i / kSteps;
    const double slope = 0.5 * (fit.slope(d) + fit.slope(-d));
    pull += (1 - fit.value(d) - fit.value(-d)) * slope;
    weight += 2 * slope * slope;
  }
  return weight > 0 ? pull / weight : 0;
}

bool crosses_rows(double normal_rad) {
  return std::abs(std::cos(normal_rad)) >= std::numbers::sqrt2 / 2;
}

}  // namespace

std::vector<LinePlace> line_places(std::span<const ProfileSample> samples, const ProfileFit& fit,
                                   const EdgeLine& line, std::span<const double> shifts,
                                   double width_px) {
  struct Sum {
    double pull = 0, weight = 0;
  };
  std::map<int, Sum> sums;
  for (const ProfileSample& s : samples) {
    if (std::abs(s.distance) > 4 * width_px) continue;
    const double slope = fit.slope(s.distance);
    Sum& sum = sums[s.line];
    sum.pull += s.weight * slope * (s.value - fit.fitted(s.distance));
    sum.weight += s.weight * slope * slope;
  }
  const LineFrame frame(line);
  const bool by_row = crosses_rows(line.normal_rad);
  const double across = by_row ? frame.cosine() : frame.sine();
  const double middle = middle_of(fit, width_px), noise2 = fit.noise() * fit.noise();
  std::vector<LinePlace> out;
  for (const auto& [index, sum] : sums) {
    if (!(sum.weight > 0.05)) continue;  // hardly a pixel on the slope
    double at = by_row ? line.middle.x : line.middle.y;
    for (int round = 0; round < 4; ++round) {
      at -= (by_row ? frame.at(at, index) : frame.at(index, at)).distance / across;
    }
    const double shift = shifts.empty() ? 0 : shifts[static_cast<std::size_t>(index)];
    // Too high a value means that the edge lies nearer to the dark side.
    out.push_back({index, at + (middle - shift - sum.pull / sum.weight) / across,
                   noise2 / sum.weight, 0.25 * middle * middle});
  }
  return out;
}

PlaceDifference place_difference(std::span<const LinePlace> a, std::span<const LinePlace> b,
                                 double normal_rad) {
  constexpr std::size_t kParts = 10, kFarthestNeighbour = 6;
  const double across = crosses_rows(normal_rad) ? std::cos(normal_rad) : std::sin(normal_rad);
  struct Both {
    double apart = 0, weight = 0;
  };
  std::vector<Both> lines;
  auto other = b.begin();
  for (const LinePlace& one : a) {
    while (other != b.end() && other->line < one.line) ++other;
    if (other == b.end() || other->line != one.line) continue;
    const double variance = one.variance + other->variance;
    if (variance > 0) lines.push_back({across * (other->at_px - one.at_px), 1 / variance});
  }
  PlaceDifference out;
  double weight = 0, sum = 0;
  for (const Both& line : lines) {
    weight += line.weight;
    sum += line.weight * line.apart;
  }
  if (!(weight > 0)) return out;
  out.value = sum / weight;
  out.variance = 1 / weight;
  out.common = a.front().common + b.front().common;
  if (lines.size() < 2 * kParts) return out;
  for (std::size_t k = 0; k < kParts; ++k) {
    double of_part = 0, pull = 0;
    for (std::size_t i = k * lines.size() / kParts; i < (k + 1) * lines.size() / kParts; ++i) {
      of_part += lines[i].weight;
      pull += lines[i].weight * (lines[i].apart - out.value);
    }
    out.chi2 += pull * pull / of_part;
  }
  out.freedom = static_cast<double>(kParts - 1);
  // Ten parts know their scatter badly, and neighbours that err alike spread over the border
  // between two of them; how alike neighbours err tells it better where they do.
  std::vector<double> rest;
  double squares = 0;
  for (const Both& line : lines) {
    rest.push_back(std::sqrt(line.weight) * (line.apart - out.value));
    squares += rest.back() * rest.back();
  }
  const auto n = static_cast<double>(rest.size());
  double alike = 1;
  for (std::size_t k = 1; k <= kFarthestNeighbour && squares > 0; ++k) {
    double product = 0;
    for (std::size_t i = k; i < rest.size(); ++i) product += rest[i] * rest[i - k];
    const double r = product / squares + 1 / n;  // the mean was taken from the same lines
    if (!(r > 2 / std::sqrt(n))) break;
    alike += 2 * r;
  }
  out.chi2 = std::max(out.chi2, out.freedom * squares / (n - 1) * alike);
  return out;
}

}  // namespace reseau
