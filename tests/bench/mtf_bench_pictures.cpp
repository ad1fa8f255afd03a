// Bars of mtf_bench on pictures that are no edges, on real scans, on time and on odd input.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/mtf_bench.h"
#include "tests/support/tiff_planes.h"

namespace reseau::bench {

using test::EdgePicture;
using test::Planes;
using test::read_planes;
using test::Transfer2D;

void refusals(const Bars& bars) {
  constexpr int kSide = 72;
  const int n_seeds = bars.full ? 1000 : 60;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  int accepted[5] = {};
  for (int seed = 0; seed < n_seeds; ++seed) {
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
  tell(9, fmt::format("constant, noise, two edges, circle, saturated, {} of each", n_seeds),
       "all refused",
       fmt::format("accepted {}, {}, {}, {}, {}", accepted[0], accepted[1], accepted[2],
                   accepted[3], accepted[4]),
       std::all_of(std::begin(accepted), std::end(accepted), [](int n) { return n == 0; }));
  int refused = 0;
  const std::uint32_t n_valid = bars.full ? 1000 : 100;
  for (std::uint32_t i = 0; i < n_valid; ++i) {
    const EdgePicture p = usual(90.0 * i / n_valid, i % 2 == 0 ? 16 : 40, 0.03, i + 1);
    if (measure(p, test::gaussian_transfer(0.25)).status == EdgeStatus::kRefused) ++refused;
  }
  tell(9, "valid: noise 3 %, L 16 and 40, any angle", "99 % accepted",
       fmt::format("{} of {} refused", refused, n_valid),
       refused * 100 <= static_cast<int>(n_valid));
}

namespace {

EdgeMeasurement of_plane(const Planes& planes, std::size_t c) {
  return measure_edge({planes.samples[c].data(), planes.width, planes.height},
                      {.lowest = 0, .highest = 1, .quantum = 1.0 / 65535});
}

}  // namespace

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

namespace {

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

}  // namespace

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

}  // namespace reseau::bench
