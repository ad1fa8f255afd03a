#include "calibration/psf/psf_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <Eigen/Dense>
#include <ceres/crs_matrix.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/types.h>
#include <fmt/format.h>

#include "calibration/edge/mean_profile.h"
#include "calibration/psf/psf_problem.h"

namespace reseau {
namespace {

using psf::Freedom;
using psf::Setup;
using psf::Unknowns;

// Settings of focus that determine a parabola.
constexpr std::size_t kLeastFocusSettings = 3;
// Cosine of the normal from which an edge tells the aperture's side along that axis.
constexpr double kAlongAxis = 0.8;
// Scaled to a unit diagonal, curvatures below this share of the largest are none.
constexpr double kNoCurvature = 1e-9;
constexpr double kCorrelated = 0.95;
constexpr double kNearlyAsGood = 1.05;
constexpr double kCellsPerPx = 8;  // of the residuals that are told

struct Solved {
  Unknowns unknowns;
  double cost = 0;  // half the sum of squares
  bool ok = false;
};

using Stop = std::function<bool()>;

class StopAsked final : public ceres::IterationCallback {
 public:
  explicit StopAsked(const Stop& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return stop_() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Stop& stop_;
};

Solved solve_from(std::span<const PsfEdge> edges, const Freedom& freedom, const Unknowns& start,
                  const Stop& stop) {
  Solved out;
  out.unknowns = start;
  const std::unique_ptr<Setup> setup = psf::set_up(edges, freedom, out.unknowns);
  ceres::Solver::Options options;
  // Each edge has unknowns of its own, which go out first: the work grows with the edges, not with
  // their square.
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-10;
  options.parameter_tolerance = 1e-9;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  StopAsked asked(stop);
  if (stop) options.callbacks.push_back(&asked);
  ceres::Solver::Summary summary;
  ceres::Solve(options, setup->problem.get(), &summary);
  out.cost = summary.final_cost;
  out.ok = summary.IsSolutionUsable() && std::isfinite(out.cost);
  return out;
}

// What the edges say one by one, and a defocus of `waves` for the farthest of them.
Unknowns start_of(std::span<const PsfEdge> edges, const Freedom& freedom, double waves) {
  Unknowns out;
  out.edges.resize(edges.size());
  double aperture2 = 0;
  std::array<double, psf::kChannels> n{}, diffraction{}, sigma2{};
  for (const PsfEdge& e : edges) {
    const auto c = static_cast<std::size_t>(e.channel);
    n[c] += 1;
    diffraction[c] += std::clamp(e.optics.diffraction_px, 0.1, 3.0);
    sigma2[c] += std::clamp(e.optics.sigma2_px2, 0.01, 9.0);
    aperture2 += std::clamp(e.optics.aperture2_px2, 0.3, 9.0);
  }
  out.aperture2 = aperture2 / static_cast<double>(edges.size());
  double farthest = 0;
  for (std::size_t c = 0; c < n.size(); ++c) {
    if (n[c] == 0) continue;
    Unknowns::Channel& channel = out.channels[c];
    channel.diffraction = diffraction[c] / n[c];
    channel.sigma2 = sigma2[c] / n[c];
    channel.best = waves;
    if (!freedom.path_per_step) continue;
    // Where the width, as 1 / MTF50 squared, is least: vertex of a parabola, or the sharpest edge.
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double middle = 0, sharpest = 0, low = INFINITY, high = -INFINITY;
    for (const PsfEdge& e : edges) {
      if (static_cast<std::size_t>(e.channel) != c) continue;
      low = std::min(low, *e.focus);
      high = std::max(high, *e.focus);
      if (e.mtf50_cy_per_px > sharpest) {
        sharpest = e.mtf50_cy_per_px;
        middle = *e.focus;
      }
    }
    const double half = std::max(1e-9, 0.5 * (high - low));
    for (const PsfEdge& e : edges) {
      if (static_cast<std::size_t>(e.channel) != c || !(e.mtf50_cy_per_px > 0)) continue;
      const double x = (*e.focus - middle) / half;
      const Eigen::Vector3d row(1, x, x * x);
      a += row * row.transpose();
      b += row / (e.mtf50_cy_per_px * e.mtf50_cy_per_px);
    }
    const Eigen::Vector3d k = a.ldlt().solve(b);
    channel.best = middle;
    if (k.allFinite() && k[2] > 0) {
      channel.best = std::clamp(middle - half * k[1] / (2 * k[2]), low - half, high + half);
    }
    farthest = std::max({farthest, high - channel.best, channel.best - low});
  }
  // Of a middling wavelength.
  if (freedom.path_per_step) out.path_per_step = 0.6 * waves / std::max(farthest, 1e-9);
  return out;
}

// Defocus is even about focus and has several minima beyond it: the best of several starts.
Solved best_of_starts(std::span<const PsfEdge> edges, const Freedom& freedom, const Stop& stop) {
  Solved best;
  for (const double waves : {0.15, 0.45, 0.9, 1.8}) {
    if (stop && stop()) return {};
    Solved now = solve_from(edges, freedom, start_of(edges, freedom, waves), stop);
    if (now.ok && (!best.ok || now.cost < best.cost)) best = std::move(now);
  }
  // A side that is squared may turn negative, and a wide Gaussian makes up for it: a minimum of its
  // own, which no scanner is in unless its edges say so plainly.
  for (const double aperture2 : {1.0, 4.0}) {
    if (!best.ok || best.unknowns.aperture2 > 0) break;
    Unknowns start = best.unknowns;
    for (Unknowns::Channel& c : start.channels) c.sigma2 += (start.aperture2 - aperture2) / 12;
    start.aperture2 = aperture2;
    Solved now = solve_from(edges, freedom, start, stop);
    if (now.ok && now.unknowns.aperture2 > 0 && now.cost < kNearlyAsGood * best.cost) {
      best = std::move(now);
    }
  }
  return best;
}

// J^T J, row by row: rows know few of the unknowns.
Eigen::MatrixXd squared(const ceres::CRSMatrix& m) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(m.num_cols, m.num_cols);
  for (int r = 0; r < m.num_rows; ++r) {
    const auto begin = static_cast<std::size_t>(m.rows[static_cast<std::size_t>(r)]);
    const auto end = static_cast<std::size_t>(m.rows[static_cast<std::size_t>(r) + 1]);
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t k = begin; k < end; ++k)
        out(m.cols[i], m.cols[k]) += m.values[i] * m.values[k];
    }
  }
  return out;
}

