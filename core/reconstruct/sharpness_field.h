// How the blur changes over the frame: film is never quite flat, and a lens never quite even.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/vec2.h"

namespace reseau {

// Variance of the blur as a polynomial of the place; defocus adds its square. Immutable,
// thread-safe. A default one is 0.7 px everywhere.
class BlurSurface {
 public:
  static constexpr int kMostDegree = 4;

  BlurSurface() = default;
  explicit BlurSurface(double sigma_px) : least_(sigma_px), most_(sigma_px) {
    coefficients_ = {sigma_px * sigma_px};
  }
  // coefficients: 1, x, y, x^2, xy, y^2, ... of coordinates that run from -1 to 1 over the frame;
  // values outside [least_px, most_px], which was seen, are not believed.
  BlurSurface(std::vector<double> coefficients, Vec2 frame_px, double least_px, double most_px)
      : coefficients_(std::move(coefficients)),
        frame_px_(frame_px),
        least_(least_px),
        most_(most_px) {}
  // The same, with the covariance of the coefficients, row by row.
  BlurSurface(std::vector<double> coefficients, std::vector<double> covariance, Vec2 frame_px,
              double least_px, double most_px)
      : BlurSurface(std::move(coefficients), frame_px, least_px, most_px) {
    covariance_ = std::move(covariance);
  }

  [[nodiscard]] double sigma_px(Vec2 p) const;
  // Standard deviation of sigma_px there; 0 where nothing is known of it (a constant, a mixture).
  [[nodiscard]] double sd_px(Vec2 p) const;
  [[nodiscard]] int degree() const;
  // Least and most over the frame.
  [[nodiscard]] std::array<double, 2> range_px() const;
  // The sum of two surfaces' variances with these factors, over the same frame.
  [[nodiscard]] static BlurSurface mixed(const BlurSurface& a, double of_a, const BlurSurface& b,
                                         double of_b);

  [[nodiscard]] const std::vector<double>& coefficients() const { return coefficients_; }
  // Terms of a polynomial at x, y, up to the degree; returns how many.
  static std::size_t terms(double x, double y, int degree, std::array<double, 15>& out);

 private:
  std::vector<double> coefficients_{0.49};
  std::vector<double> covariance_;  // empty = not known
  Vec2 frame_px_{1, 1};
  double least_ = 0.7, most_ = 0.7;
};

// A blur found at a place.
struct BlurSample {
  Vec2 at_px;
  double variance_px2 = 0;
  double sd = 0;  // of that variance
};

// The lowest degree that predicts samples left out of the fit about as well as any; robust against
// places that err. A constant when there are few samples. `base` is added: the samples are then
// fitted as what they differ from it.
[[nodiscard]] BlurSurface fit_blur_surface(const std::vector<BlurSample>& samples, Vec2 frame_px,
                                           int most_degree, const BlurSurface* base);

}  // namespace reseau
