// Normal equations of the profile, and how likely each of its members is.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "calibration/edge/profile_fit.h"
#include "calibration/edge/profile_system.h"
#include "core/base/check.h"

namespace reseau {
namespace {

using profile::kShadingSd;
using profile::sum_of_squares;
using profile::within;

// Standard deviation of the residual near the edge, in shares of the contrast, roughly.
constexpr std::array<double, 9> kTau = {0, 0.0015, 0.005, 0.015, 0.05, 0.15, 0.5, 2, 8};
constexpr double kShadingPrior = 0.1;  // that there is shading across
constexpr double kNoResidualPrior = 0.5;
constexpr double kLeastWeight = 0.01;
constexpr double kSimplePrior = 0.1;  // that optics are full pixels, or a Gaussian
constexpr double kSettledSd = 1e-3;   // of what simple optics settle [px, px^2]

struct Variant {
  double tau;
  OpticsPrior prior;
};

// What simple optics leave no choice about. Three free widths say more about the noise than about
// the optics where two or one of them explain the edge as well.
bool is_settled(int parameter, OpticsPrior prior) {
  switch (prior) {
    case OpticsPrior::kFullPixels:
      return parameter == kSigma2 || parameter == kAperture2;
    case OpticsPrior::kGaussian:
      return parameter == kDiffraction || parameter == kAperture2;
    default:
      return false;
  }
}

}  // namespace

double ProfileFit::prior_mean(int parameter, OpticsPrior prior) const {
  if (is_settled(parameter, prior))
    return parameter == kAperture2 && prior == OpticsPrior::kFullPixels ? 1 : 0;
  const double w = options_.width_px;
  switch (parameter) {
    case kDiffraction:
      return 0.8 * w;
    case kSigma2:
      return 0.3 * w * w;
    case kAperture2:
      return 3 * w * w;
    case kHaloSigma:
      return 7 * w;
    default:
      return 0;
  }
}

double ProfileFit::prior_sd(int parameter, OpticsPrior prior) const {
  if (is_settled(parameter, prior)) return kSettledSd;
  const double w = options_.width_px;
  switch (parameter) {
    case kDiffraction:
      return 1.2 * w;
    case kSigma2:
      return 0.8 * w * w;
    case kAperture2:
      return 4 * w * w;
    case kSmear2:
      return 4 * w * w;
    case kW20:
      return 0.7;
    case kHalo:
      return 0.15;
    default:
      return 5 * w;
  }
}

double ProfileFit::fit_optics(EdgeOptics& optics, std::span<const int> parameters,
                              int most_rounds) const {
  const std::size_t np = parameters.size(), p = np + 4;
  const double precision = 1 / (noise_ * noise_);
  double damping = 1e-3;
  double best = 1e300;
  EdgeOptics trial = optics;
  Symmetric kept(p);
  std::vector<double> kept_g(p);
  std::vector<double> x(p);
  for (int round = 0; round < most_rounds; ++round) {
    Symmetric normal(p);
    std::vector<double> g(p);
    const MeanProfile mean(trial, options_.normal, options_.reach_px, parameters);
    double squares = 0;
    for (const ProfileBins::Bin& bin : bins_) {
      const MeanProfile::At e = mean.at(bin.distance);
      const double rest = bin.value - e.value;
      const double a = bin.distance / options_.reach_px;
      x[0] = 1 - e.value;
      x[1] = e.value;
      x[2] = x[0] * a;
      x[3] = x[1] * a;
      for (std::size_t k = 0; k < np; ++k) x[4 + k] = e.by_parameter[k];
      const double w = bin.weight * precision;
      squares += w * rest * rest;
      for (std::size_t j = 0; j < p; ++j) {
        const double wx = w * x[j];
        g[j] += wx * rest;
        double* to = &normal.row(j)[0];
        for (std::size_t k = 0; k <= j; ++k) to[k] += wx * x[k];
      }
    }
    for (std::size_t j = 2; j < 4; ++j) normal(j, j) += 1 / sum_of_squares(0.1 * kShadingSd);
    for (std::size_t k = 0; k < np; ++k) {
      const double q = 1 / sum_of_squares(prior_sd(parameters[k]));
      const double off = prior_mean(parameters[k]) - parameter(trial, parameters[k]);
      normal(4 + k, 4 + k) += q;
      g[4 + k] += q * off;
      squares += q * off * off;
    }
    // Levels and shading are solved for at once: what they leave is the measure.
    Symmetric levels(4);
    std::vector<double> gl(g.begin(), g.begin() + 4);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j <= i; ++j) levels(i, j) = normal(i, j);
    }
    const Cholesky level_factor(levels);
    if (!level_factor.ok()) return 1e300;
    level_factor.forward(gl);
    const double now = squares - dot(gl, gl);
    if (now < best) {
      const bool settled = best - now < 1e-3 && round > 0;
      best = now;
      optics = trial;
      kept = normal;
      kept_g = g;
      damping = std::max(1e-9, 0.1 * damping);
      if (settled) break;
    } else {
      damping *= 10;
      if (damping > 1e6 || now - best < 1e-4) break;
    }
    Symmetric damped = kept;
    for (std::size_t k = 4; k < p; ++k) damped(k, k) *= 1 + damping;
    const Cholesky factor(damped);
    if (!factor.ok()) break;
    std::vector<double> step = kept_g;
    factor.solve(step);
    trial = optics;
    for (std::size_t k = 0; k < np; ++k) {
      double& value = parameter(trial, parameters[k]);
      value = within(parameters[k], value + step[4 + k], options_.width_px);
    }
  }
  return best;
}

