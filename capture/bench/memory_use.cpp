#include "capture/bench/memory_use.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <malloc.h>

#include "core/base/parallel.h"

namespace reseau {
namespace {

// Of a line "VmHWM:   12345 kB".
std::size_t status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.compare(0, key.size(), key) == 0) return std::stoull(line.substr(key.size())) * 1024;
  }
  return 0;
}

}  // namespace

std::size_t memory_in_use() { return status_bytes("VmRSS:"); }
std::size_t peak_memory() { return status_bytes("VmHWM:"); }

void reset_peak_memory() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;  // proc(5): resets VmHWM
}

double copy_bandwidth(int n_threads) {
  constexpr std::size_t kBytes = std::size_t{64} << 20;
  constexpr int kTimes = 7, kBlocks = 16;
  std::vector<char> from(kBytes, 1), to(kBytes, 2);
  std::array<double, kTimes> seconds{};
  with_threads(n_threads, [&] {
    for (double& taken : seconds) {
      const auto start = std::chrono::steady_clock::now();
      parallel_for(kBlocks, [&](int block) {
        constexpr std::size_t kPart = kBytes / kBlocks;
        const std::size_t at = kPart * static_cast<std::size_t>(block);
        std::memcpy(to.data() + at, from.data() + at, kPart);
      });
      taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
  });
  std::ranges::nth_element(seconds, seconds.begin() + kTimes / 2);
  return 2.0 * static_cast<double>(kBytes) / seconds[kTimes / 2];
}

}  // namespace reseau
