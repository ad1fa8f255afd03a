// One model of a unit's optics for all its edges at once: channels, directions, focus settings.
//
// A single edge cannot tell a wide lens from a wide Gaussian, nor one side of the aperture from the
// other. Edges of several channels, directions and focus settings share what the scanner shares:
//   aperture (both sides), halo, and the length that a step of focus moves  the unit
//   cut-off of the lens, Gaussian, best focus                               a channel
//   place and levels                                                        an edge
// All are fitted to the profiles of all edges together by least squares (Ceres), weighted by the
// noise that each edge shows. What the edges at hand cannot tell is said, not hidden. Pure,
// reentrant, the same result for the same input.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/edge/optics.h"
#include "calibration/edge/profile_bins.h"

namespace reseau {

// Of light in red, green, blue and infrared, as a film scanner's lamps have it: a length out of
// focus is the more waves the shorter they are.
inline constexpr std::array<double, 4> kPsfWavelengths_um{0.64, 0.53, 0.46, 0.87};

// What measure_edge found of one edge in one channel.
struct PsfEdge {
  int channel = 1;              // 0 to 3: red, green, blue, infrared
  std::optional<double> focus;  // setting of the unit, in its own steps
  NormalCosines normal;
  double reach_px = 0;                 // the profile is known within +-reach_px, at most 100
  double noise = 0;                    // of a sample of weight 1, of the contrast
  std::vector<ProfileBins::Bin> bins;  // dark side at 0, bright side at 1
  EdgeOptics optics;                   // as found from this edge alone
  double mtf50_cy_per_px = 0;
};

struct PsfParameter {
  std::string name;  // "aperture_x_px", "green.diffraction_px", …
  double value = 0;
  // Standard deviation, enlarged where the model explains the edges less well than noise allows;
  // meaningless where the edges do not determine the parameter.
  double sd = 0;
  bool determined = true;
};

struct PsfCorrelation {
  std::string a, b;
  double r = 0;
};

struct PsfFit {
  bool ok = false;
  std::string why;  // a sentence, when not ok

  std::vector<PsfParameter> parameters;
  // Covariance of the first of them (those that were fitted, not derived), row by row; zero in
  // directions that are not determined.
  std::vector<double> covariance;
  int rank = 0;                            // of as many parameters
  std::vector<PsfCorrelation> correlated;  // pairs beyond +-0.95
  std::vector<std::string> remarks;        // sentences on what cannot be told, and why
  double chi2_per_freedom = 0;             // 1 = the model explains all but noise
  std::vector<double> misfit;              // rms of each edge, of the contrast
  struct Residual {
    double d_px = 0, value = 0;  // edge minus model, of the contrast, mean over 1/8 px
  };
  std::vector<std::vector<Residual>> residuals;  // of each edge
  std::vector<EdgeOptics> optics;                // of each edge, as all edges share them
  bool has_halo = false, has_focus = false;

  [[nodiscard]] const PsfParameter* find(const std::string& name) const;
};

// At least one edge, each with 12 bins or more, noise above 0 and a reach of at most 98 px; else
// not ok. A halo is taken in only where the edges ask for it. With three focus settings or more the
// best focus of each channel is found, in the unit's steps (and the path that a step adds), else
// the defocus of each channel in waves (without its sign, which a single setting does not tell).
// `stop`, where there is one, is asked now and then from the calling thread: true ends the fit,
// which is then not ok.
[[nodiscard]] PsfFit fit_psf(std::span<const PsfEdge> edges,
                             const std::function<bool()>& stop = {});

}  // namespace reseau
