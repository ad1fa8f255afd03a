// The work on one region, from pixels to figures. Part of measure_edge.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "calibration/edge/measure_edge.h"
#include "calibration/edge/optics.h"
#include "calibration/edge/pixel_fit.h"
#include "calibration/edge/profile_fit.h"
#include "core/base/span2d.h"

namespace reseau::edge {

// Every step may refuse.
class EdgeWork {
 public:
  EdgeWork(Span2D<const float> samples, const EdgeOptions& options)
      : samples_(samples), options_(options) {}

  EdgeMeasurement run();

 private:
  bool refuse(EdgeReason reason) {
    out_.reasons.push_back(reason);
    return false;
  }
  bool begin();
  bool approach();
  bool check_region();
  bool fit();
  void tell();

  void place(const EdgeLine& line);
  [[nodiscard]] bool settle(double reach, int most_rounds, int n_shape, bool with_along);
  void choose_shape();
  [[nodiscard]] ProfileFunction gaussian() const;
  [[nodiscard]] ProfileFunction fitted() const;
  [[nodiscard]] NormalCosines cosines() const;
  [[nodiscard]] PixelModel with_levels() const;
  void weigh_edge();
  void follow_lines();
  void weigh_sides(const ProfileFunction& profile);
  std::vector<ProfileSample> gather();
  [[nodiscard]] double contrast() const {
    return std::abs(model_.levels.bright - model_.levels.dark);
  }

  Span2D<const float> samples_;
  EdgeOptions options_;
  EdgeMeasurement out_;
  PixelModel model_;
  std::vector<unsigned char> used_;
  double width_ = 1;  // Gaussian width of the edge
  double rms_ = 0;    // of the residuals to the Gaussian edge
  double cell_ = 1;
  int n_shape_ = 0;
  double plateau_noise_ = 0;        // of the noisier side, in units of the samples
  std::vector<double> line_shift_;  // of the edge, by line of pixels; empty: none
  double edge_noise_ = 0;           // variance of the place of the edge over that of a sample
  double dark_weight_ = 1, bright_weight_ = 1;
  std::optional<ProfileFit> fit_;
  std::vector<ProfileSample> gathered_;
};

}  // namespace reseau::edge
