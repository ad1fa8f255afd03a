#include "calibration/edge/measure_edge.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/edge/edge_checks.h"
#include "calibration/edge/first_line.h"
#include "calibration/edge/pixel_fit.h"

namespace reseau {
namespace {

using std::numbers::pi;

constexpr int kSmallestSide = 10;
constexpr double kFarthestPx = 80;
constexpr double kLeastSignal = 3;  // contrast over noise of one sample
constexpr double kWidestGapPx = 0.55;
constexpr double kMostBend = 0.07;  // of the length

// The work on one region; every step may refuse.
class EdgeWork {
 public:
  EdgeWork(Span2D<const float> samples, const EdgeOptions& options)
      : samples_(samples), options_(options) {}

  EdgeMeasurement run();

 private:
  bool refuse(EdgeReason reason) {
    out_.reasons.push_back(reason);
    return false;
  }
  bool begin();
  bool approach();
  bool check_region();
  bool fit();
  void tell();

  void place(const EdgeLine& line);
  [[nodiscard]] bool settle(double reach, int most_rounds, int n_shape, bool with_along);
  void choose_shape();
  [[nodiscard]] ProfileFunction gaussian() const;
  [[nodiscard]] ProfileFunction fitted() const;
  [[nodiscard]] NormalCosines cosines() const;
  [[nodiscard]] PixelModel with_levels() const;
  void weigh_edge();
  void follow_lines();
  void weigh_sides(const ProfileFunction& profile);
  std::vector<ProfileSample> gather();
  [[nodiscard]] double contrast() const {
    return std::abs(model_.levels.bright - model_.levels.dark);
  }

  Span2D<const float> samples_;
  EdgeOptions options_;
  EdgeMeasurement out_;
  PixelModel model_;
  std::vector<unsigned char> used_;
  double width_ = 1;  // Gaussian width of the edge
  double rms_ = 0;    // of the residuals to the Gaussian edge
  double cell_ = 1;
  int n_shape_ = 0;
  double plateau_noise_ = 0;        // of the noisier side, in units of the samples
  std::vector<double> line_shift_;  // of the edge, by line of pixels; empty: none
  double edge_noise_ = 0;           // variance of the place of the edge over that of a sample
  double dark_weight_ = 1, bright_weight_ = 1;
  std::optional<ProfileFit> fit_;
  std::vector<ProfileSample> gathered_;
};

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
    // A third of what noise alone moves it by.
    const double limit =
        3e-4 + 0.5 * fit_->noise() * std::sqrt(3.5 * width_ / model_.line.half_length_px);
    if (!stepped || moved < limit) break;
    model_ = model;
    model_.levels.dark_across = model_.levels.bright_across = 0;
    place(model_.line);
  }
  return true;
}

