# ThreadSanitizer, DCHECK on:
#   cmake -C tests/cmake/tsan.cmake -S . -B build/tsan -G Ninja
#   TSAN_OPTIONS=suppressions=$PWD/tests/cmake/tsan.supp ctest --test-dir build/tsan
set(CMAKE_CXX_COMPILER g++ CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1" CACHE STRING "")
set(CMAKE_CXX_FLAGS "-fsanitize=thread" CACHE STRING "")
