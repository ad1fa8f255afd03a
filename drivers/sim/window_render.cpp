#include "drivers/sim/window_render.h"

#include <algorithm>
#include <vector>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/sim/film/make_film.h"
#include "drivers/sim/sensor.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim {
namespace {

const ScanWindow& not_empty(const ScanWindow& window) {
  if (window.width_px < 1 || window.n_lines < 1 || window.pitch < 1) {
    throw InputError("A simulated scan needs at least one pixel, one line and a pitch of 1.");
  }
  return window;
}

}  // namespace

WindowRender::WindowRender(const SimSpec& spec, const ScanWindow& window)
    : spec_(spec),
      window_(not_empty(window)),
      renderer_(make_film(spec.film), spec.optics, window, geometry_of(spec, spec.sensor)) {
  format_.width_px = window.width_px;
  format_.n_lines = window.n_lines;
  format_.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  format_.significant_bits = spec.sensor.adc_bits;
  format_.x_dpi = 25400.0 / spec.film.frame.pixel_um / window.pitch;
  format_.y_dpi = 25400.0 / spec.film.frame.pixel_um / window.step();
}

int WindowRender::band_lines() const {
  constexpr int kFewest = 256, kMost = 512, kPixels = 1 << 20;
  return std::clamp(kPixels / window_.width_px / kFewest * kFewest, kFewest, kMost);
}

void WindowRender::lines(int first_line, int n_lines, std::span<std::uint16_t> out) const {
  const std::size_t size = format_.samples_per_line() * static_cast<std::size_t>(n_lines);
  CHECK(out.size() == size);
  SensorPass pass;
  pass.level.fill(spec_.sensor.clear_level);
  pass.seed = spec_.film.seed;
  pass.field_px = spec_.film.frame.width_px;
  std::vector<float> light(size);
  renderer_.transmittance(first_line, n_lines, light);
  digitise(light, window_, first_line, spec_.sensor, pass, out);
  const int readings = std::max(1, spec_.sensor.readings);
  if (readings > 1) {
    std::vector<std::uint32_t> sum(out.begin(), out.end());
    std::vector<std::uint16_t> reading(size);
    for (pass.reading = 1; pass.reading < readings; ++pass.reading) {
      digitise(light, window_, first_line, spec_.sensor, pass, reading);
      for (std::size_t i = 0; i < size; ++i) sum[i] += reading[i];
    }
    const auto r = static_cast<std::uint32_t>(readings);
    for (std::size_t i = 0; i < size; ++i) {
      out[i] = static_cast<std::uint16_t>((sum[i] + r / 2) / r);
    }
  }
  const int full = (1 << spec_.sensor.adc_bits) - 1;
  if (full == 65535) return;
  for (std::uint16_t& v : out) {
    v = static_cast<std::uint16_t>((static_cast<int>(v) * 65535LL + full / 2) / full);
  }
}

}  // namespace reseau::sim
