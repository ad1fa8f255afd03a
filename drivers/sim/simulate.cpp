#include "drivers/sim/simulate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "core/base/check.h"
#include "drivers/sim/film/screen_of.h"
#include "drivers/sim/focus_map.h"
#include "drivers/sim/window_render.h"

namespace reseau::sim {

FilmTruth::FilmTruth(const FilmSpec& spec, const ScanWindow& window, const ScanGeometry& geometry)
    : spec_(spec),
      window_(window),
      geometry_(geometry),
      strip_(std::make_shared<FilmStrip>(spec)),
      light_(strip_),
      screen_(std::make_shared<PlacedScreen>(spec)) {
  if (scene_differs()) {
    FilmSpec light = spec;
    light.emulsion.ideal_taking = true;
    light.emulsion.hd.gamma = 0;
    light_ = std::make_shared<FilmStrip>(light);
  }
  if (spec.kind == FilmKind::kEmpty) return;
  FilmSpec whole = spec;
  whole.emulsion.grain = 0;
  whole.dyes.infrared_leak = 0;
  whole.damage.faded_areas = whole.damage.stains = 0;
  whole_film_ = std::make_shared<ScreenFilm>(whole);
}

std::string_view FilmTruth::screen_name() const {
  return has_screen() ? describe_screen(spec_.screen).name : std::string_view();
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
  CHECK(has_screen());
  const ScanPlace at = optical(x, y);
  return screen_->screen_from_scan(at.x, at.y);
}

ScreenPoint FilmTruth::screen_from_scan(int channel, double x, double y) const {
  CHECK(has_screen());
  const ScanPlace at = geometry_.place(channel, window_.optical_x(x), window_.optical_y(y));
  return screen_->screen_from_scan(at.x, at.y);
}

std::array<double, 3> FilmTruth::process_rgb(double x, double y) const {
  if (spec_.kind == FilmKind::kEmpty) return {1, 1, 1};
  const ScanPlace at = optical(x, y);
  return strip_->silver_at(at.x, at.y);
}

bool FilmTruth::scene_differs() const {
  return spec_.kind != FilmKind::kEmpty &&
         (spec_.emulsion.hd.gamma != 0 || !spec_.emulsion.ideal_taking);
}

bool FilmTruth::has_harm() const {
  return spec_.kind != FilmKind::kEmpty && whole_film_->damage().has_local();
}

void FilmTruth::process_row(double y, const RgbRow& out) const { strip_row(*strip_, y, out); }

void FilmTruth::scene_row(double y, const RgbRow& out) const { strip_row(*light_, y, out); }

void FilmTruth::strip_row(const FilmStrip& strip, double y, const RgbRow& out) const {
  const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};
  if (spec_.kind == FilmKind::kEmpty) {
    for (const std::span<float> band : bands) std::ranges::fill(band, 1.0F);
    return;
  }
  const ScanPlace first = optical(0, y), last = optical(static_cast<double>(out.r.size()) - 1, y);
  const double length = static_cast<double>(out.r.size()) - 1;
  if (window_.pitch == 1 && std::abs(last.x - first.x - length) < 1e-9) {
    strip.silver_row(first.y, first.x, out);
    return;
  }
  for (std::size_t i = 0; i < out.r.size(); ++i) {
    const ScanPlace at = optical(static_cast<double>(i), y);
    const std::array<double, 3> rgb = strip.silver_at(at.x, at.y);
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

std::vector<Edge> FilmTruth::edges() const {
  std::vector<Edge> result;
  if (spec_.kind == FilmKind::kEmpty) return result;
  const double p = window_.pitch, step = window_.step(), shift = (window_.pitch - 1) / 2.0;
  const ScanPlace error = geometry_.largest();
  for (Edge edge : strip_->edges()) {
    edge.x0 += error.x;
    edge.x1 -= error.x;
    edge.y0 += error.y;
    edge.y1 -= error.y;
    for (double* x : {&edge.x, &edge.x0, &edge.x1}) *x = (*x - window_.x_px - shift) / p;
    for (double* y : {&edge.y, &edge.y0, &edge.y1}) *y = (*y - window_.y_px - shift) / step;
    // Lines may be further apart than pixels.
    const double angle = edge.angle_deg * std::numbers::pi / 180;
    edge.angle_deg =
        std::atan2(std::sin(angle) / p, std::cos(angle) / step) * 180 / std::numbers::pi;
    edge.x0 = std::max(edge.x0, 0.0);
    edge.y0 = std::max(edge.y0, 0.0);
    edge.x1 = std::min(edge.x1, window_.width_px - 1.0);
    edge.y1 = std::min(edge.y1, window_.n_lines - 1.0);
    if (edge.x0 < edge.x && edge.x < edge.x1 && edge.y0 < edge.y && edge.y < edge.y1) {
      result.push_back(edge);
    }
  }
  return result;
}

// Pixels one optical pixel apart, the first centred at x.
void FilmTruth::silver_pixels(double y, double x, std::span<float> out) const {
  constexpr int kPerPx = 4;
  const auto left = static_cast<int>(std::floor((x - 1) / kBlockPx)) * kBlockPx;
  const auto right = static_cast<int>(std::floor(x)) + static_cast<int>(out.size()) + 2;
  const int n_px = (right - left + kBlockPx - 1) / kBlockPx * kBlockPx;
  thread_local CellRow cells;
  std::vector<double> integral(static_cast<std::size_t>(n_px * kPerPx) + 1, 0.0);
  for (int row = 0; row < kPerPx; ++row) {
    whole_film_->silver_cells(y + cell_offset_px(row, kPerPx), left, n_px, kPerPx, cells);
    double sum = 0;
    for (int k = 0; k < n_px * kPerPx; ++k) {
      sum += static_cast<double>(cells.phase(kInfrared, k % kPerPx)[k / kPerPx]);
      integral[static_cast<std::size_t>(k) + 1] += sum;
    }
  }
  const auto until = [&](double at_px) {
    const double t = (at_px - left + 0.5) * kPerPx;
    const auto k = static_cast<std::size_t>(t);
    return integral[k] + (t - static_cast<double>(k)) * (integral[k + 1] - integral[k]);
  };
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double at = x + static_cast<double>(i);
    out[i] = static_cast<float>((until(at + 0.5) - until(at - 0.5)) / (kPerPx * kPerPx));
  }
}

void FilmTruth::silver_row(double y, std::span<float> out) const {
  if (spec_.kind == FilmKind::kEmpty) {
    std::ranges::fill(out, 1.0F);
    return;
  }
  // In runs over which the scanner looks along a row of the film.
  constexpr double kSamePx = 1e-6;
  std::size_t begin = 0;
  while (begin < out.size()) {
    const ScanPlace first = optical(static_cast<double>(begin), y);
    std::size_t end = begin + 1;
    for (; end < out.size(); ++end) {
      const ScanPlace p = optical(static_cast<double>(end), y);
      const double expected = first.x + static_cast<double>(end - begin);
      if (std::abs(p.x - expected) > kSamePx || std::abs(p.y - first.y) > kSamePx) break;
    }
    silver_pixels(first.y, first.x, out.subspan(begin, end - begin));
    begin = end;
  }
}

void FilmTruth::harm_row(double y, std::span<float> out) const {
  std::ranges::fill(out, 0.0F);
  if (!has_harm()) return;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const ScanPlace at = optical(static_cast<double>(i), y);
    whole_film_->harm_row(at.y, at.x, out.subspan(i, 1));
  }
}

