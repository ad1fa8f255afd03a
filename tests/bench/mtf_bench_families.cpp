// Bars of mtf_bench on rendered edges: without noise, in noise, and with what real scans have.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/mtf_bench.h"

namespace reseau::bench {

using test::EdgePicture;
using test::Transfer2D;

namespace {

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

// Of a Gaussian with a free second parameter, levels and line [%].
double bound_percent(double mtf50, double noise, double length) {
  return 660 * noise * std::sqrt(mtf50 / length);
}

}  // namespace

void noise_free(const Bars& bars) {
  if (bars.holds(1)) {
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
  if (!bars.holds(2)) return;
  for (const Family& family : families()) {
    Errors all;
    for (const double angle : {1.0, 5.0, 10.0, 14.04, 18.43, 26.565, 36.87, 40.0})
      all.add(usual(angle), family.transfer);
    tell(2, std::string("no noise, ") + family.name, "MTF50 .15 %, M 10e-4",
         fmt::format("{:.3f} %, {:.1f}e-4, {} refused", all.most, 1e4 * all.of_curve, all.refused),
         all.most <= 0.15 && all.of_curve <= 1e-3);
  }
}

void noisy(const Bars& bars) {
  if (bars.holds(3)) {
    for (const bool lens : {false, true}) {
      const Transfer2D t = lens ? test::airy_box_transfer(8) : test::gaussian_transfer(0.25);
      Errors all;
      const std::uint32_t n = bars.full ? 200 : 60;
      for (std::uint32_t i = 0; i < n; ++i) {
        all.add(usual(1 + 43.5 * i / n, 100, 0.005, i + 1), t);
      }
      const double bound = bound_percent(lens ? 0.337 : 0.25, 0.005, 100);
      tell(3, fmt::format("noise 0.5 %, {}, {} edges", lens ? "f/8" : "Gaussian .25", n),
           fmt::format("bias {} %, sd {:.3f} % (1.15 × limit), max .7 %", lens ? ".2" : ".05",
                       1.15 * bound),
           fmt::format("{:+.3f}, {:.3f}, {:.2f} %", all.mean(), all.sd(), all.most),
           std::abs(all.mean()) <= (lens ? 0.2 : 0.05) && all.sd() <= 1.15 * bound &&
               all.most <= 0.7);
    }
  }
  if (bars.holds(4)) {
    for (const double mtf50 : {0.05, 0.25, 0.5}) {
      for (const double noise : {0.002, 0.02}) {
        for (const double length : {25.0, 100.0}) {
          Errors all;
          const std::uint32_t n = bars.full ? 32 : 8;
          for (std::uint32_t i = 0; i < n; ++i) {
            all.add(usual(3 + 34.4 * i / n, length, noise, i + 1), test::gaussian_transfer(mtf50));
          }
          const double wanted = 1.25 * bound_percent(mtf50, noise, length) + 0.05;
          tell(4, fmt::format("Gaussian {}, noise {} %, L {}", mtf50, 100 * noise, length),
               fmt::format("rms {:.3f} %", wanted),
               fmt::format("{:.3f} % ({} refused)", all.rms(), all.refused), all.rms() <= wanted);
        }
      }
    }
  }
  if (bars.holds(5)) {
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
  if (bars.holds(6)) {
    std::vector<Family> all = families();
    all.push_back({"exponential", test::exponential_transfer(0.5, 0.4)});
    double z2 = 0;
    int n = 0, covered = 0;
    std::uint32_t seed = 1;
    for (const Family& family : all) {
      const int each = bars.full ? 50 : 12;
      for (int i = 0; i < each; ++i) {
        EdgePicture p = usual(2.3 + 40.8 * i / each, 80, 0.01, ++seed);
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

void hard(const Bars& bars) {
  const Transfer2D t = test::gaussian_transfer(0.25);
  if (bars.holds(7)) {
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
  if (bars.holds(8)) {
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
  if (bars.holds(10)) {
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

}  // namespace reseau::bench