ProfileFit::System ProfileFit::system(const EdgeOptics& optics,
                                      std::span<const int> parameters) const {
  System out;
  out.parameters.assign(parameters.begin(), parameters.end());
  out.optics = optics;
  const std::size_t np = parameters.size();
  out.n_fixed = 4 + np;
  const std::size_t n_spline = options_.residual ? spline_->size() : 0;
  const std::size_t p = out.n_fixed + n_spline;
  out.normal = Symmetric(p);
  out.g.assign(p, 0);
  const MeanProfile mean(optics, options_.normal, options_.reach_px, parameters);
  std::array<double, 4 + kOpticsParameters> x{};
  for (const ProfileBins::Bin& bin : bins_) {
    const MeanProfile::At e = mean.at(bin.distance);
    const double rest = bin.value - e.value;
    const double a = bin.distance / options_.reach_px;
    x[0] = 1 - e.value;
    x[1] = e.value;
    for (std::size_t k = 0; k < np; ++k) x[2 + k] = e.by_parameter[k];
    x[2 + np] = x[0] * a;
    x[3 + np] = x[1] * a;
    const double w = bin.weight;
    out.squares += w * rest * rest;
    for (std::size_t j = 0; j < out.n_fixed; ++j) {
      const double wx = w * x[j];
      out.g[j] += wx * rest;
      double* to = &out.normal.row(j)[0];
      for (std::size_t k = 0; k <= j; ++k) to[k] += wx * x[k];
    }
    if (n_spline == 0) continue;
    const ResidualSpline::Active active = spline_->at(bin.distance);
    for (std::size_t i = 0; i < active.count; ++i) {
      const std::size_t j = out.n_fixed + active.first + i;
      const double wx = w * active.value[i];
      out.g[j] += wx * rest;
      double* to = &out.normal.row(j)[0];
      for (std::size_t k = 0; k < out.n_fixed; ++k) to[k] += wx * x[k];
      double* band = to + out.n_fixed + active.first;
      for (std::size_t k = 0; k <= i; ++k) band[k] += wx * active.value[k];
    }
  }
  return out;
}

