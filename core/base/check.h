// CHECK: abort with the expression, in every build, when the program itself is wrong. Never for bad
// input. DCHECK: only inside loops over pixels, gone with NDEBUG. The message names the file
// without its folder, so that no path of the building machine is in the program.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace reseau::detail {
[[noreturn]] inline void check_failed(const char* expression, const char* file, int line) {
  std::fprintf(stderr, "reseau: internal error: %s at %s:%d\n", expression, file, line);
  std::abort();
}
}  // namespace reseau::detail

#define CHECK(condition) \
  ((condition) ? void(0) : ::reseau::detail::check_failed(#condition, __FILE_NAME__, __LINE__))

#ifdef NDEBUG
#define DCHECK(condition) void(0)
#else
#define DCHECK(condition) CHECK(condition)
#endif
