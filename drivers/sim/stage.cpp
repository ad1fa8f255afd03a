#include "drivers/sim/stage.h"

#include <cmath>
#include <numbers>

#include "drivers/sim/hash.h"

namespace reseau::sim {
namespace {

constexpr double kSideways = 1.0 / 3;  // of the lead screw's error

// Errors of one lead screw: two incommensurate periods.
double screw(double y) {
  return 0.6 * std::sin(2 * std::numbers::pi * y / 211.0 + 0.4) +
         0.4 * std::sin(2 * std::numbers::pi * y / 53.0 + 1.9);
}

// Normal deviate of a key: Box and Muller's transform of two uniform numbers.
double normal(std::uint64_t key) {
  const double u = (static_cast<double>(mix64(key, 0) >> 11) + 0.5) * 0x1.0p-53;
  const double v = static_cast<double>(mix64(key, 1) >> 11) * 0x1.0p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

// A random walk of unit steps at whole numbers, W(0) = 0, by halving intervals of a Brownian
// bridge: exact at every line without adding up all lines before it.
double walk(std::uint64_t key, std::int64_t line) {
  constexpr int kLevels = 24;
  const std::uint64_t side = line < 0 ? 1 : 0;
  const std::int64_t at = line < 0 ? -line : line;
  std::int64_t left = 0, right = std::int64_t{1} << kLevels;
  const std::uint64_t branch = mix64(key, side);
  double w_left = 0, w_right = std::sqrt(static_cast<double>(right)) * normal(branch);
  std::uint64_t node = 1;
  while (right - left > 1) {
    if (at == left) return w_left;
    const std::int64_t middle = (left + right) / 2;
    const double spread = 0.5 * std::sqrt(static_cast<double>(right - left));
    const double w = (w_left + w_right) / 2 + spread * normal(mix64(branch, node));
    if (at >= middle) {
      left = middle;
      w_left = w;
      node = 2 * node + 1;
    } else {
      right = middle;
      w_right = w;
      node = 2 * node;
    }
  }
  return at == left ? w_left : w_right;
}

}  // namespace

Stage::Stage(const StageSpec& spec, std::uint64_t seed)
    : spec_(spec),
      seed_(mix64(seed, 0x57a6e)),
      moves_(spec.wobble_px != 0 || spec.wave_px != 0 || spec.jitter_px != 0 || spec.walk_px != 0) {
}

double Stage::random_part(std::int64_t line) const {
  double error = 0;
  if (spec_.jitter_px != 0) {
    error += spec_.jitter_px * normal(mix64(mix64(seed_, 1), static_cast<std::uint64_t>(line)));
  }
  if (spec_.walk_px != 0) error += spec_.walk_px * walk(mix64(seed_, 2), line);
  return error;
}

StageError Stage::error_at(double y) const {
  if (!moves_) return {};
  const double lead = spec_.wobble_px == 0 ? 0.0 : spec_.wobble_px * screw(y);
  StageError error{kSideways * lead, lead};
  if (spec_.wave_px != 0) {
    const double wave = spec_.wave_px * std::sin(2 * std::numbers::pi * y / spec_.wave_lines +
                                                 spec_.wave_phase_deg * std::numbers::pi / 180);
    error.y += wave;
    error.x += spec_.sideways * wave;
  }
  if (spec_.jitter_px != 0 || spec_.walk_px != 0) {
    const double below = std::floor(y);
    const auto line = static_cast<std::int64_t>(below);
    const double t = y - below;
    error.y += (1 - t) * random_part(line);
    if (t > 0) error.y += t * random_part(line + 1);
  }
  return error;
}

StageError Stage::largest() const {
  constexpr double kSigmas = 6, kLines = 1e5;
  const double wobble = std::abs(spec_.wobble_px), wave = std::abs(spec_.wave_px);
  const double random = kSigmas * std::hypot(spec_.jitter_px, spec_.walk_px * std::sqrt(kLines));
  return {kSideways * wobble + std::abs(spec_.sideways) * wave, wobble + wave + random};
}

}  // namespace reseau::sim
