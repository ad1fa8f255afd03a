#include "calibration/psf/psf_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "calibration/psf/field_solver.h"

namespace reseau {
namespace {

using psf::FieldNormal;
using psf::FieldSolver;
using psf::FieldState;
using psf::FieldSurface;

constexpr std::size_t kEdgesOfPlane = 5, kEdgesOfQuadratic = 8;
constexpr int kMostBends = 8;
constexpr double kNoCurvature = 1e-9, kCorrelated = 0.95;
// Chi-squared from which one explanation of a change over the frame is called the better one.
constexpr double kTellsApart = 9;
constexpr double kNearlyAsGood = 1.05;
constexpr double kFieldWaves = 0.4;  // a defocus to begin with, at the frame's border

using Stop = std::function<bool()>;

struct Start {
  FieldState state;
  std::array<double, psf::kSharedBlocks> fixed{};
  // Of each surface: the highest order that its edges can tell.
  std::vector<int> most;
};

int most_order(std::size_t n_places) {
  return n_places >= kEdgesOfQuadratic ? 2 : n_places >= kEdgesOfPlane ? 1 : 0;
}

Start start_from(std::span<const PsfEdge> edges, std::span<const Vec2> places,
                 const PsfFit& shared) {
  Start out;
  out.fixed = {1, 1, 0, 6, -1, 0.8, 0.05, 0};
  using Places = std::set<std::pair<double, double>>;
  std::array<Places, psf::kChannels> of_channel;
  Places all;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    of_channel[static_cast<std::size_t>(edges[e].channel)].insert({places[e].x, places[e].y});
    all.insert({places[e].x, places[e].y});
    out.state.own.emplace_back(0, 0, 1);
  }
  const auto add = [&](psf::Block block, int channel, const std::string& name,
                       std::size_t n_places) {
    const PsfParameter* p = shared.find(name);
    if (p == nullptr) return;
    FieldSurface surface{block, channel, name, 0, {}};
    surface.c.setZero();
    surface.c[0] = p->value;
    out.state.surfaces.push_back(surface);
    out.most.push_back(most_order(n_places));
  };
  add(psf::kBlockAperture, -1, "aperture_squared_px2", all.size());
  add(psf::kBlockAspect, -1, "aspect_squared", all.size());
  add(psf::kBlockHalo, -1, "halo_share", all.size());
  add(psf::kBlockHaloSigma, -1, "halo_sigma_px", 0);
  add(psf::kBlockPath, -1, "defocus_path_um_per_step", 0);
  for (int c = 0; c < psf::kChannels; ++c) {
    const std::size_t n = of_channel[static_cast<std::size_t>(c)].size();
    const std::string name = psf::channel_name(c);
    add(psf::kBlockDiffraction, c, name + ".diffraction_px", n);
    add(psf::kBlockSigma, c, name + ".gaussian_variance_px2", n);
    add(psf::kBlockBest, c, name + (shared.has_focus ? ".best_focus" : ".defocus_w20_waves"), n);
  }
  return out;
}

// Whether enough places were scanned at three settings or more to tell best focus at each.
bool through_focus(std::span<const PsfEdge> edges, std::span<const Vec2> places) {
  std::map<std::pair<double, double>, std::set<double>> settings;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    settings[{places[e].x, places[e].y}].insert(*edges[e].focus);
  }
  return std::ranges::count_if(settings, [](const auto& one) { return one.second.size() >= 3; }) >=
         static_cast<std::ptrdiff_t>(kEdgesOfPlane);
}

double scatter_of(const FieldNormal& at, const FieldState& state) {
  const double freedom = at.n_apart - static_cast<double>(state.size());
  return freedom > 0 ? std::max(1.0, at.apart / freedom) : 1.0;
}

// Largest fall of chi-squared that moving these coefficients promises.
double promised(const FieldNormal& at, const std::vector<Eigen::Index>& free) {
  const Eigen::MatrixXd a = at.a(free, free);
  const Eigen::VectorXd g = at.g(free);
  Eigen::VectorXd scale(a.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) scale[i] = a(i, i) > 0 ? 1 / std::sqrt(a(i, i)) : 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * a *
                                                             scale.asDiagonal());
  const Eigen::VectorXd turned = eigen.eigenvectors().transpose() * (scale.asDiagonal() * g);
  double gain = 0;
  for (Eigen::Index i = 0; i < turned.size(); ++i) {
    if (eigen.eigenvalues()[i] > kNoCurvature * eigen.eigenvalues().maxCoeff()) {
      gain += turned[i] * turned[i] / eigen.eigenvalues()[i];
    }
  }
  return gain;
}