// Curvature of the misfit by the shared parameters, with places and levels of the edges fitted anew
// for each.
Eigen::MatrixXd shared_curvature(Setup& setup, Unknowns& unknowns) {
  ceres::Problem::EvaluateOptions options;
  for (const psf::FreeParameter& p : setup.shared) options.parameter_blocks.push_back(p.value);
  const auto n = static_cast<Eigen::Index>(setup.shared.size());
  for (Unknowns::Edge& e : unknowns.edges) {
    for (double* p : {&e.offset, &e.dark, &e.bright}) options.parameter_blocks.push_back(p);
  }
  ceres::CRSMatrix sparse;
  setup.problem->Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  const Eigen::MatrixXd h = squared(sparse);
  const Eigen::Index m = h.cols() - n;
  const Eigen::MatrixXd own = h.bottomRightCorner(m, m), across = h.topRightCorner(n, m);
  return h.topLeftCorner(n, n) - across * own.ldlt().solve(across.transpose());
}

// Parameters, and what is not determined. Returns their covariance.
Eigen::MatrixXd judge(const Eigen::MatrixXd& curvature, std::span<const psf::FreeParameter> shared,
                      double inflation, PsfFit& out) {
  const Eigen::Index n = curvature.rows();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = std::sqrt(std::max(curvature(i, i), 1e-300));
  Eigen::MatrixXd scaled = curvature;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) scaled(i, k) /= scale[i] * scale[k];
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd unknown = Eigen::VectorXd::Zero(n);
  const double most = std::max(eigen.eigenvalues().maxCoeff(), 1e-300);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(i);
    if (eigen.eigenvalues()[i] > kNoCurvature * most) {
      covariance += v * v.transpose() / eigen.eigenvalues()[i];
      ++out.rank;
    } else {
      unknown += v.cwiseAbs2();
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const psf::FreeParameter& p = shared[static_cast<std::size_t>(i)];
    const double sd = inflation * std::sqrt(std::max(0.0, covariance(i, i))) / scale[i];
    // What a direction without curvature moves is unknown, however small its share of the rest.
    const bool known = unknown[i] < 0.01 && scale[i] > 1e-100 && std::isfinite(sd);
    out.parameters.push_back({p.name, *p.value, sd, known});
    if (!known) {
      out.remarks.push_back(
          fmt::format("{} cannot be told from the others with these edges.", p.name));
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = i + 1; k < n; ++k) {
      const double r = covariance(i, k) / std::sqrt(covariance(i, i) * covariance(k, k));
      if (!(std::abs(r) > kCorrelated)) continue;
      out.correlated.push_back({out.parameters[static_cast<std::size_t>(i)].name,
                                out.parameters[static_cast<std::size_t>(k)].name, r});
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      covariance(i, k) *= inflation * inflation / (scale[i] * scale[k]);
    }
  }
  return covariance;
}

