#include "calibration/random/random_cells.h"

#include <cmath>
#include <cstddef>

namespace reseau {
namespace {

std::uint64_t stirred(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

}  // namespace

RandomCells::RandomCells(const RandomTarget& target) : target_(target) {
  const auto n = static_cast<std::size_t>(target.n_cells);
  clear_.reserve(n * n);
  for (std::uint64_t row = 0; row < n; ++row) {
    for (std::uint64_t column = 0; column < n; ++column) {
      const std::uint64_t key = target.seed * 0x9E3779B97F4A7C15ULL +
                                column * 0xD1B54A32D192ED03ULL + row * 0x8CB92BA72F3D8DD7ULL;
      clear_.push_back(static_cast<std::uint8_t>(stirred(stirred(key)) >> 63));
    }
  }
}

std::int64_t RandomCells::cell_at(double px) const {
  return static_cast<std::int64_t>(std::floor(px / target_.cell_px + 0.5 * target_.n_cells));
}

}  // namespace reseau