// Bends one more surface where the edges ask for it. False when none does, or when it was stopped.
bool bend_one(const FieldSolver& solver, const std::vector<int>& most, FieldState& state,
              double n_edges, const Stop& stop) {
  const FieldNormal at = solver.normal(state);
  if (!at.ok) return false;
  const double per_term = std::log(n_edges) * scatter_of(at, state);
  const double now = promised(at, FieldSolver::free_of(state));
  double best = 0;
  std::size_t which = 0;
  int order = 0;
  for (std::size_t i = 0; i < state.surfaces.size(); ++i) {
    for (int o = state.surfaces[i].order + 1; o <= most[i]; ++o) {
      FieldState bent = state;
      bent.surfaces[i].order = o;
      const double gain = promised(at, FieldSolver::free_of(bent)) - now -
                          per_term * static_cast<double>(bent.size() - state.size());
      if (gain > best) {
        best = gain;
        which = i;
        order = o;
      }
    }
  }
  if (order == 0) return false;
  FieldState bent = state;
  bent.surfaces[which].order = order;
  if (!solver.solve(bent, stop)) return false;
  const double gain =
      state.chi2 - bent.chi2 - per_term * static_cast<double>(bent.size() - state.size());
  if (!(gain > 0)) return false;
  state = std::move(bent);
  return true;
}

FieldState bent_in(const Start& start, psf::Block block) {
  FieldState out = start.state;
  for (std::size_t i = 0; i < out.surfaces.size(); ++i) {
    if (out.surfaces[i].block == block) out.surfaces[i].order = start.most[i];
  }
  return out;
}

bool has_side(const FieldState& state) {
  return std::ranges::all_of(state.surfaces, [](const FieldSurface& s) {
    return s.block != psf::kBlockAperture || s.c[0] > 0;
  });
}

// A side that is squared may turn negative, and a wide Gaussian makes up for it; the side of a
// pixel is sought from both of the usual ones too.
bool solve_well(const FieldSolver& solver, FieldState& state, const Stop& stop) {
  FieldState best = state;
  bool any = solver.solve(best, stop);
  for (const double aperture2 : {1.0, 4.0}) {
    FieldState trial = state;
    double less = 0;
    for (FieldSurface& s : trial.surfaces) {
      if (s.block == psf::kBlockAperture) {
        less = s.c[0] - aperture2;
        s.c[0] = aperture2;
      }
    }
    for (FieldSurface& s : trial.surfaces) {
      if (s.block == psf::kBlockSigma) s.c[0] += less / 12;
    }
    if (std::abs(less) < 0.5) continue;
    if (!solver.solve(trial, stop)) continue;
    const bool was = has_side(best), is = has_side(trial);
    const double worth = was == is ? 1 : is ? kNearlyAsGood : 1 / kNearlyAsGood;
    if (!any || trial.chi2 < worth * best.chi2) {
      best = std::move(trial);
      any = true;
    }
    if (stop && stop()) return false;
  }
  state = std::move(best);
  return any;
}

// Where places have one focus setting only, a field that is bent and a blur that grows look much
// alike; where the whole frame has, so do a little defocus and a little blur.
bool blur_or_defocus(const FieldSolver& solver, Start& start, const PsfFit& shared,
                     FieldState& state, const Stop& stop, std::vector<std::string>& remarks) {
  // Without defocus first, unless settings of focus tell it somewhere.
  Start none = start;
  for (std::size_t i = none.most.size(); !shared.has_focus && i-- > 0;) {
    if (none.state.surfaces[i].block != psf::kBlockBest) continue;
    none.state.surfaces.erase(none.state.surfaces.begin() + static_cast<std::ptrdiff_t>(i));
    none.most.erase(none.most.begin() + static_cast<std::ptrdiff_t>(i));
  }
  FieldState blur = bent_in(none, psf::kBlockSigma);
  if (!solve_well(solver, blur, stop)) return false;
  const double scatter = scatter_of(solver.normal(blur), blur);
  std::optional<FieldState> best;
  const auto try_defocus = [&](psf::Block bent, double curvature) {
    FieldState trial = bent_in(start, bent);
    for (FieldSurface& s : trial.surfaces) {
      for (const FieldSurface& found : blur.surfaces) {
        if (found.name == s.name) s.c[0] = found.c[0];
      }
      if (s.block != psf::kBlockBest) continue;
      if (!shared.has_focus) s.c[0] = std::max(0.2, s.c[0]);
      if (s.order == 2) s.c[3] = s.c[5] = curvature;
    }
    if (solver.solve(trial, stop) && (!best || trial.chi2 < best->chi2)) best = std::move(trial);
  };
  if (!shared.has_focus) try_defocus(psf::kBlockSigma, 0);
  const PsfParameter* path = shared.find("defocus_path_um_per_step");
  const double waves_of_one =
      path == nullptr ? 1 : std::max(1e-9, std::abs(path->value)) / kPsfWavelengths_um[1];
  for (const double sign : {1.0, -1.0}) {
    try_defocus(psf::kBlockBest, 0.5 * sign * kFieldWaves / waves_of_one);
  }
  if (stop && stop()) return false;
  const double wanted =
      kTellsApart + 2 * std::max(0.0, static_cast<double>(best ? best->size() - blur.size() : 0));
  if (best && (blur.chi2 - best->chi2) / scatter > wanted) {
    state = std::move(*best);
    remarks.emplace_back(
        shared.has_focus ? "Most places have one focus setting; to which side of best focus they "
                           "lie is told by the shape of the surface alone."
                         : "One focus setting does not tell the sign of the defocus.");
    return true;
  }
  state = std::move(blur);
  start = std::move(none);
  remarks.emplace_back(
      shared.has_focus
          ? "How best focus changes over the frame is counted as Gaussian blur; most places have "
            "one focus setting, which does not tell one from the other."
          : "Defocus is counted as Gaussian blur; the edges, all at one focus setting, do not "
            "tell one from the other.");
  return true;
}

