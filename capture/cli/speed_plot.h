// Size against time of reconstructions.
#pragma once

#include <string>
#include <vector>

namespace reseau::cli {

struct SpeedPoint {
  double megapixels = 0;
  std::string quality;
  int n_threads = 0;
  double seconds = 0;
};

// A line for every quality and number of threads, both axes logarithmic. Pure.
[[nodiscard]] std::string speed_plot(const std::vector<SpeedPoint>& points);

}  // namespace reseau::cli
