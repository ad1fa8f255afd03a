# ThreadSanitizer, DCHECK on, plain threads in the place of oneTBB (core/base/parallel.h):
#   cmake -C tests/cmake/tsan.cmake -S . -B build/tsan -G Ninja
set(CMAKE_CXX_COMPILER g++ CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1" CACHE STRING "")
set(CMAKE_CXX_FLAGS "-fsanitize=thread" CACHE STRING "")
set(RESEAU_PLAIN_THREADS ON CACHE BOOL "")
set(CMAKE_UNITY_BUILD ON CACHE BOOL "")