std::vector<double> row_major(const Eigen::MatrixXd& a) {
  std::vector<double> out;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index k = 0; k < a.cols(); ++k) out.push_back(a(i, k));
  }
  return out;
}

// Covariance, rank, what is not determined and what trades for what.
void judge_field(const FieldNormal& at, const FieldState& state, PsfFieldRecord& out) {
  const std::vector<Eigen::Index> free = FieldSolver::free_of(state);
  const Eigen::MatrixXd a = at.a(free, free);
  const Eigen::Index n = a.rows();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = a(i, i) > 0 ? 1 / std::sqrt(a(i, i)) : 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * a *
                                                             scale.asDiagonal());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd unknown = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(i);
    if (eigen.eigenvalues()[i] > kNoCurvature * eigen.eigenvalues().maxCoeff()) {
      covariance += v * v.transpose() / eigen.eigenvalues()[i];
      ++out.rank;
    } else {
      unknown += v.cwiseAbs2();
    }
  }
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal() * out.scatter;
  Eigen::Index first = 0;
  for (const FieldSurface& s : state.surfaces) {
    const Eigen::Index terms = psf::terms_of(s.order);
    const bool known = unknown.segment(first, terms).maxCoeff() < 0.01 &&
                       scale.segment(first, terms).minCoeff() > 0;
    out.surfaces.push_back({s.name, s.order, known});
    for (Eigen::Index k = 0; k < terms; ++k) out.coefficients.push_back(s.c[k]);
    if (!known) {
      out.remarks.push_back(
          fmt::format("How {} lies over the frame cannot be told with these edges.", s.name));
    }
    first += terms;
  }
  out.covariance = row_major(covariance);
  const auto in_middle = [&](const std::string& a_name, const std::string& b_name) {
    const std::vector<double> u = out.weights(a_name, 0, 0), v = out.weights(b_name, 0, 0);
    return Eigen::Map<const Eigen::VectorXd>(u.data(), n)
        .dot(covariance * Eigen::Map<const Eigen::VectorXd>(v.data(), n));
  };
  for (std::size_t i = 0; i < out.surfaces.size(); ++i) {
    for (std::size_t k = i + 1; k < out.surfaces.size(); ++k) {
      const std::string &p = out.surfaces[i].name, &q = out.surfaces[k].name;
      const double r = in_middle(p, q) / std::sqrt(in_middle(p, p) * in_middle(q, q));
      if (std::abs(r) > kCorrelated) out.correlated.push_back({p, q, r});
    }
  }
}

}  // namespace

std::optional<PsfFieldRecord> fit_psf_field(std::span<const PsfEdge> edges,
                                            std::span<const Vec2> places, const PsfFit& shared,
                                            const std::function<bool()>& stop) {
  if (!shared.ok || edges.empty() || edges.size() != places.size()) return std::nullopt;
  if (shared.has_focus &&
      !std::ranges::all_of(edges, [](const PsfEdge& e) { return e.focus.has_value(); })) {
    return std::nullopt;
  }
  Start start = start_from(edges, places, shared);
  const FieldSolver solver(edges, places, shared.has_focus, start.fixed);
  PsfFieldRecord out;
  out.edges = static_cast<int>(edges.size());
  out.has_focus = shared.has_focus;
  out.known = std::ranges::any_of(start.most, [](int order) { return order > 0; });
  FieldState state = start.state;
  if (!out.known) {
    out.remarks.emplace_back(
        "The edges lie in too few places of the frame; how sharpness changes over it is unknown, "
        "and these are constants of the places measured. Scan edges in five places or more.");
  }
  if (shared.has_focus && (!out.known || through_focus(edges, places))) {
    state = bent_in(start, psf::kBlockBest);
    if (!solve_well(solver, state, stop)) return std::nullopt;
  } else if (!blur_or_defocus(solver, start, shared, state, stop, out.remarks)) {
    return std::nullopt;
  }
  const double n_edges = std::max(8.0, static_cast<double>(edges.size()));
  for (int i = 0; out.known && i < kMostBends; ++i) {
    if (!bend_one(solver, start.most, state, n_edges, stop)) break;
  }
  if (stop && stop()) return std::nullopt;
  const FieldNormal at = solver.normal(state);
  if (!at.ok) return std::nullopt;
  out.scatter = scatter_of(at, state);
  judge_field(at, state, out);
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!std::ranges::all_of(out.covariance, finite) ||
      !std::ranges::all_of(out.coefficients, finite)) {
    return std::nullopt;
  }
  if (shared.has_focus) {
    for (const char* name : {"green.best_focus", "red.best_focus", "blue.best_focus"}) {
      if (const auto best = out.at(name, 0, 0)) {
        out.focus = best->value;
        break;
      }
    }
  }
  return out;
}

}  // namespace reseau
