#include "capture/bench/registration_score.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "capture/bench/cpu_time.h"
#include "core/line/memory_line_source.h"
#include "drivers/sim/simulate.h"

namespace reseau {
namespace {

// The pattern does not tell apart screen coordinates that differ by whole periods or by a turn: of
// those, the ones nearest to what was found.
struct Match {
  double sign_u = 1, sign_v = 1, whole_u = 0, whole_v = 0;
};

double middle(std::vector<double> values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

}  // namespace

RegistrationScore score_registration(const RegistrationCase& test, int n_threads) {
  const sim::SimSpec spec = sim::parse_sim_spec("ls5000?" + test.film);
  const sim::SimulatedScan scan = sim::simulate_frame(spec);
  const MemoryLineSource source(scan.format, scan.samples);
  RegisterOptions options;
  options.n_threads = n_threads;
  const double cpu = cpu_seconds();
  const auto start = std::chrono::steady_clock::now();
  const Registration found = register_screen(source, options, {}, {});
  const double wall_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double cpu_s = cpu_seconds() - cpu;
  RegistrationScore score = compare_with_truth(scan, found);
  score.wall_s = wall_s;
  score.cpu_s = cpu_s;
  return score;
}

RegistrationScore compare_with_truth(const sim::SimulatedScan& scan, const Registration& found) {
  RegistrationScore score;
  score.found = found.found;
  score.reason = found.reason;
  score.screen = found.screen;
  score.true_screen = std::string(scan.truth.screen_name());
  if (!found.found || !scan.truth.has_screen()) return score;
  score.affine = found.map.is_affine();
  score.residual_px = found.residual_px;
  score.bound_px = found.uncertainty.bound_px();

  const int step = std::max(1, scan.format.width_px / 160);
  struct Place {
    Vec2 p;
    Vec2 truth, map;
    double light;
  };
  std::vector<Place> places;
  const auto width = static_cast<std::size_t>(scan.format.width_px);
  std::vector<float> silver(width);
  for (int y = step / 2; y < scan.format.n_lines; y += step) {
    scan.truth.silver_row(y, silver);
    for (int x = step / 2; x < scan.format.width_px; x += step) {
      const Vec2 p{static_cast<double>(x), static_cast<double>(y)};
      const auto s = scan.truth.screen_from_scan(p.x, p.y);
      places.push_back({p,
                        {s.u, s.v},
                        found.map.screen_from_scan(p),
                        static_cast<double>(silver[static_cast<std::size_t>(x)])});
    }
  }
  Match best;
  double best_spread = 1e300;
  for (const double su : {1.0, -1.0}) {
    for (const double sv : {1.0, -1.0}) {
      std::vector<double> du, dv;
      for (const Place& place : places) {
        du.push_back(place.map.x - su * place.truth.x);
        dv.push_back(place.map.y - sv * place.truth.y);
      }
      const double mu = middle(du), mv = middle(dv);
      double spread = 0;
      for (std::size_t i = 0; i < du.size(); ++i) {
        spread += std::min(1.0, std::abs(du[i] - mu)) + std::min(1.0, std::abs(dv[i] - mv));
      }
      if (spread < best_spread) {
        best_spread = spread;
        best = {su, sv, std::round(mu), std::round(mv)};
      }
    }
  }
  double sum = 0, lit_sum = 0, z_sum = 0, sd_sum = 0;
  int n_lit = 0;
  for (const Place& place : places) {
    const Vec2 off{place.map.x - best.sign_u * place.truth.x - best.whole_u,
                   place.map.y - best.sign_v * place.truth.y - best.whole_v};
    const Vec2 px = found.map.jacobian(place.p).inverse() * off;
    sum += dot(px, px);
    score.max_px = std::max(score.max_px, norm(px));
    if (place.light > 0.02) {
      lit_sum += dot(px, px);
      const PlaceCovariance claim = found.uncertainty.at(place.p);
      z_sum +=
          0.5 * (px.x * px.x / std::max(claim.xx, 1e-12) + px.y * px.y / std::max(claim.yy, 1e-12));
      sd_sum += claim.xx + claim.yy;
      score.worst_z =
          std::max(score.worst_z, std::sqrt(dot(px, px) / std::max(claim.xx + claim.yy, 1e-12)));
      ++n_lit;
    }
  }
  score.rms_px = std::sqrt(sum / static_cast<double>(places.size()));
  score.lit_rms_px = n_lit > 0 ? std::sqrt(lit_sum / n_lit) : 0;
  score.z_sd = n_lit > 0 ? std::sqrt(z_sum / n_lit) : 0;
  score.sd_px = n_lit > 0 ? std::sqrt(sd_sum / n_lit) : 0;
  return score;
}

RegistrationScore score_registration(const RegistrationCase& test, int n_threads, int n_seeds) {
  if (n_seeds <= 1) return score_registration(test, n_threads);
  RegistrationScore all;
  for (int seed = 1; seed <= n_seeds; ++seed) {
    RegistrationCase one = test;
    one.film += fmt::format("&seed={}", seed);
    RegistrationScore score = score_registration(one, n_threads);
    if (!score.found) return score;
    if (seed == 1) all = score;
    const auto add = [&](double RegistrationScore::*figure) {
      const double before = seed == 1 ? 0 : (seed - 1) * all.*figure * all.*figure;
      all.*figure = std::sqrt((before + score.*figure * score.*figure) / seed);
    };
    add(&RegistrationScore::rms_px);
    add(&RegistrationScore::lit_rms_px);
    add(&RegistrationScore::z_sd);
    add(&RegistrationScore::sd_px);
    add(&RegistrationScore::bound_px);
    add(&RegistrationScore::residual_px);
    all.max_px = std::max(all.max_px, score.max_px);
    all.worst_z = std::max(all.worst_z, score.worst_z);
    all.affine = all.affine && score.affine;
    all.cpu_s += (score.cpu_s - all.cpu_s) / seed;
    all.wall_s += (score.wall_s - all.wall_s) / seed;
  }
  return all;
}

}  // namespace reseau
