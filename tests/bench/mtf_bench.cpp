// What slanted edges and the random target are held to: fourteen bars, each beside what is measured
// on edges whose transfer function is known exactly, and on real scans where they are at hand.
//   mtf_bench [FIRST LAST]   the bars FIRST to LAST (1 14)
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/edge/find_edges.h"
#include "calibration/edge/measure_edge.h"
#include "tests/support/edge_renderer.h"
#include "tests/support/tiff_planes.h"

namespace reseau {
namespace {

using test::EdgePicture;
using test::Planes;
using test::read_planes;
using test::Transfer2D;

void tell(int bar, const std::string& what, const std::string& wanted, const std::string& measured,
          bool kept) {
  fmt::print("| {} | {} | {} | {} | {} |\n", bar, what, wanted, measured, kept ? "kept" : "MISSED");
  std::fflush(stdout);
}

EdgePicture usual(double angle, double length = 100, double noise = 0, std::uint32_t seed = 1) {
  EdgePicture p;
  p.normal_deg = angle;
  p.noise = noise;
  p.seed = seed;
  set_usual_region(p, length);
  return p;
}

EdgeMeasurement measure(const EdgePicture& p, const Transfer2D& t, bool clips = false) {
  const std::vector<float> samples = render(p, t);
  EdgeOptions options;
  if (p.bits > 0) options.quantum = 1 / (std::pow(2.0, p.bits) - 1);
  if (clips) options.highest = p.bright - p.clip_high * (p.bright - p.dark);
  return measure_edge({samples.data(), p.width_px, p.height_px}, options);
}

// In per cent; not finite where there is none.
double error_percent(const EdgeMeasurement& m, const EdgePicture& p, const Transfer2D& t) {
  if (m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) return NAN;
  return 100 * (m.mtf.all.mtf50->f_cy_per_px / true_crossing(p, t, 0.5) - 1);
}

struct Errors {
  double sum = 0, squares = 0, most = 0, of_curve = 0;
  int n = 0, refused = 0;
  void add(double e) {
    if (!std::isfinite(e)) {
      ++refused;
      return;
    }
    ++n;
    sum += e;
    squares += e * e;
    most = std::max(most, std::abs(e));
  }
  void add(const EdgePicture& p, const Transfer2D& t) {
    const EdgeMeasurement m = measure(p, t);
    add(error_percent(m, p, t));
    if (m.status == EdgeStatus::kRefused) return;
    for (const std::size_t k : {10U, 20U, 30U, 40U}) {
      const MtfPoint& point = m.mtf.all.points[k];
      of_curve = std::max(of_curve, std::abs(point.value - true_transfer(p, t, point.f_cy_per_px)));
    }
  }
  [[nodiscard]] double mean() const { return sum / std::max(1, n); }
  [[nodiscard]] double rms() const { return std::sqrt(squares / std::max(1, n)); }
  [[nodiscard]] double sd() const {
    return std::sqrt(std::max(0.0, rms() * rms() - mean() * mean()));
  }
};

struct Family {
  const char* name;
  Transfer2D transfer;
};
std::vector<Family> families() {
  const Transfer2D lens = test::airy_box_transfer(8);
  return {{"f/2.8", test::airy_box_transfer(2.8)},
          {"f/8", lens},
          {"f/22", test::airy_box_transfer(22)},
          {"f/8, 0.5 waves", test::airy_box_transfer(8, 0.5)},
          {"f/8, 1 wave", test::airy_box_transfer(8, 1)},
          {"smear 1 px", test::smeared(lens, 1)},
          {"smear 2 px", test::smeared(lens, 2)},
          {"halo 10 %, 6 px", test::with_halo(lens, 0.1, 6)},
          {"unsharp mask", test::sharpened(lens, 0.5, 1)}};
}

void noise_free(int first, int last) {
  if (first <= 1 && last >= 1) {
    Errors all;
    for (const double angle : {0.5, 1.0, 5.0, 14.04, 18.43, 26.565, 33.69, 36.87, 44.5, 45.0}) {
      for (const double mtf50 : {0.05, 0.1, 0.25, 0.5}) {
        all.add(usual(angle), test::gaussian_transfer(mtf50));
      }
    }
    tell(1, "no noise, Gaussian .05–.5, 0.5–45°", "MTF50 .05 %, M 3e-4",
         fmt::format("{:.3f} %, {:.1f}e-4, {} refused", all.most, 1e4 * all.of_curve, all.refused),
         all.most <= 0.05 && all.of_curve <= 3e-4);
  }
  if (first > 2 || last < 2) return;
  for (const Family& family : families()) {
    Errors all;
    for (const double angle : {1.0, 5.0, 10.0, 14.04, 18.43, 26.565, 36.87, 40.0})
      all.add(usual(angle), family.transfer);
    tell(2, std::string("no noise, ") + family.name, "MTF50 .15 %, M 10e-4",
         fmt::format("{:.3f} %, {:.1f}e-4, {} refused", all.most, 1e4 * all.of_curve, all.refused),
         all.most <= 0.15 && all.of_curve <= 1e-3);
  }
}

// Of a Gaussian with a free second parameter, levels and line [%].
double bound_percent(double mtf50, double noise, double length) {
  return 660 * noise * std::sqrt(mtf50 / length);
}

void noisy(int first, int last) {
  if (first <= 3 && last >= 3) {
    for (const bool lens : {false, true}) {
      const Transfer2D t = lens ? test::airy_box_transfer(8) : test::gaussian_transfer(0.25);
      Errors all;
      for (std::uint32_t i = 0; i < 60; ++i) all.add(usual(1 + 0.737 * i, 100, 0.005, i + 1), t);
      const double bound = bound_percent(lens ? 0.337 : 0.25, 0.005, 100);
      tell(3, lens ? "noise 0.5 %, f/8, 60 edges" : "noise 0.5 %, Gaussian .25, 60 edges",
           fmt::format("bias {} %, sd {:.3f} % (1.15 × limit), max .7 %", lens ? ".2" : ".05",
                       1.15 * bound),
           fmt::format("{:+.3f}, {:.3f}, {:.2f} %", all.mean(), all.sd(), all.most),
           std::abs(all.mean()) <= (lens ? 0.2 : 0.05) && all.sd() <= 1.15 * bound &&
               all.most <= 0.7);
    }
  }
  if (first <= 4 && last >= 4) {
    for (const double mtf50 : {0.05, 0.25, 0.5}) {
      for (const double noise : {0.002, 0.02}) {
        for (const double length : {25.0, 100.0}) {
          Errors all;
          for (std::uint32_t i = 0; i < 8; ++i) {
            all.add(usual(3 + 4.3 * i, length, noise, i + 1), test::gaussian_transfer(mtf50));
          }
          const double wanted = 1.25 * bound_percent(mtf50, noise, length) + 0.05;
          tell(4, fmt::format("Gaussian {}, noise {} %, L {}", mtf50, 100 * noise, length),
               fmt::format("rms {:.3f} %", wanted),
               fmt::format("{:.3f} % ({} refused)", all.rms(), all.refused), all.rms() <= wanted);
        }
      }
    }
  }
  if (first <= 5 && last >= 5) {
    for (const double angle : {0.0, 45.0}) {
      for (const bool lens : {false, true}) {
        const Transfer2D t = lens ? test::airy_box_transfer(8) : test::gaussian_transfer(0.25);
        const EdgePicture p = usual(angle);
        const EdgeMeasurement m = measure(p, t);
        const double e = error_percent(m, p, t);
        tell(5, fmt::format("{}° exactly, {}", angle, lens ? "f/8" : "Gaussian"),
             ".3 % or a reason", fmt::format("{:+.3f} %, {} reasons", e, m.reasons.size()),
             std::abs(e) <= 0.3 || !m.reasons.empty());
      }
    }
  }
  if (first <= 6 && last >= 6) {
    std::vector<Family> all = families();
    all.push_back({"exponential", test::exponential_transfer(0.5, 0.4)});
    double z2 = 0;
    int n = 0, covered = 0;
    std::uint32_t seed = 1;
    for (const Family& family : all) {
      for (int i = 0; i < 12; ++i) {
        EdgePicture p = usual(2.3 + 3.4 * i, 80, 0.01, ++seed);
        p.noise_correlation = i % 3 == 0 ? 0.5 : 0;
        const EdgeMeasurement m = measure(p, family.transfer);
        if (m.status == EdgeStatus::kRefused || !m.mtf.all.mtf50) continue;
        const double z = (m.mtf.all.mtf50->f_cy_per_px - true_crossing(p, family.transfer, 0.5)) /
                         m.mtf.all.mtf50->sd;
        ++n;
        z2 += z * z;
        covered += std::abs(z) < 1.96 ? 1 : 0;
      }
    }
    const double sd = std::sqrt(z2 / n), share = 100.0 * covered / n;
    tell(6, fmt::format("claims of {} edges, 10 families, a third in correlated noise", n),
         "z .85–1.2, 92–98 %", fmt::format("z {:.2f}, {:.1f} %", sd, share),
         sd >= 0.85 && sd <= 1.2 && share >= 92 && share <= 98);
  }
}

void hard(int first, int last) {
  const Transfer2D t = test::gaussian_transfer(0.25);
  if (first <= 7 && last >= 7) {
    struct Case {
      const char* name;
      double wanted;
      void (*set)(EdgePicture&);
    };
    const Case cases[] = {
        {"shading ±10 % across", 0.3, [](EdgePicture& p) { p.shade_across = 0.1; }},
        {"shading ±25 % across", 1.5, [](EdgePicture& p) { p.shade_across = 0.25; }},
        {"shading ±25 % along", 0.6, [](EdgePicture& p) { p.shade_along = 0.25; }},
        {"bow of 4 px", 0.25, [](EdgePicture& p) { p.bow_px = 4; }},
        {"dust", 0.5, [](EdgePicture& p) { p.dust_spots = 4; }},
        {"0.5 % hot pixels", 0.3, [](EdgePicture& p) { p.hot_share = 0.005; }}};
    for (const Case& one : cases) {
      Errors all;
      for (std::uint32_t i = 0; i < 8; ++i) {
        EdgePicture p = usual(3 + 4.1 * i, 100, 0.002, i + 1);
        p.bright = 0.7;  // light that grows by a quarter is still on the scale
        one.set(p);
        all.add(p, t);
      }
      tell(7, one.name, fmt::format("{} % rms", one.wanted),
           fmt::format("{:.3f} % ({} refused)", all.rms(), all.refused),
           all.rms() <= one.wanted && all.refused == 0);
    }
  }
  if (first <= 8 && last >= 8) {
    int silent = 0;
    Errors told;
    for (std::uint32_t i = 0; i < 12; ++i) {
      EdgePicture p = usual(3 + 3.1 * i, 100, 0.003, i + 1);
      p.clip_high = i % 2 == 0 ? 0.02 : 0.1;
      const EdgeMeasurement m = measure(p, t, true);
      const bool flagged = m.status == EdgeStatus::kRefused || !m.reasons.empty();
      if (!flagged) ++silent;
      if (m.status != EdgeStatus::kRefused) told.add(error_percent(m, p, t));
    }
    tell(8, "2 and 10 % of the contrast clipped", "flagged; error 1 % or refused",
         fmt::format("{} of 12 silent, {} told, at most {:.2f} % off", silent, told.n, told.most),
         silent == 0 && told.most <= 1);
  }
  if (first <= 10 && last >= 10) {
    for (const int side : {16, 12}) {
      Errors all;
      for (std::uint32_t i = 0; i < 40; ++i) {
        EdgePicture p;
        p.normal_deg = 3 + 1.0 * i;
        p.noise = 0.005;
        p.seed = i + 1;
        p.width_px = p.height_px = side;
        all.add(p, t);
      }
      const double wanted = side == 16 ? 0.6 : 1.2;
      tell(10, fmt::format("{0} × {0} px, noise 0.5 %", side), fmt::format("{} % rms", wanted),
           fmt::format("{:.2f} % ({} of 40 refused)", all.rms(), all.refused),
           all.rms() <= wanted && all.refused == 0);
    }
  }
}

void refusals() {
  constexpr int kSide = 72, kSeeds = 60;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int accepted[5] = {};
  for (int seed = 0; seed < kSeeds; ++seed) {
    for (int kind = 0; kind < 5; ++kind) {
      std::vector<float> samples;
      const double r = 12 + seed % 20, shift = 6 + seed % 12;
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const double d = x - 36 + 0.1 * (y - 36), out = std::hypot(x - 36, y - 36) - r;
          const auto step = [](double v) { return 0.5 * std::erfc(-v / 1.2); };
          double v = 0.5;
          if (kind == 1) v = 0.5 + 0.1 * normal(random);
          if (kind == 2) v = 0.2 + 0.5 * (step(d + shift) - step(d - shift));
          if (kind == 3) v = 0.2 + 0.6 * step(out);
          if (kind == 4) v = std::min(0.6, 0.2 + 0.8 * step(d));
          samples.push_back(static_cast<float>(v + (kind == 4 ? 0 : 0.003 * normal(random))));
        }
      }
      EdgeOptions options;
      if (kind == 4) options.highest = 0.6;
      const EdgeMeasurement m = measure_edge({samples.data(), kSide, kSide}, options);
      if (m.status != EdgeStatus::kRefused) ++accepted[kind];
    }
  }
  tell(9, fmt::format("constant, noise, two edges, circle, saturated, {} of each", kSeeds),
       "all refused",
       fmt::format("accepted {}, {}, {}, {}, {}", accepted[0], accepted[1], accepted[2],
                   accepted[3], accepted[4]),
       std::all_of(std::begin(accepted), std::end(accepted), [](int n) { return n == 0; }));
  int refused = 0;
  constexpr int kValid = 100;
  for (std::uint32_t i = 0; i < kValid; ++i) {
    const EdgePicture p = usual(0.9 * i, i % 2 == 0 ? 16 : 40, 0.03, i + 1);
    if (measure(p, test::gaussian_transfer(0.25)).status == EdgeStatus::kRefused) ++refused;
  }
  tell(9, "valid: noise 3 %, L 16 and 40, any angle", "99 % accepted",
       fmt::format("{} of {} refused", refused, kValid), refused * 100 <= kValid);
}