// All members, not yet weighted.
std::vector<ProfileMember> ProfileFit::judge(const System& s) const {
  std::vector<ProfileMember> out;
  const std::size_t np = s.parameters.size();
  const double precision = 1 / (noise_ * noise_);
  const std::size_t n_spline = s.normal.size() - s.n_fixed;
  std::vector<std::size_t> index;
  for (const bool shading : {false, true}) {
    if (shading && !options_.shading_across) continue;
    double least = 1e300;
    int falling = 0;
    // Simple optics without a spline: what they do not explain is for free ones.
    std::vector<Variant> variants = {{0, OpticsPrior::kFullPixels}};
    if (np <= 3) variants.push_back({0, OpticsPrior::kGaussian});
    for (const double tau : kTau) variants.push_back({tau, OpticsPrior::kFree});
    for (const auto& [tau, prior] : variants) {
      if (tau > 0 && n_spline == 0) break;
      index.clear();
      const std::size_t dense = 2 + np + (shading ? 2 : 0);
      for (std::size_t i = 0; i < dense; ++i) index.push_back(i);
      if (tau > 0) {
        for (std::size_t i = s.n_fixed; i < s.normal.size(); ++i) index.push_back(i);
      }
      const std::size_t p = index.size();
      Symmetric h(p);
      ProfileMember member;
      member.tau = tau;
      member.prior = prior;
      member.shading = shading;
      member.beta.resize(p);
      double criterion = s.squares * precision;
      for (std::size_t i = 0; i < p; ++i) {
        for (std::size_t j = 0; j <= i; ++j) h(i, j) = s.normal(index[i], index[j]) * precision;
        member.beta[i] = s.g[index[i]] * precision;
      }
      for (std::size_t k = 0; k < np; ++k) {
        const double q = 1 / sum_of_squares(prior_sd(s.parameters[k], prior));
        const double off =
            prior_mean(s.parameters[k], prior) - parameter(s.optics, s.parameters[k]);
        h(2 + k, 2 + k) += q;
        member.beta[2 + k] += q * off;
        criterion += q * off * off - std::log(q);
      }
      if (shading) {
        for (std::size_t i = 2 + np; i < 4 + np; ++i) h(i, i) += 1 / sum_of_squares(kShadingSd);
        criterion += 2 * std::log(sum_of_squares(kShadingSd)) - 2 * std::log(kShadingPrior);
      } else {
        criterion -= 2 * std::log(1 - kShadingPrior);
      }
      if (tau > 0) {
        const double q = 1 / (tau * tau);
        for (std::size_t i = 0; i < n_spline; ++i) {
          for (std::size_t j = 0; j <= i; ++j) {
            h(dense + i, dense + j) += q * (*roughness_)(i, j);
          }
        }
        criterion -= roughness_log_det_ + double(n_spline) * std::log(q);
        criterion -= 2 * std::log((1 - kNoResidualPrior) / double(kTau.size() - 1));
      } else {
        criterion -= 2 * std::log(kNoResidualPrior);
        criterion -=
            2 * std::log(prior == OpticsPrior::kFree ? 1 - 2 * kSimplePrior : kSimplePrior);
      }
      auto factor = std::make_shared<Cholesky>(h);
      if (!factor->ok()) continue;
      factor->forward(member.beta);
      criterion += factor->log_determinant() - dot(member.beta, member.beta);
      member.criterion = criterion;
      member.precision = std::move(factor);
      if (prior != OpticsPrior::kFree) {
        // Says nothing about how the likelihood falls with the spline.
      } else if (criterion > least) {
        ++falling;
      } else {
        falling = 0;
        least = criterion;
      }
      out.push_back(std::move(member));
      // Past the best variance by far.
      if (falling >= 2 && criterion > least + 12) break;
    }
  }
  double best = 1e300;
  for (const ProfileMember& m : out) best = std::min(best, m.criterion);
  double sum = 0;
  for (ProfileMember& m : out) {
    m.weight = std::exp(-0.5 * (m.criterion - best));
    sum += m.weight;
  }
  double kept = 0;
  for (ProfileMember& m : out) {
    m.weight /= sum;
    if (m.weight >= kLeastWeight) kept += m.weight;
  }
  std::erase_if(out, [](const ProfileMember& m) { return m.weight < kLeastWeight; });
  std::stable_sort(out.begin(), out.end(), [](const ProfileMember& a, const ProfileMember& b) {
    return a.weight > b.weight;
  });
  for (ProfileMember& m : out) {
    m.weight /= kept;
    m.precision->backward(m.beta);
  }
  return out;
}
}  // namespace reseau
