// Where the edge lies in the region, with a Gaussian for its profile, and whether it is one.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "calibration/edge/edge_checks.h"
#include "calibration/edge/edge_work.h"
#include "calibration/edge/first_line.h"
#include "calibration/edge/pixel_fit.h"

namespace reseau::edge {
namespace {

using std::numbers::pi;

constexpr int kSmallestSide = 10;
constexpr double kFarthestPx = 80;
constexpr double kLeastSignal = 3;  // contrast over noise of one sample
constexpr double kMostBend = 0.07;  // of the length

}  // namespace

NormalCosines EdgeWork::cosines() const {
  return {std::abs(std::cos(model_.line.normal_rad)), std::abs(std::sin(model_.line.normal_rad))};
}

// Middle and length of the part of the line within the region; how far the region reaches.
void EdgeWork::place(const EdgeLine& line) {
  const double c = std::cos(line.normal_rad), s = std::sin(line.normal_rad);
  const double px = line.middle.x + c * line.offset_px, py = line.middle.y + s * line.offset_px;
  double low = -1e9, high = 1e9;
  const auto clip = [&](double at, double step, double end) {
    // 0 - 0.5 <= at + t step <= end - 0.5
    if (std::abs(step) < 1e-12) return;
    double a = (-0.5 - at) / step, b = (end - 0.5 - at) / step;
    if (a > b) std::swap(a, b);
    low = std::max(low, a);
    high = std::min(high, b);
  };
  clip(px, -s, samples_.width());
  clip(py, c, samples_.height());
  EdgeLine& to = model_.line;
  const double bend = line.bend_px, twist = line.twist_px;
  to = line;
  to.bend_px = bend;
  to.twist_px = twist;
  to.offset_px = 0;
  if (high > low) {
    const double t = 0.5 * (low + high);
    to.middle = {px - s * t, py + c * t};
    to.half_length_px = std::max(1.0, 0.5 * (high - low));
  } else {
    to.middle = {px, py};
    to.half_length_px = 1;
  }
}

bool EdgeWork::begin() {
  const int w = samples_.width(), h = samples_.height();
  if (std::min(w, h) < kSmallestSide) return refuse(EdgeReason::kTooSmall);
  std::size_t n_bad = 0;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  used_.assign(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), 1);
  for (int y = 0; y < h; ++y) {
    const auto row = samples_.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      const float v = row[x];
      if (std::isfinite(v)) {
        low = std::min(low, v);
        high = std::max(high, v);
      } else {
        used_[static_cast<std::size_t>(y) * row.size() + x] = 0;
        ++n_bad;
      }
    }
  }
  if (n_bad > used_.size() / 5) return refuse(EdgeReason::kNotFinite);
  if (n_bad > 0) out_.reasons.push_back(EdgeReason::kLeftOut);
  if (!(high > low)) return refuse(EdgeReason::kNoContrast);
  const std::optional<FirstLine> first = first_line(samples_);
  if (!first) return refuse(EdgeReason::kNoContrast);
  cell_ = first->cell_px;
  model_.levels.dark = first->dark;
  model_.levels.bright = first->bright;
  place(first->line);
  return true;
}

ProfileFunction EdgeWork::gaussian() const {
  const double width = width_;
  return [width](std::span<const EdgePixel> row, std::span<ProfilePoint> points) {
    // Normal distribution; by_width is the derivative by the width itself.
    const double k = 1 / (width * std::numbers::sqrt2);
    const double scale = 1 / (width * std::sqrt(2 * pi));
    for (std::size_t i = 0; i < row.size(); ++i) {
      const double d = row[i].distance;
      const double t = d * k;
      if (std::abs(t) > 4.5) {
        points[i] = {d > 0 ? 1.0 : 0.0, 0, 0};
        continue;
      }
      const double slope = scale * std::exp(-t * t);
      points[i] = {0.5 * std::erfc(-t), slope, -slope * d / width};
    }
  };
}

ProfileFunction EdgeWork::fitted() const {
  const ProfileFit* fit = &*fit_;
  return [fit](std::span<const EdgePixel> row, std::span<ProfilePoint> points) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      points[i] = {fit->value(row[i].distance), fit->slope(row[i].distance), 0};
    }
  };
}

// Gauss-Newton for the Gaussian edge.
bool EdgeWork::settle(double reach, int most_rounds, int n_shape, bool with_along) {
  model_.reach_px = reach;
  for (int round = 0; round < most_rounds; ++round) {
    const PixelStep step =
        pixel_step(samples_, used_, model_, gaussian(), n_shape, true, with_along);
    if (!step.ok) return false;
    model_ = step.model;
    rms_ = step.rms;
    const double before = width_;
    width_ = std::clamp(width_ + step.width_step, 0.6 * width_, 1.7 * width_);
    width_ = std::clamp(width_, 0.12, 0.5 * kFarthestPx);
    place(model_.line);
    if (step.moved_px < 2e-4 && std::abs(width_ - before) < 2e-3 * width_) break;
  }
  // What got brighter may have become darker.
  if (model_.levels.bright < model_.levels.dark) return false;
  return true;
}