EdgeMeasurement of_plane(const Planes& planes, std::size_t c) {
  return measure_edge({planes.samples[c].data(), planes.width, planes.height},
                      {.lowest = 0, .highest = 1, .quantum = 1.0 / 65535});
}

void real_scans() {
  const std::filesystem::path scans = std::filesystem::path(RESEAU_SHARED_DIR) / "data" / "scans";
  const Planes razor = read_planes(scans / "razor-ls9000-4000dpi-rgbi.tif");
  if (razor.samples.size() == 4) {
    const char* const names[] = {"R", "G", "B", "IR"};
    const double expected[] = {0.222, 0.244, 0.239, 0.218};
    for (std::size_t c = 0; c < 4; ++c) {
      const EdgeMeasurement m = of_plane(razor, c);
      const double f = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
      const double a = std::sqrt(std::max(0.0, m.optics.aperture2_px2));
      tell(11, fmt::format("Coolscan 9000, razor, {}", names[c]),
           fmt::format("{} ± 1 %, M(.5) < .015", expected[c]),
           fmt::format("{:.4f} ± {:.4f}, M(.5) {:.4f}; aperture alone {:.2f} px", f,
                       m.mtf.all.mtf50 ? m.mtf.all.mtf50->sd : 0, m.mtf.all.points[50].value, a),
           std::abs(f / expected[c] - 1) <= 0.01 && std::abs(m.mtf.all.points[50].value) < 0.015);
    }
  }
  const struct {
    const char* name;
    double window, all;
  } isa[] = {{"edge-phaseone-2089ppi-centerh.tif", 0.0991, 0.080},
             {"edge-phaseone-2089ppi-topleftv.tif", 0.0998, 0.0}};
  for (const auto& one : isa) {
    const Planes planes = read_planes(scans / one.name);
    if (planes.samples.empty()) continue;
    const EdgeMeasurement m = of_plane(planes, 0);
    const double w = m.mtf.window.mtf50 ? m.mtf.window.mtf50->f_cy_per_px : 0;
    const double f = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
    tell(11, one.name, fmt::format("{} ± 2 % within ±28 px", one.window),
         fmt::format("{:.4f} within, {:.4f} of all", w, f), std::abs(w / one.window - 1) <= 0.02);
  }
  const Planes circles = read_planes(scans / "not-an-edge-phaseone-circles.tif");
  if (!circles.samples.empty()) {
    const bool refused = of_plane(circles, 0).status == EdgeStatus::kRefused;
    tell(11, "circles", "refused", refused ? "refused" : "accepted", refused);
  }
}