void EdgeWork::tell() {
  const ProfileFit& f = *fit_;
  const double whole = contrast();
  const ProfileFit::Levels levels = f.levels();
  out_.dark = model_.levels.dark + whole * levels.dark;
  out_.bright = model_.levels.bright + whole * levels.bright;
  out_.dark_shading = levels.dark_across;
  out_.bright_shading = levels.bright_across;
  out_.along_shading =
      std::max(std::abs(model_.levels.dark_along), std::abs(model_.levels.bright_along)) / whole;
  out_.noise = f.noise();
  out_.optics = f.optics();
  out_.optics_parameters = f.parameters();
  const ProfileMember& m = f.best();
  for (std::size_t k = 0; k < f.parameters().size(); ++k) {
    std::vector<double> unit(m.beta.size());
    unit[2 + k] = 1;
    m.precision->solve(unit);
    out_.optics_sd.push_back(std::sqrt(std::max(0.0, unit[2 + k])));
    parameter(out_.optics, f.parameters()[k]) += m.beta[2 + k];
  }
  out_.residual_share = f.residual_share();
  out_.mtf = transfer_of(f, gathered_, options_.window_px);
  // The squared slope of the edge, summed across it, is the squared transfer summed over frequency.
  double squared_slope = 0;
  for (const MtfPoint& p : out_.mtf.all.points) {
    squared_slope += 2 * kMtfStepCyPerPx * p.value * p.value;
  }
  const double length = std::max(1.0, out_.length_px);
  // Places of lines wander together over a few lines.
  const double together = std::sqrt((1 + std::clamp(out_.mtf.line_correlation, 0.0, 0.9)) /
                                    (1 - std::clamp(out_.mtf.line_correlation, 0.0, 0.9)));
  out_.offset_sd_px =
      std::hypot(out_.noise * out_.mtf.inflation / std::sqrt(squared_slope * length),
                 together * out_.wander_px / std::sqrt(length));
  out_.angle_sd_deg = out_.offset_sd_px * std::sqrt(12.0) / length * 180 / pi;
  std::size_t left_out = 0;
  for (const unsigned char u : used_) left_out += u == 0 ? 1 : 0;
  out_.left_out = double(left_out) / double(used_.size());
  if (left_out > 0 && !out_.has(EdgeReason::kLeftOut)) out_.reasons.push_back(EdgeReason::kLeftOut);
  if (!f.options().residual) out_.reasons.push_back(EdgeReason::kPhaseCoverage);
  if (!out_.mtf.all.mtf50) out_.reasons.push_back(EdgeReason::kNotReached);
  if (m.shading) out_.reasons.push_back(EdgeReason::kShading);
  if (n_shape_ > 0) out_.reasons.push_back(EdgeReason::kBent);
  if (out_.mtf.inflation > 1.35) out_.reasons.push_back(EdgeReason::kCorrelatedNoise);
  if (out_.residual_share > 0.9) out_.reasons.push_back(EdgeReason::kResidual);
  if (!options_.with_profile) return;
  out_.bins = f.bins();
  out_.places = line_places(gathered_, f, model_.line, line_shift_, width_);
  constexpr double kPerPx = 8;
  const auto n = static_cast<std::size_t>(2 * f.reach_px() * kPerPx) + 1;
  out_.profile.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    ProfilePlotPoint& p = out_.profile[i];
    p.d_px = (double(i) - double(n - 1) / 2) / kPerPx;
    p.esf = f.value(p.d_px);
    p.lsf = f.slope(p.d_px);
  }
  for (const ProfileSample& s : gathered_) {
    const double at = s.distance * kPerPx + double(n - 1) / 2 + 0.5;
    if (at < 0 || at >= double(n)) continue;
    ProfilePlotPoint& p = out_.profile[static_cast<std::size_t>(at)];
    p.measured += s.value;
    p.n += 1;
  }
  for (ProfilePlotPoint& p : out_.profile) {
    if (p.n > 0) p.measured /= p.n;
  }
}

EdgeMeasurement EdgeWork::run() {
  bool good = begin() && approach() && check_region();
  if (good) {
    weigh_sides(gaussian());
    const ClipFinding clip = find_clipping(samples_, model_, options_, width_, plateau_noise_);
    out_.clipped = clip.share;
    if (clip.clipped) good = refuse(EdgeReason::kClipped);
  }
  good = good && fit();
  const EdgeLine& line = model_.line;
  out_.line = line;
  out_.normal_deg = std::remainder(line.normal_rad * 180 / pi, 360.0);
  out_.angle_deg = std::abs(std::remainder(line.normal_rad * 180 / pi, 90.0));
  if (good) {
    // A profile that overshoots or wavers this much belongs to something else than one edge.
    double low = 0, high = 0, variation = 0, before = 0;
    for (double d = -fit_->reach_px(); d <= fit_->reach_px(); d += 0.25) {
      const double e = fit_->value(d);
      low = std::min(low, e);
      high = std::max(high, e);
      variation += std::abs(e - before);
      before = e;
    }
    if (low < -0.4 || high > 1.4 || variation > 2.6) good = refuse(EdgeReason::kNotAnEdge);
  }
  if (good) {
    const double uneven =
        uneven_share(samples_, with_levels(), fitted(), 0.12, fit_->noise() * contrast());
    if (uneven > 0.15) {
      good = refuse(EdgeReason::kNotAnEdge);
    } else if (uneven > 0.08) {
      out_.reasons.push_back(EdgeReason::kUneven);
    }
  }
  if (good) {
    tell();
    out_.status = EdgeStatus::kOk;
    for (const EdgeReason r : out_.reasons) {
      if (severity(r) == EdgeStatus::kDoubtful) out_.status = EdgeStatus::kDoubtful;
    }
  } else {
    out_.status = EdgeStatus::kRefused;
  }
  return out_;
}

}  // namespace

bool EdgeMeasurement::has(EdgeReason reason) const {
  return std::find(reasons.begin(), reasons.end(), reason) != reasons.end();
}

EdgeMeasurement measure_edge(Span2D<const float> samples, const EdgeOptions& options) {
  return EdgeWork(samples, options).run();
}

}  // namespace reseau
