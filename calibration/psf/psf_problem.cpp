#include "calibration/psf/psf_problem.h"

#include <cmath>

#include <ceres/cost_function.h>
#include <ceres/problem.h>

#include "calibration/edge/mean_profile.h"

namespace reseau::psf {
namespace {

class EdgeCost final : public ceres::CostFunction {
 public:
  EdgeCost(const PsfEdge& edge, double focus, double waves_per_path)
      : edge_(edge), focus_(focus), waves_per_path_(waves_per_path) {
    for (int i = 0; i < kBlocks; ++i) mutable_parameter_block_sizes()->push_back(1);
    set_num_residuals(static_cast<int>(edge.bins.size()));
  }

  bool Evaluate(double const* const* p, double* residuals, double** jacobians) const override {
    EdgeOptics optics;
    optics.aperture2_px2 = p[kBlockAperture][0];
    optics.aspect2 = p[kBlockAspect][0];
    optics.halo = p[kBlockHalo][0];
    optics.halo_sigma_px = p[kBlockHaloSigma][0];
    optics.diffraction_px = p[kBlockDiffraction][0];
    optics.sigma2_px2 = p[kBlockSigma][0];
    const double waves = waves_per_path_ * p[kBlockPath][0], apart = focus_ - p[kBlockBest][0];
    optics.w20_waves = waves * apart;
    // Steps that leave what the profile can be computed for are refused, and tried shorter.
    if (!(std::abs(optics.w20_waves) < 6) || !(std::abs(optics.diffraction_px) < 60) ||
        !(std::abs(optics.halo) < 0.9) || !(optics.halo_sigma_px > 0.7) ||
        !(optics.halo_sigma_px < 60) || !(std::abs(optics.sigma2_px2) < 400) ||
        !(std::abs(optics.aperture2_px2) < 400) || !(std::abs(optics.aspect2) < 9)) {
      return false;
    }
    std::vector<int> wanted;
    std::array<int, kOpticsParameters> column{};
    const auto want = [&](int parameter, bool needed) {
      if (!needed) return;
      column[static_cast<std::size_t>(parameter)] = static_cast<int>(wanted.size());
      wanted.push_back(parameter);
    };
    const auto free = [&](int block) {
      return jacobians != nullptr && jacobians[block] != nullptr;
    };
    want(kDiffraction, free(kBlockDiffraction));
    want(kSigma2, free(kBlockSigma));
    want(kAperture2, free(kBlockAperture));
    want(kW20, free(kBlockPath) || free(kBlockBest));
    want(kHalo, free(kBlockHalo));
    want(kHaloSigma, free(kBlockHaloSigma));
    want(kAspect2, free(kBlockAspect));
    // Room for the offset to move the profile.
    const double offset = p[kBlockOffset][0];
    if (!(std::abs(offset) < 2)) return false;
    const MeanProfile profile(optics, edge_.normal, std::min(100.0, edge_.reach_px + 2), wanted);
    const double dark = p[kBlockDark][0], bright = p[kBlockBright][0];
    for (std::size_t i = 0; i < edge_.bins.size(); ++i) {
      const ProfileBins::Bin& bin = edge_.bins[i];
      const double scale = std::sqrt(bin.weight) / edge_.noise;
      const MeanProfile::At at = profile.at(bin.distance - offset);
      residuals[i] = scale * (dark + (bright - dark) * at.value - bin.value);
      if (jacobians == nullptr) continue;
      const double height = scale * (bright - dark);
      const auto by = [&](int parameter) {
        return height * at.by_parameter[static_cast<std::size_t>(
                            column[static_cast<std::size_t>(parameter)])];
      };
      const auto put = [&](int block, double value) { jacobians[block][i] = value; };
      if (free(kBlockDiffraction)) put(kBlockDiffraction, by(kDiffraction));
      if (free(kBlockSigma)) put(kBlockSigma, by(kSigma2));
      if (free(kBlockAperture)) put(kBlockAperture, by(kAperture2));
      if (free(kBlockAspect)) put(kBlockAspect, by(kAspect2));
      if (free(kBlockPath)) put(kBlockPath, by(kW20) * apart * waves_per_path_);
      if (free(kBlockBest)) put(kBlockBest, -by(kW20) * waves);
      if (free(kBlockHalo)) put(kBlockHalo, by(kHalo));
      if (free(kBlockHaloSigma)) put(kBlockHaloSigma, by(kHaloSigma));
      if (free(kBlockOffset)) put(kBlockOffset, -height * at.slope);
      if (free(kBlockDark)) put(kBlockDark, scale * (1 - at.value));
      if (free(kBlockBright)) put(kBlockBright, scale * at.value);
    }
    return true;
  }

