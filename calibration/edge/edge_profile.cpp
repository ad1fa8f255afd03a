// The profile of the edge, with the line as it asks for.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "calibration/edge/edge_checks.h"
#include "calibration/edge/edge_work.h"
#include "calibration/edge/pixel_fit.h"

namespace reseau::edge {
namespace {

constexpr double kWidestGapPx = 0.55;

}  // namespace

// The levels as the profile found them.
PixelModel EdgeWork::with_levels() const {
  const ProfileFit::Levels levels = fit_->levels();
  const double whole = contrast();
  PixelModel model = model_;
  model.levels.dark += whole * levels.dark;
  model.levels.bright += whole * levels.bright;
  model.levels.dark_across = whole * levels.dark_across;
  model.levels.bright_across = whole * levels.bright_across;
  return model;
}

// Noise on both sides, for the weights; only a clear difference counts.
void EdgeWork::weigh_sides(const ProfileFunction& profile) {
  double squares[2] = {0, 0}, n[2] = {0, 0};
  const double far = 3 * width_ + 5;
  std::vector<ProfilePoint> points;
  for_each_edge_pixel(samples_, used_, model_, [&](std::span<const EdgePixel> row) {
    points.resize(row.size());
    profile(row, points);
    // Third differences of neighbours: whatever is smooth drops out.
    for (std::size_t i = 3; i < row.size(); ++i) {
      if (row[i].x != row[i - 3].x + 3 || std::abs(row[i].distance) < far) continue;
      if ((row[i].distance > 0) != (row[i - 3].distance > 0)) continue;
      const int side = row[i].distance > 0 ? 1 : 0;
      const double step =
          row[i].value - 3 * row[i - 1].value + 3 * row[i - 2].value - row[i - 3].value;
      squares[side] += step * step / 20;
      n[side] += 1;
    }
  });
  for (int i = 0; i < 2; ++i) {
    if (n[i] > 0) plateau_noise_ = std::max(plateau_noise_, std::sqrt(squares[i] / n[i]));
  }
  if (n[0] < 30 || n[1] < 30) return;
  const double least = std::pow(2e-4 * contrast(), 2);
  const double dark = squares[0] / n[0] + least, bright = squares[1] / n[1] + least;
  if (std::max(dark, bright) < 1.4 * std::min(dark, bright)) return;
  const double mean = 0.5 * (dark + bright);
  dark_weight_ = std::min(mean / dark, 30.0);
  bright_weight_ = std::min(mean / bright, 30.0);
}

// Where the edge wavers from line to line (a rough blade, an unsteady stage) by more than noise
// explains, each line gets a place of its own, shrunk by what noise does to it.
void EdgeWork::follow_lines() {
  struct Line {
    double pull = 0, weight = 0;
  };
  std::vector<Line> lines(static_cast<std::size_t>(std::max(samples_.width(), samples_.height())));
  for (const ProfileSample& s : gathered_) {
    if (std::abs(s.distance) > 4 * width_) continue;
    const double slope = fit_->slope(s.distance);
    Line& line = lines[static_cast<std::size_t>(s.line)];
    line.pull += s.weight * slope * (s.value - fit_->fitted(s.distance));
    line.weight += s.weight * slope * slope;
  }
  double n = 0, chi2 = 0, wander = 0;
  const double noise2 = fit_->noise() * fit_->noise();
  for (const Line& line : lines) {
    if (!(line.weight > 0)) continue;
    const double shift = line.pull / line.weight;
    n += 1;
    chi2 += shift * shift * line.weight / noise2;
    wander += shift * shift - noise2 / line.weight;
  }
  if (n < 24 || chi2 / n < 1 + 5 * std::sqrt(2 / n) || !(wander > 0)) return;
  wander /= n;
  // Smaller than this it does not matter, however sure.
  if (wander < 4e-5) return;
  out_.wander_px = std::sqrt(wander);
  line_shift_.assign(lines.size(), 0);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!(lines[i].weight > 0)) continue;
    const double share = wander / (wander + noise2 / lines[i].weight);
    // value rises with distance: too high a value means that the edge lies nearer to the dark side.
    line_shift_[i] = share * lines[i].pull / lines[i].weight;
  }
}

// An edge whose place wavers within a line of pixels is noisier where it is steep; only a clear
// excess counts.
void EdgeWork::weigh_edge() {
  double excess = 0, steep = 0;
  const double noise2 = fit_->noise() * fit_->noise();
  for (const ProfileSample& s : gathered_) {
    if (std::abs(s.distance) > 3 * width_) continue;
    const double slope = fit_->slope(s.distance);
    const double rest = s.value - fit_->fitted(s.distance);
    excess += (s.weight * rest * rest - noise2) * slope * slope;
    steep += slope * slope * slope * slope;
  }
  if (!(steep > 0)) return;
  const double ratio = excess / (steep * noise2);
  // Its standard deviation when there is no excess.
  const double sd = std::sqrt(2 / steep);
  if (ratio > 6 * sd && ratio > 1) edge_noise_ = std::min(ratio, 1e4);
}

