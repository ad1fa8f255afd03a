#include "drivers/sim/simulate.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/sim/focus_map.h"
#include "drivers/sim/sensor.h"

namespace reseau::sim {

FilmTruth::FilmTruth(const FilmSpec& spec, const ScanWindow& window, const ScanGeometry& geometry)
    : spec_(spec), window_(window), geometry_(geometry), strip_(std::make_unique<FilmStrip>(spec)) {
  if (spec.kind == FilmKind::kDufay) dufay_ = std::make_unique<DufayFilm>(spec);
}

ScanGeometry geometry_of(const SimSpec& spec, const SensorSpec& sensor) {
  return {spec.optics, spec.stage, sensor, spec.film.frame.width_px, spec.film.seed};
}

PsfGrid psf_at(const SimSpec& spec, const ScanWindow& window, int channel, double x, double y,
               int samples_per_px, int radius_px) {
  const FocusMap focus(make_film(spec.film), spec.optics, geometry_of(spec, spec.sensor));
  const double defocus = focus.defocus_um(channel, window.optical_x(x), window.optical_y(y));
  return sample_psf(spec.optics, channel, defocus, samples_per_px, radius_px);
}

ScanPlace FilmTruth::optical(double x, double y) const {
  return geometry_.place(window_.optical_x(x), window_.optical_y(y));
}

ScreenPoint FilmTruth::screen_from_scan(double x, double y) const {
  CHECK(dufay_ != nullptr);
  const ScanPlace at = optical(x, y);
  return dufay_->screen_from_scan(at.x, at.y);
}

ScreenPoint FilmTruth::screen_from_scan(int channel, double x, double y) const {
  CHECK(dufay_ != nullptr);
  const ScanPlace at = geometry_.place(channel, window_.optical_x(x), window_.optical_y(y));
  return dufay_->screen_from_scan(at.x, at.y);
}

std::array<double, 3> FilmTruth::process_rgb(double x, double y) const {
  if (spec_.kind == FilmKind::kEmpty) return {1, 1, 1};
  const ScanPlace at = optical(x, y);
  return strip_->silver_at(at.x, at.y);
}

void FilmTruth::process_row(double y, const RgbRow& out) const {
  const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
  if (spec_.kind == FilmKind::kEmpty) {
    for (const std::span<float> band : bands) std::ranges::fill(band, 1.0F);
    return;
  }
  const ScanPlace first = optical(0, y), last = optical(static_cast<double>(out.r.size()) - 1, y);
  const double length = static_cast<double>(out.r.size()) - 1;
  if (window_.pitch == 1 && std::abs(last.x - first.x - length) < 1e-9) {
    strip_->silver_row(first.y, first.x, out);
    return;
  }
  for (std::size_t i = 0; i < out.r.size(); ++i) {
    const std::array<double, 3> rgb = process_rgb(static_cast<double>(i), y);
    for (std::size_t k = 0; k < 3; ++k) bands[k][i] = static_cast<float>(rgb[k]);
  }
}

void FilmTruth::screen_row(double y, std::span<ScreenPoint> out) const {
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = screen_from_scan(static_cast<double>(i), y);
  }
}

std::vector<Patch> FilmTruth::patches() const {
  std::vector<Patch> result;
  if (spec_.kind == FilmKind::kEmpty) return result;
  const double p = window_.pitch, step = window_.step(), shift = (window_.pitch - 1) / 2.0;
  const ScanPlace error = geometry_.largest();
  for (Patch patch : strip_->patches()) {
    // Displacements cost every side the largest of them.
    patch.x0 += error.x;
    patch.x1 -= error.x;
    patch.y0 += error.y;
    patch.y1 -= error.y;
    patch.x0 = std::max(0.0, (patch.x0 - window_.x_px - shift) / p);
    patch.x1 = std::min(window_.width_px - 1.0, (patch.x1 - window_.x_px - shift) / p);
    patch.y0 = std::max(0.0, (patch.y0 - window_.y_px - shift) / step);
    patch.y1 = std::min(window_.n_lines - 1.0, (patch.y1 - window_.y_px - shift) / step);
    if (patch.x0 < patch.x1 && patch.y0 < patch.y1) result.push_back(patch);
  }
  return result;
}

