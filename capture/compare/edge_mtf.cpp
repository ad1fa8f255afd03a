#include "capture/compare/edge_mtf.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "capture/compare/edge_spline.h"
#include "core/base/check.h"

namespace reseau::compare {
namespace {

constexpr int kSmallestSide = 12;
constexpr double kLargestSupportPx = 24;
constexpr double kSmallestSupportPx = 5;
constexpr double kWorstResidual = 0.10;  // of the contrast
constexpr double kWorstSlope = 0.12;     // of a plateau, fraction of the contrast
constexpr double kWorstVariation = 1.8;  // overshoot on both sides included
constexpr double kWidestGapPx = 0.3;
// For the geometry only: smooth enough for noise, sharp enough for its slope.
constexpr double kGeometryPenalty = 1e-2;

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

class Region {
 public:
  Region(std::span<const double> samples, int width, int height)
      : samples_(samples), width_(width), height_(height) {}

  [[nodiscard]] double at(int x, int y) const {
    return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x)];
  }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] double middle_x() const { return (width_ - 1) / 2.0; }
  [[nodiscard]] double middle_y() const { return (height_ - 1) / 2.0; }

  // F(across, along, sample) for every finite sample; across and along the edge from the middle.
  template <typename F>
  void for_each(const EdgeGeometry& g, const F& f) const {
    const double c = std::cos(radians(g.normal_deg)), s = std::sin(radians(g.normal_deg));
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const double value = at(x, y);
        if (!std::isfinite(value)) continue;
        const double dx = x - middle_x(), dy = y - middle_y();
        f(dx * c + dy * s - g.offset_px, dy * c - dx * s, value);
      }
    }
  }

 private:
  std::span<const double> samples_;
  int width_, height_;
};

// Structure tensor of the gradient after a 3 x 3 mean.
EdgeGeometry first_guess(const Region& region) {
  const auto mean = [&region](int x, int y) {
    double sum = 0;
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) sum += region.at(x + i, y + j);
    }
    return sum / 9;
  };
  double xx = 0, xy = 0, yy = 0, mx = 0, my = 0, total = 0;
  for (int y = 2; y < region.height() - 2; ++y) {
    for (int x = 2; x < region.width() - 2; ++x) {
      const double gx = mean(x + 1, y) - mean(x - 1, y), gy = mean(x, y + 1) - mean(x, y - 1);
      const double weight = gx * gx + gy * gy;
      if (!std::isfinite(weight)) continue;
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
      // Squared, so that the noise of the plateaus does not pull towards the middle.
      mx += weight * weight * (x - region.middle_x());
      my += weight * weight * (y - region.middle_y());
      total += weight * weight;
    }
  }
  EdgeGeometry guess;
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  guess.normal_deg = angle * 180 / std::numbers::pi;
  if (total > 0) guess.offset_px = (mx * std::cos(angle) + my * std::sin(angle)) / total;
  return guess;
}

struct Reach {
  double low = 0, high = 0, along_low = 0, along_high = 0;
  [[nodiscard]] double support() const { return std::min(high, -low); }
};

Reach reach_of(const Region& region, const EdgeGeometry& geometry) {
  Reach reach;
  region.for_each(geometry, [&](double across, double along, double) {
    reach.low = std::min(reach.low, across);
    reach.high = std::max(reach.high, across);
    if (std::abs(across) < 1) {
      reach.along_low = std::min(reach.along_low, along);
      reach.along_high = std::max(reach.along_high, along);
    }
  });
  return reach;
}

ProfileBins profile(const Region& region, const EdgeGeometry& geometry, double support) {
  ProfileBins bins(support);
  region.for_each(geometry, [&](double across, double, double value) { bins.add(across, value); });
  return bins;
}

// Where the fitted profile passes the middle between its ends.
double middle_of(const EdgeSpline& spline, double support) {
  const double low = spline.value(-0.9 * support), high = spline.value(0.9 * support);
  const double half = 0.5 * (low + high);
  const double sign = high > low ? 1 : -1;
  double best = 0, nearest = HUGE_VAL;
  constexpr int kSteps = 400;
  double before = sign * (spline.value(-0.9 * support) - half);
  for (int i = 1; i <= kSteps; ++i) {
    const double at = support * (-0.9 + 1.8 * i / kSteps);
    const double now = sign * (spline.value(at) - half);
    if (before < 0 && now >= 0 && std::abs(at) < nearest) {
      nearest = std::abs(at);
      best = at - 1.8 * support / kSteps * now / (now - before);
    }
    before = now;
  }
  return best;
}