std::vector<ProfileSample> EdgeWork::gather() {
  std::vector<ProfileSample> samples;
  const EdgeLevels& l = model_.levels;
  const double whole = contrast();
  const bool by_row = std::abs(std::cos(model_.line.normal_rad)) >= std::numbers::sqrt2 / 2;
  const bool weighted = dark_weight_ != bright_weight_;
  for_each_edge_pixel(samples_, used_, model_, [&](std::span<const EdgePixel> row) {
    for (const EdgePixel& p : row) {
      const double v = p.along / model_.line.half_length_px;
      const double dark = l.dark + l.dark_along * v, bright = l.bright + l.bright_along * v;
      const double height = bright - dark;
      ProfileSample sample;
      sample.line = by_row ? p.y : p.x;
      const double shift =
          line_shift_.empty() ? 0 : line_shift_[static_cast<std::size_t>(sample.line)];
      sample.distance = p.distance + shift;
      sample.value = (p.value - dark) / height;
      sample.weight = height * height / (whole * whole);
      if (weighted) {
        const double e = fit_ ? fit_->value(p.distance)
                              : 0.5 * std::erfc(-p.distance / (width_ * std::numbers::sqrt2));
        const double share = std::clamp(e, 0.0, 1.0);
        sample.weight /= (1 - share) / dark_weight_ + share / bright_weight_;
      }
      if (edge_noise_ > 0) {
        const double slope = fit_ ? fit_->slope(sample.distance) : 0;
        sample.weight /= 1 + edge_noise_ * slope * slope;
      }
      samples.push_back(sample);
    }
  });
  if (!by_row) {
    std::stable_sort(
        samples.begin(), samples.end(),
        [](const ProfileSample& a, const ProfileSample& b) { return a.line < b.line; });
  }
  return samples;
}

bool EdgeWork::fit() {
  std::optional<EdgeOptics> start;
  bool left_out_again = false;
  for (int round = 0; round < 4; ++round) {
    gathered_ = gather();
    ProfileBins bins(model_.reach_px);
    for (const ProfileSample& s : gathered_) bins.add(s.distance, s.value, s.weight);
    ProfileFitOptions options;
    options.normal = cosines();
    options.reach_px = model_.reach_px;
    options.width_px = width_;
    const double whole = contrast();
    options.least_noise = std::max(2e-5, 0.29 * options_.quantum / whole);
    // Phases of the grid that the edge meets, near its middle.
    double last = -1.5;
    out_.phase_gap_px = 0;
    for (const ProfileBins::Bin& bin : bins.bins()) {
      if (std::abs(bin.distance) > 1.5) continue;
      out_.phase_gap_px = std::max(out_.phase_gap_px, bin.distance - last);
      last = bin.distance;
    }
    out_.phase_gap_px = std::max(out_.phase_gap_px, 1.5 - last);
    options.residual = out_.phase_gap_px <= std::max(kWidestGapPx, 0.5 * width_);
    ProfileFit now(bins, options, start);
    if (!now.ok()) return refuse(EdgeReason::kNoFit);
    fit_.emplace(std::move(now));
    start = fit_->optics();
    if (!left_out_again) {
      left_out_again = true;
      follow_lines();
      if (line_shift_.empty()) weigh_edge();
      if (edge_noise_ > 0 || !line_shift_.empty()) start.reset();
      const std::size_t before =
          static_cast<std::size_t>(std::count(used_.begin(), used_.end(), 0));
      if (leave_out_strays(samples_, used_, with_levels(), fitted(), 0.008, 3 * width_ + 1) >
              before ||
          edge_noise_ > 0 || !line_shift_.empty()) {
        continue;
      }
    }
    if (round == 3 || !line_shift_.empty()) break;
    // The line again, with the profile as found.
    PixelModel model = with_levels();
    double moved = 0;
    bool stepped = true;
    for (int step_round = 0; step_round < 2 && stepped; ++step_round) {
      const PixelStep step = pixel_step(samples_, used_, model, fitted(), n_shape_, false, true);
      stepped = step.ok;
      if (!step.ok) break;
      model = step.model;
      moved += step.moved_px;
      if (step.moved_px < 1e-4) break;
    }
    // A third of what noise alone moves it by; without noise what a wrong line adds is seen.
    const double limit = std::min(3e-4, 0.5 * fit_->noise()) +
                         0.5 * fit_->noise() * std::sqrt(3.5 * width_ / model_.line.half_length_px);
    if (!stepped || moved < limit) break;
    model_ = model;
    model_.levels.dark_across = model_.levels.bright_across = 0;
    place(model_.line);
  }
  return true;
}
}  // namespace reseau::edge
