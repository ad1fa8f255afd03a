#include "calibration/edge/profile_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/check.h"

namespace reseau {
namespace {

// Standard deviation of the residual near the edge, in shares of the contrast, roughly.
constexpr std::array<double, 9> kTau = {0, 0.0015, 0.005, 0.015, 0.05, 0.15, 0.5, 2, 8};
constexpr double kShadingSd = 0.4;       // of the contrast per reach
constexpr double kShadingPrior = 0.1;    // that there is shading across
constexpr double kLeastShading = 0.012;  // of the contrast per reach
constexpr double kNoResidualPrior = 0.5;
constexpr double kMisfit = 8;  // gain in -2 log likelihood that calls for more physics
constexpr double kLeastWeight = 0.01;

double sum_of_squares(double a) { return a * a; }

// Where a parameter means something; what leaves it is brought back.
double within(int parameter, double value, double width) {
  switch (parameter) {
    case kDiffraction:
      return std::clamp(value, -0.3 * width, 12 * width + 2);
    case kSigma2:
      return std::clamp(value, -0.5 * width * width, 6 * width * width);
    case kAperture2:
      return std::clamp(value, -3 * width * width, 24 * width * width);
    case kSmear2:
      return std::clamp(value, -3 * width * width, 24 * width * width);
    case kW20:
      return std::clamp(value, -2.5, 2.5);
    case kHalo:
      return std::clamp(value, -0.6, 0.6);
    default:
      return std::clamp(value, 1.5 * width, 40 * width);
  }
}

}  // namespace

struct ProfileFit::System {
  std::vector<int> parameters;
  EdgeOptics optics;
  // Levels, optics, shading, spline.
  Symmetric normal;
  std::vector<double> g;
  double squares = 0;  // weighted, of the residuals, between the bins
  std::size_t n_fixed = 0;
};

double ProfileFit::prior_mean(int parameter) const {
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

double ProfileFit::prior_sd(int parameter) const {
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
    for (const double tau : kTau) {
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
      member.shading = shading;
      member.beta.resize(p);
      double criterion = s.squares * precision;
      for (std::size_t i = 0; i < p; ++i) {
        for (std::size_t j = 0; j <= i; ++j) h(i, j) = s.normal(index[i], index[j]) * precision;
        member.beta[i] = s.g[index[i]] * precision;
      }
      for (std::size_t k = 0; k < np; ++k) {
        const double q = 1 / sum_of_squares(prior_sd(s.parameters[k]));
        const double off = prior_mean(s.parameters[k]) - parameter(s.optics, s.parameters[k]);
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
      }
      auto factor = std::make_shared<Cholesky>(h);
      if (!factor->ok()) continue;
      factor->forward(member.beta);
      criterion += factor->log_determinant() - dot(member.beta, member.beta);
      member.criterion = criterion;
      member.precision = std::move(factor);
      if (criterion > least) {
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

ProfileFit::Row ProfileFit::row(double d, const ProfileMember& member) const {
  Row out;
  const MeanProfile::At e = mean_->at(d);
  out.mean = e.value;
  std::size_t n = 0;
  out.dense[n++] = 1 - e.value;
  out.dense[n++] = e.value;
  for (std::size_t k = 0; k < parameters_.size(); ++k) out.dense[n++] = e.by_parameter[k];
  if (member.shading) {
    const double a = d / options_.reach_px;
    out.dense[n++] = (1 - e.value) * a;
    out.dense[n++] = e.value * a;
  }
  out.n_dense = n;
  if (member.tau > 0) out.spline = spline_->at(d);
  return out;
}

double ProfileFit::value(double d) const {
  const ProfileMember& m = best();
  double sum = mean_->value(d, std::span(m.beta).subspan(2, parameters_.size()));
  if (m.tau > 0) {
    sum += spline_->value(std::span(m.beta).subspan(first_spline(m)), d);
  }
  return sum;
}

double ProfileFit::slope(double d) const {
  const ProfileMember& m = best();
  double sum = mean_->slope(d, std::span(m.beta).subspan(2, parameters_.size()));
  if (m.tau > 0) {
    sum += spline_->value(std::span(m.beta).subspan(first_spline(m)), d, 1);
  }
  return sum;
}

double ProfileFit::fitted(double d) const {
  const ProfileMember& m = best();
  const Row r = row(d, m);
  double sum = r.mean + dot({r.dense.data(), r.n_dense}, std::span(m.beta).first(r.n_dense));
  for (std::size_t i = 0; i < r.spline.count; ++i) {
    sum += r.spline.value[i] * m.beta[first_spline(m) + r.spline.first + i];
  }
  return sum;
}

ProfileFit::Levels ProfileFit::levels() const {
  const ProfileMember& m = best();
  Levels out{m.beta[0], m.beta[1], 0, 0};
  if (m.shading) {
    out.dark_across = m.beta[first_shading()];
    out.bright_across = m.beta[first_shading() + 1];
  }
  return out;
}

void ProfileFit::prior_times(const ProfileMember& m, std::span<const double> x,
                             std::span<double> out) const {
  std::fill(out.begin(), out.end(), 0.0);
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    out[2 + k] = x[2 + k] / sum_of_squares(prior_sd(parameters_[k]));
  }
  if (m.shading) {
    for (std::size_t i = first_shading(); i < first_shading() + 2; ++i) {
      out[i] = x[i] / sum_of_squares(kShadingSd);
    }
  }
  if (m.tau > 0) {
    const std::size_t first = first_spline(m);
    const double q = 1 / (m.tau * m.tau);
    for (std::size_t i = 0; i < spline_->size(); ++i) {
      out[first + i] = q * dot(roughness_->row(i), x.subspan(first));
    }
  }
}

double ProfileFit::residual_share() const {
  double sum = 0;
  for (const ProfileMember& m : members_) {
    if (m.tau > 0) sum += m.weight;
  }
  return sum;
}

}  // namespace reseau
