// Work on several cores: oneTBB behind two functions, so that the sanitized build can put plain
// threads there (RESEAU_PLAIN_THREADS). ThreadSanitizer does not see the atomics of Debian's
// uninstrumented oneTBB and would take every hand-over of a task for a race.
#pragma once

#include <functional>

namespace reseau {

// Calls body(i) once for every 0 <= i < n, in any order, several at a time; returns when all are
// done. Results must not depend on the order. The first exception stops what has not begun and is
// thrown to the caller. May be nested.
void parallel_for(int n, const std::function<void(int)>& body);

// Runs work with at most n_threads threads for every parallel_for inside it; 0 = all cores.
void with_threads(int n_threads, const std::function<void()>& work);

}  // namespace reseau
