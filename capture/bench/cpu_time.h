#pragma once

#include <ctime>

namespace reseau {

// CPU time of all threads of the process so far [s], so that other work on the machine does not
// count.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace reseau
