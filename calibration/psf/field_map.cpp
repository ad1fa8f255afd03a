#include "calibration/psf/field_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Core>
#include <Eigen/LU>

namespace reseau {
namespace {

constexpr std::array<Eigen::Index, 3> kTerms{1, 3, 6};

}  // namespace

std::optional<Measured> extra_variance(const EdgeOptics& shared, const NormalCosines& normal,
                                       double mtf50_cy_per_px, double mtf50_sd, double slope) {
  const double f = mtf50_cy_per_px;
  const double model = transfer(shared, normal, f);
  if (!(f > 0) || !(model > 0)) return std::nullopt;
  const double scale = 2 * std::numbers::pi * std::numbers::pi * f * f;
  // ln M falls by scale times the variance; the place of one half is as unsure as M over its slope.
  const Measured out{std::log(model / 0.5) / scale, std::abs(slope) * mtf50_sd / 0.5 / scale};
  if (!std::isfinite(out.value) || !(out.sd > 0)) return std::nullopt;
  return out;
}

std::optional<FieldRecord> fit_field(std::span<const FieldSample> samples) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  std::optional<FieldRecord> best;
  double best_cost = 0;
  for (int order = 0; order < static_cast<int>(kTerms.size()); ++order) {
    const Eigen::Index terms = kTerms[static_cast<std::size_t>(order)];
    if (n < (order == 0 ? 1 : terms + 2)) break;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(terms, terms);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(terms);
    const auto row_of = [&](const FieldSample& s) {
      Eigen::VectorXd row(6);
      row << 1, s.x, s.y, s.x * s.x, s.x * s.y, s.y * s.y;
      return Eigen::VectorXd(row.head(terms));
    };
    for (const FieldSample& s : samples) {
      const Eigen::VectorXd row = row_of(s);
      normal += row * row.transpose() / (s.sd * s.sd);
      right += row * s.value / (s.sd * s.sd);
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> solver(normal);
    if (!solver.isInvertible()) break;
    const Eigen::VectorXd solution = solver.solve(right);
    double chi2 = 0;
    for (const FieldSample& s : samples) {
      chi2 += std::pow((s.value - row_of(s).dot(solution)) / s.sd, 2);
    }
    const double freedom = static_cast<double>(n - terms);
    const double scatter = freedom > 0 ? std::max(1.0, chi2 / freedom) : 1.0;
    // The scatter of the samples is not known beforehand: n ln(chi2) as for unknown noise.
    const double count = static_cast<double>(n);
    const double cost = count * std::log(std::max(chi2, freedom) + 1e-12) +
                        static_cast<double>(terms) * std::log(count);
    if (best && cost >= best_cost) continue;
    best_cost = cost;
    const Eigen::MatrixXd covariance = scatter * solver.inverse();
    FieldRecord record;
    record.order = order;
    record.coefficients.assign(solution.data(), solution.data() + terms);
    for (Eigen::Index i = 0; i < terms; ++i) {
      for (Eigen::Index k = 0; k < terms; ++k) record.covariance.push_back(covariance(i, k));
    }
    best = std::move(record);
  }
  if (best) {
    for (const FieldSample& s : samples) best->places.push_back({s.x, s.y, s.value, s.sd});
  }
  return best;
}

}  // namespace reseau
