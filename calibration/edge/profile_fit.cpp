#include "calibration/edge/profile_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "calibration/edge/profile_system.h"
#include "core/base/check.h"

namespace reseau {
namespace {

using profile::within;

constexpr double kLeastShading = 0.012;  // of the contrast per reach
constexpr double kClean = 2e-3;          // noise of the contrast below which far minima show
constexpr double kMisfit = 8;            // gain in -2 log likelihood that calls for more physics

}  // namespace

template <typename Slope>
void ProfileFit::measure_scatter(Slope slope) {
  scatter_ = scatter_freedom_ = 0;
  for (const ProfileBins::Bin& bin : bins_) {
    scatter_ += std::max(0.0, bin.scatter(slope(bin.distance)));
    scatter_freedom_ += bin.freedom;
  }
}

// The scatter within the bins knows the noise whatever the profile is; where there are few samples,
// a generous fit of the profile helps.
void ProfileFit::settle_noise(const System& s) {
  const double least = options_.least_noise;
  double squares = scatter_, freedom = scatter_freedom_;
  if (freedom < 400) {
    const std::vector<ProfileMember> members = judge(s);
    if (!members.empty()) {
      const ProfileMember& m = members.front();
      // Effective number of parameters and sum of squares of this member.
      std::vector<double> unit;
      const std::size_t p = m.beta.size();
      const std::size_t dense = 2 + s.parameters.size() + (m.shading ? 2 : 0);
      const auto index = [&](std::size_t i) { return i < dense ? i : s.n_fixed + (i - dense); };
      double used = 0, fit = s.squares;
      for (std::size_t j = 0; j < p; ++j) {
        unit.assign(p, 0);
        double pull = 0;
        for (std::size_t i = 0; i < p; ++i) {
          const std::size_t a = std::max(index(i), index(j)), b = std::min(index(i), index(j));
          unit[i] = s.normal(a, b);
          pull += unit[i] * m.beta[i];
        }
        fit += m.beta[j] * (pull - 2 * s.g[index(j)]);
        m.precision->solve(unit);
        used += unit[j] / (noise_ * noise_);
      }
      squares = scatter_ + std::max(0.0, fit);
      freedom = std::max(5.0, n_ - used);
    }
  }
  noise_ = std::max(least, std::sqrt(squares / std::max(1.0, freedom)));
}

void ProfileFit::solve(const EdgeOptics& optics, const std::vector<int>& parameters) {
  optics_ = optics;
  parameters_ = parameters;
  for (int round = 0; round < 8; ++round) {
    const System s = system(optics_, parameters_);
    if (round < 2 && scatter_freedom_ < 400) settle_noise(s);
    members_ = judge(s);
    if (members_.empty()) return;
    // So little shading cannot be told from the tails of the profile, to which it belongs then.
    if (members_.front().shading) {
      const Levels l = levels();
      if (std::max(std::abs(l.dark_across), std::abs(l.bright_across)) < kLeastShading) {
        options_.shading_across = false;
        members_ = judge(s);
        if (members_.empty()) return;
      }
    }
    double moved = 0;
    EdgeOptics next = optics_;
    // A lens that makes the tails darker is none: what does that is left to the others.
    if (parameters_.front() == kDiffraction &&
        optics_.diffraction_px + members_.front().beta[2] < -0.3 * options_.width_px) {
      optics_.diffraction_px = 0;
      parameters_.erase(parameters_.begin());
      continue;
    }
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      const double step = members_.front().beta[2 + k];
      double& value = parameter(next, parameters_[k]);
      value = within(parameters_[k], value + step, options_.width_px);
      moved = std::max(moved, std::abs(step) / prior_sd(parameters_[k]));
    }
    if (moved < 0.03 || round == 7) break;
    optics_ = next;
  }
  mean_ = std::make_shared<MeanProfile>(optics_, options_.normal, options_.reach_px, parameters_);
}