double milliseconds(const EdgePicture& p, const Transfer2D& t, int rounds) {
  const std::vector<float> samples = render(p, t);
  std::vector<double> all;
  for (int i = 0; i < rounds; ++i) {
    const auto begin = std::clock();
    const EdgeMeasurement m = measure_edge({samples.data(), p.width_px, p.height_px});
    all.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    if (m.status == EdgeStatus::kRefused) return NAN;
  }
  return *std::ranges::min_element(all);
}

void times() {
  EdgePicture p = usual(5, 100, 0.005);
  p.width_px = 172;
  p.height_px = 100;
  const double small = milliseconds(p, test::airy_box_transfer(8), 7);
  tell(12, "172 × 100 px with covariance, f/8", "15 ms CPU", fmt::format("{:.1f} ms", small),
       small <= 15);
  p.width_px = 495;
  p.height_px = 924;
  const double large = milliseconds(p, test::airy_box_transfer(8), 3);
  tell(12, "495 × 924 px", "60 ms CPU", fmt::format("{:.1f} ms", large), large <= 60);
}

void odd_input() {
  int fine = 0, n = 0;
  for (const int side : {0, 1, 2, 5, 11}) {
    const std::vector<float> grey(static_cast<std::size_t>(side) * static_cast<std::size_t>(side),
                                  0.5F);
    ++n;
    fine += measure_edge({grey.data(), side, side}).status == EdgeStatus::kRefused ? 1 : 0;
  }
  EdgePicture p = usual(5, 80, 0.003);
  std::vector<float> samples = render(p, test::airy_box_transfer(8));
  const EdgeMeasurement plain = measure_edge({samples.data(), p.width_px, p.height_px});
  std::vector<float> turned(samples.size());
  for (int y = 0; y < p.height_px; ++y) {
    for (int x = 0; x < p.width_px; ++x) {
      turned[static_cast<std::size_t>(x) * static_cast<std::size_t>(p.height_px) +
             static_cast<std::size_t>(y)] =
          samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(p.width_px) +
                  static_cast<std::size_t>(x)];
    }
  }
  const EdgeMeasurement other = measure_edge({turned.data(), p.height_px, p.width_px});
  const double apart =
      std::abs(plain.mtf.all.mtf50->f_cy_per_px / other.mtf.all.mtf50->f_cy_per_px - 1);
  samples[100] = std::numeric_limits<float>::quiet_NaN();
  samples[5000] = std::numeric_limits<float>::infinity();
  ++n;
  fine += measure_edge({samples.data(), p.width_px, p.height_px}).mtf.all.mtf50 ? 1 : 0;
  std::ranges::fill(samples, std::numeric_limits<float>::quiet_NaN());
  ++n;
  fine += measure_edge({samples.data(), p.width_px, p.height_px}).status == EdgeStatus::kRefused;
  tell(14, "0 to 11 px, NaN, infinities; transposed", "answered; the same to 1e-9",
       fmt::format("{} of {} answered; {:.1e} apart", fine, n, apart), fine == n && apart <= 1e-9);
}

}  // namespace
}  // namespace reseau

int main(int argc, char** argv) {
  const int first = argc > 1 ? std::atoi(argv[1]) : 1;
  const int last = argc > 2 ? std::atoi(argv[2]) : argc > 1 ? first : 14;
  const auto within = [&](int bar) { return first <= bar && bar <= last; };
  fmt::print("| bar | on | wanted | measured | |\n| --- | --- | --- | --- | --- |\n");
  reseau::noise_free(first, last);
  reseau::noisy(first, last);
  reseau::hard(first, last);
  if (within(9)) reseau::refusals();
  if (within(11)) reseau::real_scans();
  if (within(12)) reseau::times();
  if (within(13))
    fmt::print("| 13 | random target | | calibration_unit RandomTarget.* tells it | |\n");
  if (within(14)) reseau::odd_input();
  return 0;
}