ScreenGradient FilmTruth::mean_gradient() const {
  CHECK(dufay_ != nullptr);
  ScreenGradient g = dufay_->screen().gradient();
  const double sign = spec_.mirrored ? -window_.pitch : window_.pitch;
  g.u_x *= sign;
  g.v_x *= sign;
  g.u_y *= window_.step();
  g.v_y *= window_.step();
  return g;
}

std::array<double, 3> FilmTruth::area_fractions() const {
  CHECK(dufay_ != nullptr);
  return dufay_->screen().area_fractions();
}

SimulatedScan simulate_window(const SimSpec& spec, const ScanWindow& window) {
  if (window.width_px < 1 || window.n_lines < 1 || window.pitch < 1) {
    throw InputError("A simulated scan needs at least one pixel, one line and a pitch of 1.");
  }
  const ScanGeometry geometry = geometry_of(spec, spec.sensor);
  const ScanRenderer renderer(make_film(spec.film), spec.optics, window, geometry);
  LineFormat format;
  format.width_px = window.width_px;
  format.n_lines = window.n_lines;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kInfrared};
  format.significant_bits = spec.sensor.adc_bits;
  format.x_dpi = 25400.0 / spec.film.frame.pixel_um / window.pitch;
  format.y_dpi = 25400.0 / spec.film.frame.pixel_um / window.step();

  SensorPass pass;
  pass.level.fill(spec.sensor.clear_level);
  pass.seed = spec.film.seed;
  pass.field_px = spec.film.frame.width_px;
  const std::size_t per_line = format.samples_per_line();
  std::vector<std::uint16_t> samples(per_line * static_cast<std::size_t>(window.n_lines));
  constexpr int kBandLines = 256;
  std::vector<float> band(per_line * kBandLines);
  const int readings = std::max(1, spec.sensor.readings);
  std::vector<std::uint16_t> reading;
  std::vector<std::uint32_t> sum;
  for (int first = 0; first < window.n_lines; first += kBandLines) {
    const int n = std::min(kBandLines, window.n_lines - first);
    const std::size_t size = per_line * static_cast<std::size_t>(n);
    renderer.transmittance(first, n, std::span(band).first(size));
    const auto light = std::span(band).first(size);
    const auto to = std::span(samples).subspan(per_line * static_cast<std::size_t>(first), size);
    digitise(light, window, first, spec.sensor, pass, to);
    if (readings == 1) continue;
    sum.assign(to.begin(), to.end());
    reading.resize(size);
    for (pass.reading = 1; pass.reading < readings; ++pass.reading) {
      digitise(light, window, first, spec.sensor, pass, reading);
      for (std::size_t i = 0; i < size; ++i) sum[i] += reading[i];
    }
    pass.reading = 0;
    const auto r = static_cast<std::uint32_t>(readings);
    for (std::size_t i = 0; i < size; ++i) {
      to[i] = static_cast<std::uint16_t>((sum[i] + r / 2) / r);
    }
  }
  const int full = (1 << spec.sensor.adc_bits) - 1;
  if (full != 65535) {
    for (std::uint16_t& v : samples) {
      v = static_cast<std::uint16_t>((static_cast<int>(v) * 65535LL + full / 2) / full);
    }
  }
  return {std::move(format), std::move(samples), FilmTruth(spec.film, window, geometry)};
}

SimulatedScan simulate_frame(const SimSpec& spec) {
  return simulate_window(spec, {.x_px = 0,
                                .y_px = 0,
                                .width_px = spec.film.frame.width_px,
                                .n_lines = spec.film.frame.height_px,
                                .pitch = 1});
}

}  // namespace reseau::sim