// The sides of the aperture in px, from their signed squares, which set_up lists first.
void add_sides(const Unknowns& u, bool both_sides, const Eigen::MatrixXd& covariance, PsfFit& out) {
  if (!(u.aperture2 > 0)) return;
  const double x = std::sqrt(u.aperture2);
  const bool known = out.parameters[0].determined;
  const double sd_x = out.parameters[0].sd / (2 * x);
  if (!both_sides || !(u.aspect2 > 0)) {
    out.parameters.push_back({"aperture_px", x, sd_x, known});
    return;
  }
  const bool both_known = known && out.parameters[1].determined;
  const double y = x * std::sqrt(u.aspect2);
  // Of ln y = (ln aperture2 + ln aspect2) / 2.
  const Eigen::Vector2d slope(0.5 / u.aperture2, 0.5 / u.aspect2);
  const double variance = slope.dot(covariance.topLeftCorner<2, 2>() * slope);
  out.parameters.push_back({"aperture_x_px", x, sd_x, known});
  out.parameters.push_back(
      {"aperture_y_px", y, y * std::sqrt(std::max(0.0, variance)), both_known});
}

bool usable(const PsfEdge& e) {
  return e.channel >= 0 && e.channel < psf::kChannels && e.bins.size() >= 12 && e.noise > 0 &&
         e.reach_px > 0 && e.reach_px <= 98;
}

}  // namespace

const PsfParameter* PsfFit::find(const std::string& name) const {
  const auto at = std::find_if(parameters.begin(), parameters.end(),
                               [&](const PsfParameter& p) { return p.name == name; });
  return at == parameters.end() ? nullptr : &*at;
}

