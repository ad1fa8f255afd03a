// Transfer of light along the normal of an edge: lens, sensor and what lies between, as a product
// of closed forms. Pure, reentrant.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace reseau {

// Parameters of a circular lens with defocus, a Gaussian, an aperture, a smear along one axis and a
// halo:
//   M(f) = [(1 - halo) T(f) G(f) + halo exp(-2 (pi halo_sigma f)^2)] A(f) S(f)
// T: diffraction with exact defocus, G: Gaussian, A: aperture with sides along the pixel grid,
// square unless aspect2 says otherwise (which one edge cannot know), S: box along the axis that is
// nearer to the normal of the edge.
//
// The first three, and the smear, are squares or lengths that may turn negative: the factor becomes
// 2 - (factor of the positive value), which continues it smoothly. An estimate whose true value is
// zero can so scatter to both sides, and is not pushed up by a bound.
struct EdgeOptics {
  double diffraction_px = 0.5;  // 1 / cut-off frequency = wavelength * f-number / pitch
  double sigma2_px2 = 0.05;     // variance of the Gaussian
  double aperture2_px2 = 1;     // square of the side of the aperture
  double smear2_px2 = 0;        // square of the length of the smear
  double w20_waves = 0;         // defocus at the edge of the pupil; its sign makes no difference
  double halo = 0;              // share of the light
  double halo_sigma_px = 6;
  double aspect2 = 1;  // square of the aperture's side along y over that along x
};

enum OpticsParameter : int {
  kDiffraction,
  kSigma2,
  kAperture2,
  kSmear2,
  kW20,
  kHalo,
  kHaloSigma,
  kAspect2,
  kOpticsParameters
};

[[nodiscard]] double& parameter(EdgeOptics& optics, int index);
[[nodiscard]] double parameter(const EdgeOptics& optics, int index);

// Direction of the normal as |cosines| to the axes of the grid.
struct NormalCosines {
  double x = 1, y = 0;
};

// M(f), signed, and dM/dp for each of `parameters`: out[0], out[1 + i].
void transfer(const EdgeOptics& optics, const NormalCosines& normal, double f_cy_per_px,
              std::span<const int> parameters, std::span<double> out);
[[nodiscard]] double transfer(const EdgeOptics& optics, const NormalCosines& normal,
                              double f_cy_per_px);

// Beyond this |M| stays below 1e-7, or it is `most`.
[[nodiscard]] double highest_frequency(const EdgeOptics& optics, double most);

}  // namespace reseau
