// What slanted edges and the random target are held to: fourteen bars, each beside what is measured
// on edges whose transfer function is known exactly, and on real scans where they are at hand.
//   mtf_bench [FIRST LAST [full]]   the bars FIRST to LAST (1 14); full: on as many pictures as
//   they
//                                   ask for, which takes long
#include "tests/bench/mtf_bench.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

namespace reseau::bench {

using test::EdgePicture;
using test::Transfer2D;

void tell(int bar, const std::string& what, const std::string& wanted, const std::string& measured,
          bool kept) {
  fmt::print("| {} | {} | {} | {} | {} |\n", bar, what, wanted, measured, kept ? "kept" : "MISSED");
  std::fflush(stdout);
}

EdgePicture usual(double angle, double length, double noise, std::uint32_t seed) {
  EdgePicture p;
  p.normal_deg = angle;
  p.noise = noise;
  p.seed = seed;
  set_usual_region(p, length);
  return p;
}

EdgeMeasurement measure(const EdgePicture& p, const Transfer2D& t, bool clips) {
  const std::vector<float> samples = render(p, t);
  EdgeOptions options;
  if (p.bits > 0) options.quantum = 1 / (std::pow(2.0, p.bits) - 1);
  if (clips) options.highest = p.bright - p.clip_high * (p.bright - p.dark);
  return measure_edge({samples.data(), p.width_px, p.height_px}, options);
}

double error_percent(const EdgeMeasurement& m, const EdgePicture& p, const Transfer2D& t) {
  if (m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) return NAN;
  return 100 * (m.mtf.all.mtf50->f_cy_per_px / true_crossing(p, t, 0.5) - 1);
}

void Errors::add(double e) {
  if (!std::isfinite(e)) {
    ++refused;
    return;
  }
  ++n;
  sum += e;
  squares += e * e;
  most = std::max(most, std::abs(e));
}
void Errors::add(const EdgePicture& p, const Transfer2D& t) {
  const EdgeMeasurement m = measure(p, t);
  add(error_percent(m, p, t));
  if (m.status == EdgeStatus::kRefused) return;
  for (const std::size_t k : {10U, 20U, 30U, 40U}) {
    const MtfPoint& point = m.mtf.all.points[k];
    of_curve = std::max(of_curve, std::abs(point.value - true_transfer(p, t, point.f_cy_per_px)));
  }
}
double Errors::mean() const { return sum / std::max(1, n); }
double Errors::rms() const { return std::sqrt(squares / std::max(1, n)); }
double Errors::sd() const { return std::sqrt(std::max(0.0, rms() * rms() - mean() * mean())); }

namespace {

int run(int argc, char** argv) {
  Bars bars;
  if (argc > 1) bars.first = bars.last = std::atoi(argv[1]);
  if (argc > 2) bars.last = std::atoi(argv[2]);
  bars.full = argc > 3 && std::strcmp(argv[3], "full") == 0;
  fmt::print("| bar | on | wanted | measured | |\n| --- | --- | --- | --- | --- |\n");
  noise_free(bars);
  noisy(bars);
  hard(bars);
  if (bars.holds(9)) refusals(bars);
  if (bars.holds(11)) real_scans();
  if (bars.holds(12)) times();
  if (bars.holds(13)) {
    fmt::print("| 13 | random target | | calibration_unit RandomTarget.* tells it | |\n");
  }
  if (bars.holds(14)) odd_input();
  return 0;
}

}  // namespace

}  // namespace reseau::bench

int main(int argc, char** argv) { return reseau::bench::run(argc, argv); }
