// The parameters of fit_psf and how an edge depends on them. Part of fit_psf.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibration/psf/psf_fit.h"

namespace ceres {
class CostFunction;
class Problem;
}  // namespace ceres

namespace reseau::psf {

inline constexpr int kChannels = 4;

// Signed squares, as in EdgeOptics. A step of focus moves the film by the same length in every
// channel: by path_per_step [um of path at the edge of the pupil, dz / (8 N^2)], which are the more
// waves the shorter they are. Defocus of an edge is path_per_step * (focus - best) / wavelength;
// without focus settings, focus = 0, path_per_step = -1 and a wave counts 1, so that `best` is the
// defocus itself.
struct Unknowns {
  double aperture2 = 1, aspect2 = 1, halo = 0, halo_sigma = 6, path_per_step = -1;
  bool in_waves = true;  // no focus settings
  struct Channel {
    bool used = false;
    double diffraction = 0.8, sigma2 = 0.05, best = 0.3;
  };
  std::array<Channel, kChannels> channels;
  struct Edge {
    double offset = 0, dark = 0, bright = 1;
  };
  std::vector<Edge> edges;

  [[nodiscard]] EdgeOptics optics(int channel, double focus) const;
  [[nodiscard]] double waves_per_path(int channel) const;
};

// Which of the shared parameters are free.
struct Freedom {
  bool aspect = false, halo = false, path_per_step = false;
};

// One parameter that is free: where it is, and what it is called.
struct FreeParameter {
  double* value = nullptr;
  std::string name;
};

// Sets up the least squares for `edges` in `unknowns`, which it keeps pointers to. `shared` lists
// the free parameters of unit and channels.
struct Setup {
  Setup();
  ~Setup();
  Setup(const Setup&) = delete;
  Setup& operator=(const Setup&) = delete;

  std::unique_ptr<ceres::Problem> problem;
  std::vector<FreeParameter> shared;
};
[[nodiscard]] std::unique_ptr<Setup> set_up(std::span<const PsfEdge> edges, const Freedom& freedom,
                                            Unknowns& unknowns);

[[nodiscard]] const char* channel_name(int channel);

// Parameters of one edge, each a block of one number: what it shares, then its own.
enum Block : int {
  kBlockAperture,
  kBlockAspect,
  kBlockHalo,
  kBlockHaloSigma,
  kBlockPath,
  kBlockDiffraction,
  kBlockSigma,
  kBlockBest,
  kBlockOffset,
  kBlockDark,
  kBlockBright,
  kBlocks
};
inline constexpr int kSharedBlocks = kBlockOffset;

// Residuals of the bins of one edge over their noise. Refers to `edge`. Evaluate: false where the
// profile cannot be computed.
[[nodiscard]] std::unique_ptr<ceres::CostFunction> edge_cost(const PsfEdge& edge, double focus,
                                                             double waves_per_path);

}  // namespace reseau::psf
