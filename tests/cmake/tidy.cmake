# What clang-tidy reads: how each file compiles by itself, so that it must name what it uses.
#   cmake -C tests/cmake/tidy.cmake -S . -B build/tidy -G Ninja     (nothing needs to be built)
set(CMAKE_CXX_COMPILER clang++-14 CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
