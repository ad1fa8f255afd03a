#include "calibration/edge/find_edges.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "calibration/edge/first_line.h"

namespace reseau {
namespace {

constexpr int kRegion = 112;
constexpr int kStride = 48;
constexpr int kSmallPicture = 160;  // is one region
constexpr std::size_t kMostLooks = 400;
constexpr double kLeastExplained = 0.8;
// A wedge or the rim of a disc is straight within a region, and its neighbours' light falls on it:
// what is seen this much farther out must still be the same edge.
constexpr int kSurround_px = kRegion / 8;
constexpr double kLeastExplainedAround = 0.9;
constexpr double kSameEdge_rad = 0.05;

struct Block {
  int x, y;
  double variance;
};

Span2D<const float> part_of(Span2D<const float> s, const EdgePlace& place) {
  return {s.data() + static_cast<std::ptrdiff_t>(place.y) * s.width() + place.x, place.width,
          place.height, s.width()};
}

// Variance of the samples of a region, on every third of them.
double variance_of(Span2D<const float> s, int x0, int y0, int width, int height) {
  double n = 0, sum = 0, squares = 0;
  for (int y = y0; y < y0 + height; y += 3) {
    const auto row = s.row(y);
    for (int x = x0; x < x0 + width; x += 3) {
      const double v = double{row[static_cast<std::size_t>(x)]};
      if (!std::isfinite(v)) continue;
      n += 1;
      sum += v;
      squares += v * v;
    }
  }
  return n > 0 ? squares / n - sum * sum / (n * n) : 0;
}

// Whether one straight edge explains the surroundings of the region as well.
bool stands_alone(Span2D<const float> s, const EdgePlace& place, const EdgeLine& line) {
  const int left = std::max(0, place.x - kSurround_px), top = std::max(0, place.y - kSurround_px);
  const int right = std::min(s.width(), place.x + place.width + kSurround_px);
  const int bottom = std::min(s.height(), place.y + place.height + kSurround_px);
  const auto around = first_line(part_of(s, {left, top, right - left, bottom - top, 0}));
  return around && around->explained >= kLeastExplainedAround &&
         std::abs(std::remainder(around->line.normal_rad - line.normal_rad, 2 * std::numbers::pi)) <
             kSameEdge_rad;
}

bool overlap(const EdgePlace& a, const EdgePlace& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

}  // namespace

std::vector<EdgePlace> find_edges(Span2D<const float> samples, int n_most) {
  const int w = samples.width(), h = samples.height();
  if (w <= 0 || h <= 0) return {};
  if (std::max(w, h) <= kSmallPicture) return {{0, 0, w, h, 1}};
  const int rw = std::min(w, kRegion), rh = std::min(h, kRegion);
  std::vector<Block> blocks;
  for (int y = 0;; y += kStride) {
    const int top = std::min(y, h - rh);
    for (int x = 0;; x += kStride) {
      const int left = std::min(x, w - rw);
      const double variance = variance_of(samples, left, top, rw, rh);
      if (variance > 0) blocks.push_back({left, top, variance});
      if (left == w - rw) break;
    }
    if (top == h - rh) break;
  }
  std::stable_sort(blocks.begin(), blocks.end(),
                   [](const Block& a, const Block& b) { return a.variance > b.variance; });
  if (blocks.size() > kMostLooks) blocks.resize(kMostLooks);
  std::vector<EdgePlace> places;
  for (const Block& block : blocks) {
    EdgePlace place{block.x, block.y, rw, rh, 0};
    const auto line = first_line(part_of(samples, place));
    if (!line || line->explained < kLeastExplained) continue;
    // An edge in the middle leaves flat areas on both sides.
    if (std::abs(line->line.offset_px) > 0.2 * std::min(rw, rh)) continue;
    const double rest = std::max(1e-4, 1 - line->explained);
    if (!stands_alone(samples, place, line->line)) continue;
    place.merit = std::sqrt(block.variance / rest);
    places.push_back(place);
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const EdgePlace& a, const EdgePlace& b) { return a.merit > b.merit; });
  std::vector<EdgePlace> out;
  for (const EdgePlace& place : places) {
    if (static_cast<int>(out.size()) >= n_most) break;
    if (std::none_of(out.begin(), out.end(),
                     [&](const EdgePlace& taken) { return overlap(place, taken); })) {
      out.push_back(place);
    }
  }
  return out;
}

}  // namespace reseau
