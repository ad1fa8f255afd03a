// The profile of an edge as a penalised cubic spline. Pure, reentrant.
#pragma once

#include <span>
#include <vector>

namespace reseau::compare {

// Samples of a profile gathered in fine bins: exact for the fit as long as the profile is straight
// within a bin (1/32 px).
class ProfileBins {
 public:
  explicit ProfileBins(double half_width_px);
  // Ignores what lies beyond the half width.
  void add(double distance_px, double value);

  [[nodiscard]] double half_width_px() const { return half_width_px_; }
  [[nodiscard]] double count() const { return n_; }
  [[nodiscard]] double sum_of_squares() const { return squares_; }
  // Largest distance within +-range_px that no sample covers.
  [[nodiscard]] double widest_gap_px(double range_px) const;

  struct Bin {
    double n = 0, distance = 0, value = 0;  // sums
  };
  [[nodiscard]] std::span<const Bin> bins() const { return bins_; }

 private:
  double half_width_px_;
  double n_ = 0, squares_ = 0;
  std::vector<Bin> bins_;
};

class EdgeSpline {
 public:
  // `relative_penalty` <= 0: chosen by generalised cross-validation.
  EdgeSpline(const ProfileBins& samples, double relative_penalty);

  [[nodiscard]] double value(double distance_px) const;
  [[nodiscard]] double slope(double distance_px) const;
  // Root mean square of the samples about the profile.
  [[nodiscard]] double residual() const { return residual_; }
  // Of the derivative, magnitude, 1 at 0.
  [[nodiscard]] double mtf(double cy_per_px) const;
  // Sum of all rises and falls, and the net rise.
  [[nodiscard]] double variation() const;
  [[nodiscard]] double rise() const { return coefficients_.back() - coefficients_.front(); }

 private:
  double half_width_px_;
  std::vector<double> coefficients_;
  double residual_ = 0;
};

}  // namespace reseau::compare
