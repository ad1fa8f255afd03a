#include "calibration/gate/gate_response.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/QR>

namespace reseau::gate {
namespace {

// Exposures are set in whole ticks of the unit, and a mean over many samples is surer than that.
constexpr double kSurest = 1e-7;
// A channel's exposure that others and a constant explain to this share of it tells nothing.
constexpr double kIndependent = 0.02;

struct Line {
  Eigen::VectorXd solution;
  Eigen::MatrixXd covariance;
  Eigen::VectorXd rest;
  double freedom = 0;
};

// Weighted least squares; the covariance grows where the points scatter more than they claim.
Line solve(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y, const Eigen::VectorXd& sd) {
  Eigen::MatrixXd a = columns;
  Eigen::VectorXd b = y;
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    a.row(i) /= sd[i];
    b[i] /= sd[i];
  }
  Line out;
  out.solution = a.colPivHouseholderQr().solve(b);
  out.rest = y - columns * out.solution;
  out.freedom = static_cast<double>(y.size() - columns.cols());
  const double chi2 = (b - a * out.solution).squaredNorm();
  const double inflation = out.freedom > 0 ? std::max(1.0, chi2 / out.freedom) : 1.0;
  const Eigen::MatrixXd normal = a.transpose() * a;
  out.covariance = inflation * normal.colPivHouseholderQr().solve(
                                   Eigen::MatrixXd::Identity(columns.cols(), columns.cols()));
  return out;
}

bool independent(const Eigen::MatrixXd& columns, const Eigen::VectorXd& another) {
  const Eigen::VectorXd explained = columns * columns.colPivHouseholderQr().solve(another);
  return (another - explained).norm() > kIndependent * another.norm();
}

}  // namespace

void fit_response(const std::vector<Exposed>& scans, std::size_t channel,
                  const std::array<std::optional<double>, kGateChannels>& first, GateChannel& out) {
  const auto n = static_cast<Eigen::Index>(scans.size());
  if (n < 2) return;
  Eigen::VectorXd y(n), sd(n);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Ones(n, 1);
  std::vector<std::size_t> sources;
  const auto exposures_of = [&](std::size_t k) -> std::optional<Eigen::VectorXd> {
    Eigen::VectorXd e(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& us = scans[static_cast<std::size_t>(i)].exposure_us[k];
      if (!us) return std::nullopt;
      e[i] = *us;
    }
    const double most = e.cwiseAbs().maxCoeff();
    if (!(most > 0)) return std::nullopt;
    return e;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const Exposed& scan = scans[static_cast<std::size_t>(i)];
    y[i] = scan.level;
    sd[i] = std::max(scan.level_sd, kSurest);
  }
  const auto add = [&](std::size_t k) {
    const auto e = exposures_of(k);
    // One point more than unknowns, so that the scatter is known.
    if (!e || n < columns.cols() + 1 || !independent(columns, *e)) return;
    columns.conservativeResize(n, columns.cols() + 1);
    columns.col(columns.cols() - 1) = *e;
    sources.push_back(k);
  };
  add(channel);
  if (sources.empty()) return;
  for (std::size_t k = 0; k < kGateChannels; ++k) {
    if (k != channel && n > columns.cols() + 1) add(k);
  }
  const Line line = solve(columns, y, sd);
  out.dark = Measured{line.solution[0], std::sqrt(std::max(0.0, line.covariance(0, 0)))};
  if (line.freedom > 0) {
    Eigen::Index worst = 0;
    const double most = line.rest.cwiseAbs().maxCoeff(&worst);
    out.nonlinearity = Measured{most, sd[worst]};
  }
  const double own = first[channel] ? line.solution[1] * *first[channel] : 0;
  if (!(own > 0)) return;
  for (std::size_t s = 1; s < sources.size(); ++s) {
    const auto& other = first[sources[s]];
    if (!other) continue;
    const auto at = static_cast<Eigen::Index>(s + 1);
    out.leakage[sources[s]] =
        Measured{line.solution[at] * *other / own,
                 std::sqrt(std::max(0.0, line.covariance(at, at))) * *other / own};
  }
}

std::optional<GateNoise> fit_noise(const std::vector<GateLevel>& levels, double dark) {
  std::vector<const GateLevel*> used;
  double lowest = 1e9, highest = -1e9;
  for (const GateLevel& level : levels) {
    if (level.clipped || !(level.variance > 0)) continue;
    used.push_back(&level);
    lowest = std::min(lowest, level.level);
    highest = std::max(highest, level.level);
  }
  constexpr double kApart = 1.5;  // the brightest over the darkest
  if (used.size() < 2 || highest - dark < kApart * (lowest - dark)) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd columns(n, 2);
  Eigen::VectorXd y(n), sd(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const GateLevel& level = *used[static_cast<std::size_t>(i)];
    columns(i, 0) = 1;
    columns(i, 1) = level.level - dark;
    y[i] = level.variance;
    sd[i] = level.variance_sd;
  }
  const Line line = solve(columns, y, sd);
  GateNoise out;
  // Neither can be negative; a little below is what noise makes of zero.
  out.read = std::max(0.0, line.solution[0]);
  out.shot = std::max(0.0, line.solution[1]);
  out.read_variance = line.covariance(0, 0);
  out.covariance = line.covariance(0, 1);
  out.shot_variance = line.covariance(1, 1);
  return out;
}

}  // namespace reseau::gate