ProfileFit::ProfileFit(const ProfileBins& bins, const ProfileFitOptions& options,
                       const std::optional<EdgeOptics>& start)
    : options_(options), bins_(bins.bins()), n_(bins.count()) {
  if (bins_.size() < 12) return;
  const double width = std::max(0.15, options_.width_px);
  measure_scatter([width](double d) {
    return std::exp(-0.5 * d * d / (width * width)) / (width * std::sqrt(2 * std::numbers::pi));
  });
  const double spacing = std::max(0.15, 0.35 * width);
  spline_ = std::make_shared<ResidualSpline>(spacing, std::max(2.0, 4 * width),
                                             std::max(options_.reach_px, 5 * spacing));
  auto rough = std::make_shared<Symmetric>(spline_->roughness(width));
  const Cholesky rough_factor(*rough);
  CHECK(rough_factor.ok());
  roughness_log_det_ = rough_factor.log_determinant();
  roughness_ = std::move(rough);
  noise_ = std::max(options_.least_noise,
                    scatter_freedom_ >= 20 ? std::sqrt(scatter_ / scatter_freedom_) : 0.01);

  std::vector<int> base = {kDiffraction, kSigma2, kAperture2};
  EdgeOptics optics;
  if (start) {
    optics = *start;
    if (optics.smear2_px2 != 0) base.push_back(kSmear2);
    if (optics.w20_waves != 0) base.push_back(kW20);
    if (optics.halo != 0) base.insert(base.end(), {kHalo, kHaloSigma});
    fit_optics(optics, base, 6);
  } else {
    optics.diffraction_px = 0.7 * width;
    optics.sigma2_px2 = 0.4 * width * width;
    optics.aperture2_px2 = 2.5 * width * width;
    fit_optics(optics, base, 12);
  }
  mean_ = std::make_shared<MeanProfile>(optics, options_.normal, options_.reach_px, base);
  const double guess = noise_;
  const auto settle = [this] {
    measure_scatter([this](double d) { return members_.empty() ? mean_->slope(d) : slope(d); });
    if (scatter_freedom_ >= 20) {
      noise_ = std::max(options_.least_noise, std::sqrt(scatter_ / scatter_freedom_));
    }
  };
  settle();
  if (noise_ < 0.7 * guess) {
    fit_optics(optics, base, 12);
    mean_ = std::make_shared<MeanProfile>(optics, options_.normal, options_.reach_px, base);
    settle();
  }
  solve(optics, base);
  if (members_.empty()) return;
  const double noise_before = noise_;
  settle();
  if (noise_ < 0.8 * noise_before) solve(optics_, base);
  if (members_.empty() || start) return;

  // More physics where it says more than the spline does.
  // Where no spline can be told, nothing else would show that physics is missing; along the grid
  // itself too few places of the profile are seen to tell more of it.
  constexpr int kLeastPlaces = 6;
  const auto on_slope = std::count_if(bins_.begin(), bins_.end(), [](const ProfileBins::Bin& bin) {
    return std::abs(bin.distance) < 1.5;
  });
  const bool untold = !options_.residual && on_slope >= kLeastPlaces;
  const auto misfit = [this, untold] {
    return ok() && (untold || (best().tau > 0.01 && residual_share() > 0.9));
  };
  for (int extension = 0; extension < 2 && misfit(); ++extension) {
    const ProfileFit before = *this;
    double least = best().criterion - kMisfit;
    ProfileFit chosen = before;
    bool found = false;
    // Least squares alone say which two are worth a full look.
    struct Candidate {
      EdgeOptics optics;
      std::vector<int> parameters;
      double squares;
    };
    std::vector<Candidate> candidates;
    const auto add = [&](const EdgeOptics& from, std::initializer_list<int> added) {
      std::vector<int> more = before.parameters_;
      for (const int p : added) {
        if (std::find(more.begin(), more.end(), p) != more.end()) return;
        more.push_back(p);
      }
      Candidate candidate{from, more, 0};
      candidate.squares = fit_optics(candidate.optics, more, 14);
      candidates.push_back(candidate);
    };
    EdgeOptics sane = before.optics_;
    sane.diffraction_px = std::max(0.3 * width, sane.diffraction_px);
    sane.sigma2_px2 = std::max(0.05 * width * width, sane.sigma2_px2);
    sane.aperture2_px2 = std::clamp(sane.aperture2_px2, 0.5 * width * width, 9 * width * width);
    for (const double w20 : {0.3, 0.7}) {
      EdgeOptics from = sane;
      from.w20_waves = w20;
      from.diffraction_px = std::max(0.6 * width, 0.7 * from.diffraction_px);
      from.sigma2_px2 *= 0.3;
      from.aperture2_px2 = std::min(from.aperture2_px2, 2.0);
      add(from, {kW20});
    }
    // Along the ways in which aperture, Gaussian and what is added stand in for each other the fit
    // of all may end far away: without the first two, with pixels as wide as they lie apart, it
    // shows where to begin. In noise none of that is seen, and the best of more trials would claim
    // too much.
    const auto add_to_full_pixels = [&](const EdgeOptics& near, std::initializer_list<int> added) {
      std::vector<int> few = {kDiffraction};
      few.insert(few.end(), added.begin(), added.end());
      EdgeOptics alone = near;
      alone.sigma2_px2 = 0;
      alone.aperture2_px2 = 1;
      fit_optics(alone, few, 20);
      add(alone, added);
    };
    if (noise_ < kClean) {
      EdgeOptics plain;
      plain.diffraction_px = 0.7 * width;
      plain.w20_waves = 0.5;
      add_to_full_pixels(plain, {kW20});
      plain.diffraction_px = 0.45 * width;
      plain.w20_waves = 1;
      add_to_full_pixels(plain, {kW20});
      plain.w20_waves = 0;
      plain.halo = 0.08;
      plain.halo_sigma_px = 6 * width;
      add_to_full_pixels(plain, {kHalo, kHaloSigma});
      plain.diffraction_px = width;
      plain.halo = -0.3;
      plain.halo_sigma_px = 2 * width;
      add_to_full_pixels(plain, {kHalo, kHaloSigma});
    }
    EdgeOptics from = sane;
    from.smear2_px2 = from.aperture2_px2 = 0.5 * std::max(0.5, from.aperture2_px2);
    add(from, {kSmear2});
    from = sane;
    from.halo = 0.08;
    from.halo_sigma_px = 6 * width;
    from.diffraction_px *= 0.5;
    add(from, {kHalo, kHaloSigma});
    from.diffraction_px = sane.diffraction_px;
    from.halo = -0.2;
    from.halo_sigma_px = 2 * width;
    add(from, {kHalo, kHaloSigma});
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.squares < b.squares; });
    for (std::size_t i = 0; i < std::min<std::size_t>(2, candidates.size()); ++i) {
      ProfileFit candidate = before;
      candidate.solve(candidates[i].optics, candidates[i].parameters);
      if (candidate.ok() && candidate.best().criterion < least) {
        least = candidate.best().criterion;
        chosen = candidate;
        found = true;
      }
    }
    if (!found) break;
    *this = chosen;
  }
}
}  // namespace reseau
