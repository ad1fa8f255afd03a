// Loops compiled twice: for any processor and for those with registers of eight floats.
#pragma once

namespace reseau::sim {

// Marks what widest() runs: `widest([&]() RESEAU_SIM_INLINE { ... })`.
#define RESEAU_SIM_INLINE __attribute__((always_inline))

#if defined(__x86_64__)
// Of this processor; tests switch it off, while nothing renders.
[[nodiscard]] inline bool& has_wide_registers() {
  static bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}
template <typename Loop>
__attribute__((target("avx2"))) void run_wide(const Loop& loop) {
  loop();
}
#endif

// Runs a loop over floats. Both versions do the same operations in the same order (nothing is fused
// or regrouped), so the numbers are the same on every machine.
template <typename Loop>
inline void widest(const Loop& loop) {
#if defined(__x86_64__)
  if (has_wide_registers()) {
    run_wide(loop);
    return;
  }
#endif
  loop();
}

}  // namespace reseau::sim