bool EdgeWork::approach() {
  width_ = 1.0 * cell_ + 0.3;
  if (!settle(std::max(8.0, 9 * width_), 4, 0, false) ||
      !settle(std::clamp(7 * width_ + 4, 8.0, kFarthestPx), 12, 0, false)) {
    return refuse(EdgeReason::kNoContrast);
  }
  return true;
}

// Bend and twist where the pixels ask for them.
void EdgeWork::choose_shape() {
  n_shape_ = 0;
  const double length = 2 * model_.line.half_length_px;
  if (length < 14) return;
  const double reach = model_.reach_px;
  model_.reach_px = std::clamp(5 * width_ + 2, 5.0, reach);
  const PixelModel straight = model_;
  for (int shape = 1; shape <= 2; ++shape) {
    model_ = straight;
    PixelStep step;
    for (int round = 0; round < 6; ++round) {
      step = pixel_step(samples_, used_, model_, gaussian(), shape, false, false);
      if (!step.ok) break;
      model_ = step.model;
      place(model_.line);
      if (step.moved_px < 1e-3) break;
    }
    const double limit = std::sqrt(std::log(step.n) + 2);
    const double size = shape == 1 ? model_.line.bend_px : model_.line.twist_px;
    const double sd = shape == 1 ? step.bend_sd : step.twist_sd;
    if (!step.ok || std::abs(size) < limit * sd || std::abs(size) < 0.01) {
      if (shape == 1) continue;
      break;
    }
    n_shape_ = shape;
  }
  model_ = straight;
  if (n_shape_ > 0) {
    for (int round = 0; round < 8; ++round) {
      const PixelStep step =
          pixel_step(samples_, used_, model_, gaussian(), n_shape_, false, false);
      if (!step.ok) break;
      model_ = step.model;
      place(model_.line);
      if (step.moved_px < 1e-3) break;
    }
  }
  model_.reach_px = reach;
}

bool EdgeWork::check_region() {
  EdgeLine& line = model_.line;
  out_.length_px = 2 * line.half_length_px;
  const double c = std::cos(line.normal_rad), s = std::sin(line.normal_rad);
  double dark_side = 0, bright_side = 0;
  for (const double x : {0.0, double(samples_.width() - 1)}) {
    for (const double y : {0.0, double(samples_.height() - 1)}) {
      const double d = c * (x - line.middle.x) + s * (y - line.middle.y);
      dark_side = std::max(dark_side, -d);
      bright_side = std::max(bright_side, d);
    }
  }
  const double shorter = std::min(dark_side, bright_side);
  if (out_.length_px < 8) return refuse(EdgeReason::kShortPlateau);
  if (!(contrast() > 0)) return refuse(EdgeReason::kNoContrast);
  const double longest = std::clamp(36 + 8 * width_, 30.0, kFarthestPx);
  model_.reach_px = std::min(std::max(dark_side, bright_side), longest);
  if (!settle(model_.reach_px, 3, 0, true)) return refuse(EdgeReason::kNoContrast);
  const double pixels = double(samples_.width()) * double(samples_.height());
  const double halves = 0.5 * std::min(pixels, 2 * model_.reach_px * out_.length_px);
  const double t = contrast() / (rms_ * std::sqrt(2 / std::max(4.0, 0.5 * halves)));
  if (contrast() < kLeastSignal * rms_ || t < 10) {
    // A region with structure that is no edge has contrast of its own.
    const bool structure = uneven_share(samples_, model_, gaussian(), 0.3, rms_) > 0.2;
    return refuse(structure ? EdgeReason::kNotAnEdge : EdgeReason::kNoContrast);
  }
  if (shorter < 2.5 * width_ + 1) {
    return refuse(width_ > 0.2 * std::max(dark_side, bright_side) ? EdgeReason::kTooWide
                                                                  : EdgeReason::kShortPlateau);
  }
  leave_out_strays(samples_, used_, model_, gaussian(), 0.03, 6 * width_ + 2);
  choose_shape();
  out_.length_px = 2 * line.half_length_px;
  if (std::abs(line.bend_px) > std::max(2.0, kMostBend * out_.length_px) ||
      std::abs(line.twist_px) > std::max(2.0, kMostBend * out_.length_px)) {
    return refuse(EdgeReason::kCurved);
  }
  if (!settle(model_.reach_px, 3, n_shape_, true)) return refuse(EdgeReason::kNoContrast);
  out_.reach_px = model_.reach_px;
  // Rough flatness: a second edge, a corner, a line.
  if (uneven_share(samples_, model_, gaussian(), 0.25, rms_) > 0.06) {
    return refuse(EdgeReason::kNotAnEdge);
  }
  return true;
}
}  // namespace reseau::edge
