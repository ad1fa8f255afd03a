#pragma once

#include <cstddef>

namespace reseau {

// Physical memory of this process: now, and at most since reset_peak_memory() [bytes]; 0 where the
// system does not say (/proc/self/status).
[[nodiscard]] std::size_t memory_in_use();
[[nodiscard]] std::size_t peak_memory();
// Gives back what is free, and counts the peak from here on.
void reset_peak_memory();

// What the machine copies in memory with so many threads, bytes read and bytes written together
// [bytes/s]: the median of some copies of blocks far larger than any cache.
[[nodiscard]] double copy_bandwidth(int n_threads);

}  // namespace reseau
