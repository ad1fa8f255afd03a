// The profile of an edge as physics plus what physics leaves over: a linear mixed model.
//
//   value(d) = (1 - E)(1 - ...) levels and shading + E(d; optics) + r(d)
//
// E is the profile that EdgeOptics predicts, its parameters fitted with weak priors; r a quintic
// spline whose variance is chosen by restricted maximum likelihood. What is told is the average
// over a grid of that variance (none included), with and without shading across the edge, and with
// the simplest optics as well as free ones, weighted by likelihood; the covariance includes the
// spread of that average.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "calibration/edge/dense.h"
#include "calibration/edge/mean_profile.h"
#include "calibration/edge/profile_bins.h"
#include "calibration/edge/residual_spline.h"

namespace reseau {

struct ProfileFitOptions {
  NormalCosines normal;
  double reach_px = 30;
  double width_px = 0.8;       // Gaussian width of the edge, roughly
  double least_noise = 2e-5;   // of the contrast: never believe less
  bool residual = true;        // false: physics alone (phases of the grid not covered)
  bool shading_across = true;  // may be tried
};

// Which optics are thought likely.
enum class OpticsPrior {
  kFree,        // any, roughly as wide as the edge
  kFullPixels,  // pixels as wide as they lie apart, and nothing but the lens before them
  kGaussian     // a Gaussian alone
};

// One set of variances and what it gives.
struct ProfileMember {
  double tau = 0;  // of the spline; 0: none
  OpticsPrior prior = OpticsPrior::kFree;
  bool shading = false;  // across the edge
  double criterion = 0;  // -2 log restricted likelihood, smaller is better
  double weight = 0;     // share in the average
  std::vector<double> beta;
  std::shared_ptr<const Cholesky> precision;  // of beta, 1/variance units
};

class ProfileFit {
 public:
  // `start`: optics of an earlier fit, which spares the search.
  ProfileFit(const ProfileBins& bins, const ProfileFitOptions& options,
             const std::optional<EdgeOptics>& start);

  [[nodiscard]] bool ok() const { return !members_.empty(); }
  [[nodiscard]] const EdgeOptics& optics() const { return optics_; }
  [[nodiscard]] const std::vector<int>& parameters() const { return parameters_; }
  [[nodiscard]] const MeanProfile& mean() const { return *mean_; }
  [[nodiscard]] const ResidualSpline& spline() const { return *spline_; }
  // Heaviest first; weights sum to 1.
  [[nodiscard]] std::span<const ProfileMember> members() const { return members_; }
  [[nodiscard]] const ProfileMember& best() const { return members_.front(); }
  [[nodiscard]] const std::vector<ProfileBins::Bin>& bins() const { return bins_; }
  [[nodiscard]] double noise() const { return noise_; }  // of one sample of weight 1
  [[nodiscard]] double reach_px() const { return options_.reach_px; }
  [[nodiscard]] const ProfileFitOptions& options() const { return options_; }

  // The row of the design for a sample at d: dense part (levels, optics, shading), then spline.
  struct Row {
    double mean = 0;  // E(d)
    std::size_t n_dense = 0;
    std::array<double, 4 + kOpticsParameters> dense{};
    ResidualSpline::Active spline;
  };
  [[nodiscard]] Row row(double d_px, const ProfileMember& member) const;
  // Prediction of the best member: level 0 to 1 with the residual, without levels and shading.
  [[nodiscard]] double value(double d_px) const;
  [[nodiscard]] double slope(double d_px) const;
  // Prediction of the best member with everything.
  [[nodiscard]] double fitted(double d_px) const;
  // Corrections of the best member: to the dark and the bright level, and across.
  struct Levels {
    double dark = 0, bright = 0, dark_across = 0, bright_across = 0;
  };
  [[nodiscard]] Levels levels() const;

  // Indices into beta.
  [[nodiscard]] static std::size_t first_optics() { return 2; }
  [[nodiscard]] std::size_t first_shading() const { return 2 + parameters_.size(); }
  [[nodiscard]] std::size_t first_spline(const ProfileMember& member) const {
    return first_shading() + (member.shading ? 2 : 0);
  }
  // Prior precision of beta times x, for one member.
  void prior_times(const ProfileMember& member, std::span<const double> x,
                   std::span<double> out) const;
  // Share of the posterior in which a residual is needed.
  [[nodiscard]] double residual_share() const;

 private:
  struct System;  // normal equations at one set of optics

  // Least squares for the optics alone; the penalised sum of squares over the variance.
  double fit_optics(EdgeOptics& optics, std::span<const int> parameters, int most_rounds) const;
  [[nodiscard]] System system(const EdgeOptics& optics, std::span<const int> parameters) const;
  [[nodiscard]] std::vector<ProfileMember> judge(const System& system) const;
  void solve(const EdgeOptics& optics, const std::vector<int>& parameters);
  [[nodiscard]] double prior_mean(int parameter, OpticsPrior prior = OpticsPrior::kFree) const;
  [[nodiscard]] double prior_sd(int parameter, OpticsPrior prior = OpticsPrior::kFree) const;
  void settle_noise(const System& system);
  // Scatter within the bins about a profile of this slope.
  template <typename Slope>
  void measure_scatter(Slope slope);

  ProfileFitOptions options_;
  std::vector<ProfileBins::Bin> bins_;
  double n_ = 0, scatter_ = 0, scatter_freedom_ = 0;
  double noise_ = 1e-3;
  EdgeOptics optics_;
  std::vector<int> parameters_;
  std::shared_ptr<const MeanProfile> mean_;
  std::shared_ptr<const ResidualSpline> spline_;
  std::shared_ptr<const Symmetric> roughness_;
  double roughness_log_det_ = 0;
  std::vector<ProfileMember> members_;
};

}  // namespace reseau
