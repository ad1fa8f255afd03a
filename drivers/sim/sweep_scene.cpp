#include <algorithm>
#include <cmath>
#include <cstddef>

#include "drivers/sim/film/dye_spectra.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {
namespace {

constexpr double kDecades = 1.5;
constexpr double kBrightest = 0.95;

class SweepScene final : public Scene {
 public:
  SweepScene(double width_px, double height_px) : w_(width_px), h_(height_px) {
    for (std::size_t k = 0; k < 3; ++k) {
      filters_[k] = dye_spectrum(DyeSource::kHarrisonHorner, static_cast<int>(k), 0);
      for (const double v : filters_[k]) peak_ = std::max(peak_, v);
    }
  }

  void row(double y, double x0, const RgbRow& out) const override {
    const double level =
        kBrightest / peak_ * std::pow(10.0, -kDecades * std::clamp(y / h_, 0.0, 1.0));
    const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
    for (std::size_t i = 0; i < out.r.size(); ++i) {
      const double at = std::clamp((x0 + static_cast<double>(i)) / w_, 0.0, 1.0) *
                        static_cast<double>(kSpectrumSize - 1);
      const auto left = std::min(static_cast<std::size_t>(at), kSpectrumSize - 2);
      const double f = at - static_cast<double>(left);
      for (std::size_t k = 0; k < 3; ++k) {
        const double t = filters_[k][left] + f * (filters_[k][left + 1] - filters_[k][left]);
        bands[k][i] = static_cast<float>(level * t);
      }
    }
  }
  [[nodiscard]] bool is_filtered() const override { return true; }

 private:
  double w_, h_;
  std::array<Spectrum, 3> filters_{};
  double peak_ = 0;
};

}  // namespace

std::unique_ptr<Scene> make_sweep_scene(double width_px, double height_px) {
  return std::make_unique<SweepScene>(width_px, height_px);
}

}  // namespace reseau::sim