ScreenGradient FilmTruth::mean_gradient() const {
  CHECK(has_screen());
  ScreenGradient g = screen_->scan_gradient();
  g.u_x *= window_.pitch;
  g.v_x *= window_.pitch;
  g.u_y *= window_.step();
  g.v_y *= window_.step();
  return g;
}

std::array<double, 3> FilmTruth::area_fractions() const {
  CHECK(has_screen());
  return describe_screen(spec_.screen).areas;
}

std::array<ScreenPoint, 3> FilmTruth::element_middles() const {
  CHECK(has_screen());
  const std::array<Vec2, 3> middles = describe_screen(spec_.screen).middles;
  std::array<ScreenPoint, 3> points;
  for (std::size_t k = 0; k < 3; ++k) points[k] = {middles[k].x, middles[k].y};
  return points;
}

SimulatedScan simulate_window(const SimSpec& spec, const ScanWindow& window) {
  const WindowRender render(spec, window);
  const std::size_t per_line = render.format().samples_per_line();
  std::vector<std::uint16_t> samples(per_line * static_cast<std::size_t>(window.n_lines));
  const int band = render.band_lines();
  for (int first = 0; first < window.n_lines; first += band) {
    const int n = std::min(band, window.n_lines - first);
    render.lines(first, n,
                 std::span(samples).subspan(per_line * static_cast<std::size_t>(first),
                                            per_line * static_cast<std::size_t>(n)));
  }
  return {render.format(), std::move(samples), truth_of(spec, window)};
}

FilmTruth truth_of(const SimSpec& spec, const ScanWindow& window) {
  return {spec.film, window, geometry_of(spec, spec.sensor)};
}

ScanWindow frame_window(const SimSpec& spec) {
  return {.x_px = 0,
          .y_px = 0,
          .width_px = spec.film.frame.width_px,
          .n_lines = spec.film.frame.height_px,
          .pitch = 1};
}

SimulatedScan simulate_frame(const SimSpec& spec) {
  return simulate_window(spec, frame_window(spec));
}

}  // namespace reseau::sim
