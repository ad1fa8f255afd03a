// What a fitted profile says.
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "calibration/edge/profile_fit.h"
#include "calibration/edge/profile_system.h"

namespace reseau {
namespace {

using profile::kShadingSd;
using profile::sum_of_squares;

}  // namespace

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
    out[2 + k] = x[2 + k] / sum_of_squares(prior_sd(parameters_[k], m.prior));
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
