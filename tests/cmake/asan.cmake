# AddressSanitizer and UndefinedBehaviorSanitizer, clang, warnings as errors, DCHECK on:
#   cmake -C tests/cmake/asan.cmake -S . -B build/asan -G Ninja
set(CMAKE_CXX_COMPILER clang++-14 CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -gline-tables-only" CACHE STRING "")
set(CMAKE_CXX_FLAGS
  "-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer" CACHE STRING "")
set(RESEAU_WERROR ON CACHE BOOL "")
# In unity, which halves the time; clang-tidy reads every file alone (tidy.cmake).
set(CMAKE_UNITY_BUILD ON CACHE BOOL "")
