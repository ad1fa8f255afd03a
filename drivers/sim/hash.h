// Counter-based random numbers: a value depends on its key alone, so results do not depend on the
// order in which they are asked for.
#pragma once

#include <cstdint>

namespace reseau::sim {

// Finaliser of the SplitMix64 generator (Steele, Lea, Flood 2014).
[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

[[nodiscard]] constexpr std::uint64_t mix64(std::uint64_t key, std::uint64_t counter) {
  return mix64(key + 0x9e3779b97f4a7c15ULL * (counter + 1));
}

// Uniform in [-1, 1).
[[nodiscard]] constexpr float signed_unit(std::uint64_t bits) {
  return static_cast<float>(static_cast<double>(bits >> 11) * 0x1.0p-52 - 1.0);
}

}  // namespace reseau::sim
