// Samples of an edge profile, gathered in bins so narrow that the profile is straight within one.
#pragma once

#include <cstddef>
#include <vector>

namespace reseau {

class ProfileBins {
 public:
  // 1/64 px wide within 8 px of the edge, 1/16 px beyond.
  explicit ProfileBins(double reach_px);
  void add(double distance_px, double value, double weight);

  struct Bin {
    double weight = 0, distance = 0, value = 0;  // sum of weights; means
    // Weighted sums about the means, and how many samples more than one there are.
    double dd = 0, dv = 0, vv = 0, freedom = 0;
    // Scatter about a straight line of this slope.
    [[nodiscard]] double scatter(double slope) const { return vv - slope * (2 * dv - slope * dd); }
  };
  // Bins that hold samples, from the dark side to the bright.
  [[nodiscard]] std::vector<Bin> bins() const;
  [[nodiscard]] double count() const { return n_; }

 private:
  struct Sums {
    double n = 0, weight = 0, distance = 0, value = 0, dd = 0, dv = 0, vv = 0;
  };
  double reach_;
  double n_ = 0;
  std::vector<Sums> sums_;
};

}  // namespace reseau
