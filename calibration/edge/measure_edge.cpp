#include "calibration/edge/measure_edge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

#include "calibration/edge/edge_checks.h"
#include "calibration/edge/edge_work.h"
#include "calibration/edge/line_places.h"
#include "calibration/edge/pixel_fit.h"

namespace reseau::edge {
namespace {

using std::numbers::pi;

}  // namespace

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
  // With its last levels it must rise out of the noise still.
  constexpr double kLeastRise = 10;
  const double pixels = 0.5 * std::min(double(samples_.width()) * double(samples_.height()),
                                       2 * model_.reach_px * out_.length_px);
  if (good && kLeastRise * fit_->noise() * std::sqrt(2 / std::max(4.0, 0.5 * pixels)) > 1) {
    good = refuse(EdgeReason::kNoContrast);
  }
  // Beyond the reach as well: a second edge, or none at all where both levels are made up.
  constexpr double kOtherEdge = 0.08;
  if (good && other_level_share(samples_, with_levels(), 4 * width_ + 3,
                                fit_->noise() * contrast()) > kOtherEdge) {
    good = refuse(EdgeReason::kNotAnEdge);
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
}  // namespace reseau::edge

namespace reseau {

bool EdgeMeasurement::has(EdgeReason reason) const {
  return std::find(reasons.begin(), reasons.end(), reason) != reasons.end();
}

EdgeMeasurement measure_edge(Span2D<const float> samples, const EdgeOptions& options) {
  return edge::EdgeWork(samples, options).run();
}

}  // namespace reseau
