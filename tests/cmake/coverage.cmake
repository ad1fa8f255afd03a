# Which lines the tests reach: cmake -C tests/cmake/coverage.cmake -S . -B build/coverage -G Ninja,
# build, ctest, then gcov (of g++) on the .gcda files of build/coverage.
set(CMAKE_CXX_COMPILER g++ CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O0 -g" CACHE STRING "")
set(CMAKE_CXX_FLAGS "--coverage -fprofile-abs-path" CACHE STRING "")
