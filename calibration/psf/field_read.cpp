#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/edge/optics.h"
#include "calibration/profile/records.h"
#include "calibration/psf/psf_field.h"
#include "calibration/psf/psf_fit.h"
#include "calibration/psf/psf_problem.h"

namespace reseau {

EdgeOptics field_optics(const PsfFieldRecord& record, int channel, double x, double y) {
  const std::string name = psf::channel_name(channel);
  const auto value = [&](const std::string& of, double otherwise) {
    const auto at = record.at(of, x, y);
    return at ? at->value : otherwise;
  };
  EdgeOptics out;
  out.aperture2_px2 = value("aperture_squared_px2", 1);
  out.aspect2 = value("aspect_squared", 1);
  out.halo = value("halo_share", 0);
  out.halo_sigma_px = value("halo_sigma_px", 6);
  out.diffraction_px = value(name + ".diffraction_px", 0.5);
  out.sigma2_px2 = value(name + ".gaussian_variance_px2", 0);
  out.w20_waves = record.has_focus
                      ? value("defocus_path_um_per_step", 0) *
                            (record.focus - value(name + ".best_focus", record.focus)) /
                            kPsfWavelengths_um[static_cast<std::size_t>(channel)]
                      : value(name + ".defocus_w20_waves", 0);
  return out;
}

std::optional<Measured> field_mtf50(const PsfFieldRecord& record, int channel,
                                    const NormalCosines& normal, double x, double y) {
  const std::string channel_name = psf::channel_name(channel);
  if (record.find(channel_name + ".diffraction_px") == nullptr) return std::nullopt;
  const EdgeOptics here = field_optics(record, channel, x, y);
  constexpr double kMost = 1.5, kStep = 0.01;
  double low = 0;
  while (low < kMost && transfer(here, normal, low + kStep) > 0.5) low += kStep;
  if (!(low < kMost)) return std::nullopt;
  double high = low + kStep;
  for (int i = 0; i < 50; ++i) {
    const double f = 0.5 * (low + high);
    (transfer(here, normal, f) > 0.5 ? low : high) = f;
  }
  // dM at that frequency by each coefficient, over the slope of M there.
  constexpr std::array<int, 7> kAll{kAperture2,   kAspect2, kHalo, kHaloSigma,
                                    kDiffraction, kSigma2,  kW20};
  std::array<double, 8> by{};
  transfer(here, normal, low, kAll, by);
  const double slope =
      (transfer(here, normal, low + 1e-4) - transfer(here, normal, low - 1e-4)) / 2e-4;
  if (!(slope < 0)) return std::nullopt;
  std::vector<double> gradient(record.coefficients.size());
  const auto add = [&](const std::string& name, double factor) {
    const std::vector<double> w = record.weights(name, x, y);
    for (std::size_t i = 0; i < w.size(); ++i) gradient[i] += factor * w[i];
  };
  add("aperture_squared_px2", by[1]);
  add("aspect_squared", by[2]);
  add("halo_share", by[3]);
  add("halo_sigma_px", by[4]);
  add(channel_name + ".diffraction_px", by[5]);
  add(channel_name + ".gaussian_variance_px2", by[6]);
  add(channel_name + ".defocus_w20_waves", by[7]);
  if (record.has_focus) {
    const auto path = record.at("defocus_path_um_per_step", x, y);
    const auto best = record.at(channel_name + ".best_focus", x, y);
    const double waves = 1 / kPsfWavelengths_um[static_cast<std::size_t>(channel)];
    if (path && best) {
      add("defocus_path_um_per_step", by[7] * waves * (record.focus - best->value));
      add(channel_name + ".best_focus", -by[7] * waves * path->value);
    }
  }
  const auto n = static_cast<Eigen::Index>(gradient.size());
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> covariance(record.covariance.data(), n, n);
  const Eigen::Map<const Eigen::VectorXd> d(gradient.data(), n);
  const double variance = d.dot(covariance * d);
  return Measured{low, std::sqrt(std::max(0.0, variance)) / -slope};
}

}  // namespace reseau
