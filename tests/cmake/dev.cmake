# For daily work: cmake -C tests/cmake/dev.cmake -S . -B build/dev -G Ninja
# Optimised enough to run the whole suite, with DCHECK, debug symbols and warnings as errors.
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g" CACHE STRING "")
set(RESEAU_WERROR ON CACHE BOOL "")
find_program(ccache_program ccache)
if(ccache_program)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ccache_program} CACHE STRING "")
endif()
