#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "capture/bench/stress_bench.h"

namespace reseau {
namespace {

constexpr const char* kFilm = "width_px=480&height_px=480&scene=natural";

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity(),
                 kDenormal = std::numeric_limits<double>::denorm_min();

void reverse(StressInput input) {
  for (std::uint16_t& sample : input.scan.samples)
    sample = static_cast<std::uint16_t>(65535 - sample);
}

// The right half is another film, turned by 40 degrees.
void join_another(StressInput input) {
  const sim::SimulatedScan other =
      sim::simulate_frame(sim::parse_sim_spec(fmt::format("ls5000?{}&angle=63", kFilm)));
  const auto width = static_cast<std::size_t>(input.scan.format.width_px);
  for (std::size_t row = 0; row < input.scan.samples.size(); row += width) {
    const auto first = static_cast<std::ptrdiff_t>(row + width / 2),
               end = static_cast<std::ptrdiff_t>(row + width);
    std::copy(other.samples.begin() + first, other.samples.begin() + end,
              input.scan.samples.begin() + first);
  }
}

void add_parameters(std::vector<StressCase>& cases) {
  const auto add = [&](const char* name, void (*harm)(StressInput)) {
    cases.push_back({"parameters", name, kFilm, harm});
  };
  add("white level NaN", [](StressInput in) { in.options.white_level = kNan; });
  add("white level infinite", [](StressInput in) { in.options.white_level = kInfinity; });
  add("white level denormal", [](StressInput in) { in.options.white_level = kDenormal; });
  add("black level NaN", [](StressInput in) { in.options.black_level = kNan; });
  add("black at white", [](StressInput in) { in.options.black_level = 1; });
  add("blur NaN", [](StressInput in) { in.options.blur_px = kNan; });
  add("blur 1e-9 px", [](StressInput in) { in.options.blur_px = 1e-9; });
  add("blur 10 px", [](StressInput in) { in.options.blur_px = 10; });
  add("scale NaN", [](StressInput in) { in.options.frame.scale = kNan; });
  add("scale 0", [](StressInput in) { in.options.frame.scale = 0; });
}

void add_by_lot(std::vector<StressCase>& cases, int n_random, unsigned seed) {
  struct Range {
    const char* key;
    double least, most;
  };
  constexpr std::array kRanges{
      Range{"angle", -90, 90}, Range{"period_um", 20, 110}, Range{"axes", 84, 96},
      Range{"blur_px", 0, 3},  Range{"ir_blur_px", 0, 3},   Range{"noise", 0, 0.2},
      Range{"fade", 0, 1},     Range{"bend_px", 0, 8},      Range{"border_px", 0, 200},
      Range{"level", 0.05, 3}, Range{"wave_px", 0, 1},      Range{"jitter_px", 0, 0.3},
      Range{"dust", 0, 400},   Range{"radial", -0.01, 0.01}};
  std::mt19937 random(seed);
  for (int i = 0; i < n_random; ++i) {
    std::string film = fmt::format("{}&seed={}", kFilm, i + 1);
    for (const Range& range : kRanges) {
      // Half of them keep what they usually are. The same numbers with every library.
      const double lot = static_cast<double>(random()) / 4294967296.0;
      if (lot < 0.5) continue;
      film += fmt::format("&{}={:.4f}", range.key,
                          range.least + (2 * lot - 1) * (range.most - range.least));
    }
    cases.push_back({"by lot", fmt::format("number {} of seed {}", i + 1, seed), film});
  }
}

}  // namespace

std::vector<StressCase> stress_cases(int n_random, unsigned seed) {
  std::vector<StressCase> cases;
  const auto add = [&](const char* group, std::string name, const std::string& film) {
    cases.push_back({group, std::move(name), fmt::format("{}&{}", kFilm, film)});
  };
  // 3.04 px leave 0.05 of the contrast at a period of 7.8 px.
  for (const double blur : {0.0, 1.5, 2.5, 3.04, 4.0})
    add("blur", fmt::format("blur {} px", blur),
        fmt::format("blur_px={0}&ir_blur_px={0}&angle=23", blur));
  for (const double noise : {0.04, 0.12, 0.3})
    add("noise", fmt::format("noise {:.0f} % of clear film", 100 * noise),
        fmt::format("noise={}&angle=23", noise));
  for (const int angle : {-67, 0, 45, 90})
    add("angle", fmt::format("{} degrees", angle), fmt::format("angle={}", angle));
  add("film", "mirrored", "mirrored=1&angle=23");
  add("film", "40 % black", "border_px=54&angle=23");
  add("film", "black throughout", "border_px=240");
  add("film", "dust and scratches", "dust=400&dust_um=60&scratches=20&angle=23");
  add("film", "bends by 6 px", "bend_px=6&angle=23");
  add("film", "a stage that errs by 1 px", "wave_px=1&wave_lines=120&angle=23");
  add("film", "eight times overexposed", "level=8&angle=23");
  add("film", "hardly any light", "level=0.01&angle=23");
  add("film", "no réseau", "film=none");
  for (const double fade : {0.9, 0.98, 1.0})
    add("unmixing", fmt::format("dyes faded by {:.0f} %", 100 * fade),
        fmt::format("fade={}&angle=23", fade));
  cases.push_back({"film", "contrast reversed", fmt::format("{}&angle=23", kFilm), reverse, false});
  cases.push_back({"film", "two réseaus", fmt::format("{}&angle=23", kFilm), join_another, false});
  for (const auto& [width, height] :
       {std::pair{16, 16}, {40, 40}, {16, 2000}, {2000, 16}, {64, 3000}, {3000, 64}, {128, 128}}) {
    cases.push_back({"size", fmt::format("{} x {} px", width, height),
                     fmt::format("width_px={}&height_px={}&scene=natural&angle=23&border_px=0",
                                 width, height)});
  }
  add_parameters(cases);
  add_by_lot(cases, n_random, seed);
  return cases;
}

}  // namespace reseau
