// Pictures of straight and bent edges whose transfer function is known exactly: the profile is
// integrated from the transfer function in closed form. Shares no code with calibration/edge.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace reseau::test {

// Transfer at (fx, fy) cycles per pixel, pixel aperture included.
using Transfer2D = std::function<double(double fx, double fy)>;

[[nodiscard]] Transfer2D gaussian_transfer(double mtf50_cy_per_px);
// Lens of this f-number at 0.55 um on square pixels of 4.73 um, with defocus [waves].
[[nodiscard]] Transfer2D airy_box_transfer(double f_number, double w20_waves = 0);
// `inner` smeared over `length_px` along x.
[[nodiscard]] Transfer2D smeared(const Transfer2D& inner, double length_px);
// A share of the light spread by a wide Gaussian.
[[nodiscard]] Transfer2D with_halo(const Transfer2D& inner, double share, double sigma_px);
// Unsharp masking: (1 + amount) - amount * Gaussian.
[[nodiscard]] Transfer2D sharpened(const Transfer2D& inner, double amount, double sigma_px);
// Profile with exponential tails: 1 / (1 + (2 pi f a)^2) times a Gaussian of sigma px.
[[nodiscard]] Transfer2D exponential_transfer(double a_px, double sigma_px);

struct EdgePicture {
  int width_px = 0, height_px = 0;
  double normal_deg = 5;   // direction in which it gets brighter
  double offset_px = 0.3;  // of the edge from the middle, along the normal
  double dark = 0.2, bright = 0.8;
  double bow_px = 0;        // sagitta over the length of the edge
  double shade_across = 0;  // change of the light from one side of the picture to the other / 2
  double shade_along = 0;
  double noise = 0;              // of the contrast, white
  double noise_correlation = 0;  // AR(1) between neighbours in both directions
  double dust_spots = 0, hot_share = 0;
  double clip_high = 0;  // share of the contrast cut off at the bright end
  int bits = 16;         // 0: no rounding
  std::uint32_t seed = 1;
};

// Size of the usual region: (L tan(angle) + 72) x L, turned so that the edge runs along L.
void set_usual_region(EdgePicture& picture, double length_px);

[[nodiscard]] std::vector<float> render(const EdgePicture& picture, const Transfer2D& transfer);

// Along the normal; where |M| first falls below `level`, to 1e-10.
[[nodiscard]] double true_transfer(const EdgePicture& picture, const Transfer2D& transfer,
                                   double f);
[[nodiscard]] double true_crossing(const EdgePicture& picture, const Transfer2D& transfer,
                                   double level);

}  // namespace reseau::test