// Least squares on the pixels for a small turn about the middle of the edge.
double turn_rad(const Region& region, const EdgeGeometry& geometry, const EdgeSpline& spline,
                double support) {
  // Unknowns: turn and shift; the shift is only there to be free.
  double tt = 0, t1 = 0, one = 0, rt = 0, r1 = 0;
  region.for_each(geometry, [&](double across, double along, double value) {
    if (std::abs(across) > support) return;
    const double slope = spline.slope(across);
    const double rest = value - spline.value(across);
    tt += slope * slope * along * along;
    t1 += slope * slope * along;
    one += slope * slope;
    rt += rest * slope * along;
    r1 += rest * slope;
  });
  const double determinant = tt * one - t1 * t1;
  return determinant > 1e-12 * tt * one ? (rt * one - r1 * t1) / determinant : 0;
}

EdgeMtf refused(EdgeMtf mtf, const char* status, const char* reason) {
  mtf.status = status;
  mtf.reason = reason;
  mtf.mtf.clear();
  mtf.mtf50_cy_per_px.reset();
  return mtf;
}

void tabulate(const EdgeSpline& spline, EdgeMtf& result) {
  constexpr int kSteps = 100;
  for (int i = 0; i <= kSteps; ++i) {
    result.mtf.push_back(spline.mtf(i * kMtfStep));
    const double now = result.mtf.back();
    if (!result.mtf50_cy_per_px && i > 0 && now < 0.5) {
      const double before = result.mtf[static_cast<std::size_t>(i) - 1];
      result.mtf50_cy_per_px = kMtfStep * (i - 1 + (before - 0.5) / (before - now));
    }
  }
}

}  // namespace

EdgeMtf measure_edge(std::span<const double> samples, int width_px, int height_px,
                     const std::optional<EdgeGeometry>& start) {
  CHECK(width_px >= 0 && height_px >= 0 &&
        samples.size() == static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  EdgeMtf result;
  if (std::min(width_px, height_px) < kSmallestSide) {
    return refused(result, "too-small", "The region of the edge is smaller than 12 pixels.");
  }
  const Region region(samples, width_px, height_px);
  result.geometry = start ? *start : first_guess(region);
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    const double support =
        std::min(kLargestSupportPx, 0.97 * reach_of(region, result.geometry).support());
    if (support < kSmallestSupportPx) {
      return refused(result, "too-small", "The edge has no flat area on both sides in the region.");
    }
    const ProfileBins bins = profile(region, result.geometry, support);
    const EdgeSpline spline(bins, kGeometryPenalty);
    const double turn = std::clamp(turn_rad(region, result.geometry, spline, support), -0.1, 0.1);
    result.geometry.offset_px += middle_of(spline, support);
    result.geometry.normal_deg += turn * 180 / std::numbers::pi;
    if (std::abs(turn) < 1e-7) break;
  }

  const Reach reach = reach_of(region, result.geometry);
  result.support_px = std::min(kLargestSupportPx, 0.97 * reach.support());
  if (result.support_px < kSmallestSupportPx) {
    return refused(result, "too-small", "The edge has no flat area on both sides in the region.");
  }
  result.length_px = reach.along_high - reach.along_low;
  const double turned = std::abs(std::remainder(result.geometry.normal_deg, 90.0));
  result.angle_deg = turned;
  const ProfileBins bins = profile(region, result.geometry, result.support_px);
  const EdgeSpline spline(bins, 0);
  const double w = result.support_px;
  result.contrast = std::abs(spline.value(0.95 * w) - spline.value(-0.95 * w));
  if (!(result.contrast > 0) || !std::isfinite(result.contrast)) {
    return refused(result, "no-contrast", "The two sides of the region are equally bright.");
  }
  result.residual = spline.residual() / result.contrast;
  if (!(result.residual < kWorstResidual) ||
      spline.variation() > kWorstVariation * result.contrast) {
    return refused(result, "not-an-edge",
                   "The region holds no single straight edge between two flat areas.");
  }
  const double slope = std::max(std::abs(spline.value(0.95 * w) - spline.value(0.6 * w)),
                                std::abs(spline.value(-0.95 * w) - spline.value(-0.6 * w)));
  if (slope > kWorstSlope * result.contrast) {
    return refused(
        result, "not-flat",
        "The areas beside the edge are not flat, or the edge is too wide for the region.");
  }
  if (bins.widest_gap_px(2) > kWidestGapPx) {
    return refused(result, "angle",
                   "The edge runs along the pixel grid; a slant of 2 to 43 degrees is needed.");
  }
  tabulate(spline, result);
  return result;
}

}  // namespace reseau::compare
