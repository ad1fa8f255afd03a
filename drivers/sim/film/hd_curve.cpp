#include "drivers/sim/film/hd_curve.h"

#include <cmath>

namespace reseau::sim {

HdCurve::HdCurve(const HdSpec& spec) : spec_(spec) {
  if (!is_identity()) {
    table_ = LogTable([this](double exposure) { return transmittance(exposure); });
  }
}

double HdCurve::transmittance(double exposure) const {
  if (is_identity()) return exposure;
  const auto soft = [this](double x) {
    const double t = x / spec_.toe;
    return spec_.toe * (t > 0 ? t + std::log1p(std::exp(-t)) : std::log1p(std::exp(t)));
  };
  if (exposure <= 0) return std::pow(10.0, -spec_.d_max);
  const double x = spec_.gamma * (spec_.log_speed - std::log10(exposure));
  return std::pow(10.0, -(spec_.d_min + soft(x) - soft(x - (spec_.d_max - spec_.d_min))));
}

void HdCurve::apply(std::span<float> exposure) const {
  if (is_identity()) return;
  for (float& value : exposure) value = table_(value);
}

}  // namespace reseau::sim
