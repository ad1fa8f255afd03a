// Time against error of the qualities of reconstruction.
#pragma once

#include <string>
#include <vector>

namespace reseau::cli {

struct QualityPoint {
  std::string quality;
  double seconds = 0;  // of one processor, per megapixel, registration included
  double delta_e = 0;  // CIEDE2000 at the scale of elements
};

// What all runs of one quality come to.
struct QualityMean {
  std::string quality;
  double seconds = 0, delta_e = 0;
  bool on_front = false;  // no other quality is both quicker and truer
};

// In the order in which qualities first appear.
[[nodiscard]] std::vector<QualityMean> quality_means(const std::vector<QualityPoint>& points);

// Every run as a dot, the means, and the Pareto front between them. Pure.
[[nodiscard]] std::string quality_plot(const std::vector<QualityPoint>& points);

}  // namespace reseau::cli