 private:
  const PsfEdge& edge_;
  double focus_, waves_per_path_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> edge_cost(const PsfEdge& edge, double focus,
                                               double waves_per_path) {
  return std::make_unique<EdgeCost>(edge, focus, waves_per_path);
}

Setup::Setup() : problem(std::make_unique<ceres::Problem>()) {}
Setup::~Setup() = default;

const char* channel_name(int channel) {
  constexpr std::array<const char*, kChannels> kNames{"red", "green", "blue", "infrared"};
  return kNames[static_cast<std::size_t>(channel)];
}

double Unknowns::waves_per_path(int channel) const {
  return in_waves ? 1 : 1 / kPsfWavelengths_um[static_cast<std::size_t>(channel)];
}

EdgeOptics Unknowns::optics(int channel, double focus) const {
  const Channel& c = channels[static_cast<std::size_t>(channel)];
  EdgeOptics out;
  out.diffraction_px = c.diffraction;
  out.sigma2_px2 = c.sigma2;
  out.aperture2_px2 = aperture2;
  out.aspect2 = aspect2;
  out.halo = halo;
  out.halo_sigma_px = halo_sigma;
  out.w20_waves = waves_per_path(channel) * path_per_step * (focus - c.best);
  return out;
}

std::unique_ptr<Setup> set_up(std::span<const PsfEdge> edges, const Freedom& freedom, Unknowns& u) {
  u.edges.resize(edges.size());
  u.in_waves = !freedom.path_per_step;
  auto setup = std::make_unique<Setup>();
  ceres::Problem& problem = *setup->problem;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const PsfEdge& edge = edges[e];
    Unknowns::Channel& c = u.channels[static_cast<std::size_t>(edge.channel)];
    c.used = true;
    Unknowns::Edge& own = u.edges[e];
    const double focus = freedom.path_per_step ? *edge.focus : 0;
    problem.AddResidualBlock(new EdgeCost(edge, focus, u.waves_per_path(edge.channel)), nullptr,
                             &u.aperture2, &u.aspect2, &u.halo, &u.halo_sigma, &u.path_per_step,
                             &c.diffraction, &c.sigma2, &c.best, &own.offset, &own.dark,
                             &own.bright);
  }
  const auto share = [&](double& value, std::string name, bool is_free) {
    if (is_free) {
      setup->shared.push_back({&value, std::move(name)});
    } else {
      problem.SetParameterBlockConstant(&value);
    }
  };
  share(u.aperture2, "aperture_squared_px2", true);
  share(u.aspect2, "aspect_squared", freedom.aspect);
  share(u.halo, "halo_share", freedom.halo);
  share(u.halo_sigma, "halo_sigma_px", freedom.halo);
  share(u.path_per_step, "defocus_path_um_per_step", freedom.path_per_step);
  for (int i = 0; i < kChannels; ++i) {
    Unknowns::Channel& c = u.channels[static_cast<std::size_t>(i)];
    if (!c.used) continue;
    const std::string name = channel_name(i);
    share(c.diffraction, name + ".diffraction_px", true);
    share(c.sigma2, name + ".gaussian_variance_px2", true);
    share(c.best, name + (freedom.path_per_step ? ".best_focus" : ".defocus_w20_waves"), true);
  }
  return setup;
}

}  // namespace reseau::psf
