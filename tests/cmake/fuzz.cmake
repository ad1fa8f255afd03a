# libFuzzer with ASan and UBSan, clang:
#   cmake -C tests/cmake/fuzz.cmake -S . -B build/fuzz -G Ninja
#   cmake --build build/fuzz --target fuzz_usbip
#   build/fuzz/bin/fuzz_usbip -max_total_time=60 FOLDER tests/fuzz/corpus/usbip
set(CMAKE_CXX_COMPILER clang++-14 CACHE STRING "")
set(CMAKE_BUILD_TYPE Debug CACHE STRING "")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -gline-tables-only" CACHE STRING "")
set(CMAKE_CXX_FLAGS
  "-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer"
  CACHE STRING "")
set(RESEAU_FUZZ ON CACHE BOOL "")