PsfFit fit_psf(std::span<const PsfEdge> edges, const std::function<bool()>& stop) {
  PsfFit out;
  if (edges.empty() || !std::all_of(edges.begin(), edges.end(), usable)) {
    out.why = "There is no edge to fit the optics to, or one without profile among them.";
    return out;
  }
  Freedom freedom;
  std::set<double> settings;
  bool along_x = false, along_y = false, every = true;
  double n = 0;
  for (const PsfEdge& e : edges) {
    if (e.focus) settings.insert(*e.focus);
    every = every && e.focus.has_value();
    along_x = along_x || e.normal.x > kAlongAxis;
    along_y = along_y || e.normal.y > kAlongAxis;
    n += static_cast<double>(e.bins.size());
  }
  freedom.path_per_step = every && settings.size() >= kLeastFocusSettings;
  freedom.aspect = along_x && along_y;
  Solved solved = best_of_starts(edges, freedom, stop);
  constexpr const char* kStopped = "Stopped before lens, aperture and blur were fitted.";
  if (!solved.ok) {
    out.why =
        stop && stop() ? kStopped : "Lens, aperture and blur could not be fitted to these edges.";
    return out;
  }
  const auto freedom_left = [&](const Freedom& f) {
    double used = 1 + (f.aspect ? 1 : 0) + (f.halo ? 2 : 0) + (f.path_per_step ? 1 : 0);
    for (const Unknowns::Channel& c : solved.unknowns.channels) used += c.used ? 3 : 0;
    return std::max(1.0, n - used - 3 * static_cast<double>(edges.size()));
  };
  // A halo, if the edges ask for it (BIC, with the noise that the better fit leaves).
  Freedom with_halo = freedom;
  with_halo.halo = true;
  Solved haloed;
  for (const double share : {0.05, 0.15}) {
    Unknowns start = solved.unknowns;
    start.halo = share;
    Solved now = solve_from(edges, with_halo, start, stop);
    if (now.ok && (!haloed.ok || now.cost < haloed.cost)) haloed = std::move(now);
  }
  if (stop && stop()) {
    out.why = kStopped;
    return out;
  }
  const double left = freedom_left(with_halo);
  if (haloed.ok && haloed.unknowns.halo > 0 &&
      2 * (solved.cost - haloed.cost) > 2 * std::log(n) * std::max(1.0, 2 * haloed.cost / left)) {
    solved = std::move(haloed);
    freedom = with_halo;
  }
  out.ok = true;
  out.has_halo = freedom.halo;
  out.has_focus = freedom.path_per_step;
  out.chi2_per_freedom = 2 * solved.cost / freedom_left(freedom);

  Unknowns& u = solved.unknowns;
  // Signs that make no difference are told as positive; direction of focus likewise.
  if (freedom.path_per_step) {
    u.path_per_step = std::abs(u.path_per_step);
  } else {
    for (Unknowns::Channel& c : u.channels) c.best = std::abs(c.best);
  }
  const std::unique_ptr<Setup> setup = psf::set_up(edges, freedom, u);
  const Eigen::MatrixXd covariance = judge(shared_curvature(*setup, u), setup->shared,
                                           std::sqrt(std::max(1.0, out.chi2_per_freedom)), out);
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index k = 0; k < covariance.cols(); ++k) out.covariance.push_back(covariance(i, k));
  }
  add_sides(u, freedom.aspect, covariance, out);
  if (freedom.path_per_step) {
    const PsfParameter path = *out.find("defocus_path_um_per_step");
    for (int c = 0; c < psf::kChannels; ++c) {
      if (!u.channels[static_cast<std::size_t>(c)].used) continue;
      const double waves = u.waves_per_path(c);
      out.parameters.push_back({std::string(psf::channel_name(c)) + ".defocus_waves_per_step",
                                waves * path.value, waves * path.sd, path.determined});
    }
  }
  if (!freedom.aspect) {
    out.remarks.emplace_back(
        "The edges run along one axis only; the aperture is taken as square. Add an edge across "
        "to tell both sides.");
  }
  if (!freedom.path_per_step) {
    out.remarks.emplace_back(
        "All edges have one focus setting, or it is not known; best focus cannot be told. Scan "
        "the edge at three settings or more.");
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const PsfEdge& edge = edges[e];
    const double focus = freedom.path_per_step ? *edge.focus : 0;
    const EdgeOptics optics = u.optics(edge.channel, focus);
    out.optics.push_back(optics);
    const MeanProfile profile(optics, edge.normal, std::min(100.0, edge.reach_px + 2), {});
    double squares = 0, weight = 0;
    std::map<long, std::array<double, 2>> cells;  // weight, weighted sum
    for (const ProfileBins::Bin& bin : edge.bins) {
      const double value = u.edges[e].dark + (u.edges[e].bright - u.edges[e].dark) *
                                                 profile.value(bin.distance - u.edges[e].offset);
      squares += bin.weight * (value - bin.value) * (value - bin.value);
      weight += bin.weight;
      auto& cell = cells[std::lround(bin.distance * kCellsPerPx)];
      cell[0] += bin.weight;
      cell[1] += bin.weight * (bin.value - value);
    }
    std::vector<PsfFit::Residual>& rest = out.residuals.emplace_back();
    for (const auto& [at, cell] : cells) {
      rest.push_back({static_cast<double>(at) / kCellsPerPx, cell[1] / cell[0]});
    }
    out.misfit.push_back(std::sqrt(squares / weight));
  }
  return out;
}

}  // namespace reseau
