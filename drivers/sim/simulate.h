// The simulated film without the simulated wire: lines and the truth about them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/line/line_format.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/film/make_film.h"
#include "drivers/sim/film/screen_film.h"
#include "drivers/sim/optical_transfer.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/sim_spec.h"
#include "drivers/sim/window_render.h"

namespace reseau::sim {

// Throws InputError where the specification names a model that does not exist, listing those that
// do.
void check_model(const SimSpec& spec);

// Everything that is known about a scan pixel of a window. Coordinates are delivered pixels of the
// window, (0, 0) the centre of the first. Immutable, thread-safe.
class FilmTruth {
 public:
  // Under a perfect scanner, or under one whose geometry is known.
  FilmTruth(const FilmSpec& spec, const ScanWindow& window, const ScanGeometry& geometry = {});

  // False for film=none and film=empty: then there is no réseau.
  [[nodiscard]] bool has_screen() const { return spec_.kind == FilmKind::kDufay; }
  // "dufaycolor", "paget" …; empty without a réseau.
  [[nodiscard]] std::string_view screen_name() const;
  // (u, v) in periods, conventions of ScreenPoint. has_screen() must hold.
  // Every displacement of the scanner is in it but lateral colour, which needs the channel (0 to 3:
  // R G B IR).
  [[nodiscard]] ScreenPoint screen_from_scan(double x, double y) const;
  [[nodiscard]] ScreenPoint screen_from_scan(int channel, double x, double y) const;
  // Process RGB: the linear silver transmittance behind a red, green and blue element if it lay
  // there; neither blurred nor sampled by the réseau. 1 = clear.
  [[nodiscard]] std::array<double, 3> process_rgb(double x, double y) const;
  // The same for a whole row of the window: sample i is at (i, y). Much faster than point by point.
  void process_row(double y, const RgbRow& out) const;
  // Light of the scene, before the taking filters and the emulsion; behind them where the scene is
  // no mixture of three lights (scene=sweep). Border and rebate count as exposures.
  void scene_row(double y, const RgbRow& out) const;
  // Whether that is something else than process RGB.
  [[nodiscard]] bool scene_differs() const;
  // Whether there are places with dust, hairs, scratches or bubbles.
  [[nodiscard]] bool has_harm() const;
  void screen_row(double y, std::span<ScreenPoint> out) const;
  // Silver transmittance of a pixel as the film has it: behind the elements that lie there, after
  // the spread in the emulsion, mean over the pixel; without grain, harm, dyes, blur. What a
  // perfect infrared channel would show.
  void silver_row(double y, std::span<float> out) const;
  // How far dust, hairs, scratches and bubbles hide the film at the centre of a pixel, 0..1.
  void harm_row(double y, std::span<float> out) const;
  // Flat areas, clipped to the window; empty for scenes that have none.
  [[nodiscard]] std::vector<Patch> patches() const;
  // Straight borders between two colours (scene=edges), those within the window.
  [[nodiscard]] std::vector<Edge> edges() const;
  // Frequency vectors of u and of v, deformation left out [cycles/px]: {u_x, u_y}, {v_x, v_y}.
  [[nodiscard]] ScreenGradient mean_gradient() const;
  [[nodiscard]] std::array<double, 3> area_fractions() const;
  // Screen coordinates of the middle of one red, green and blue element; others lie whole periods
  // away.
  [[nodiscard]] std::array<ScreenPoint, 3> element_middles() const;
  [[nodiscard]] const FilmSpec& spec() const { return spec_; }

 private:
  // Where a perfect scanner would see what delivered pixel (x, y) sees.
  [[nodiscard]] ScanPlace optical(double x, double y) const;
  void silver_pixels(double y, double x, std::span<float> out) const;
  void strip_row(const FilmStrip& strip, double y, const RgbRow& out) const;
  FilmSpec spec_;
  ScanWindow window_;
  ScanGeometry geometry_;
  std::shared_ptr<const FilmStrip> strip_, light_;  // light_: taking and emulsion left out
  std::shared_ptr<const PlacedScreen> screen_;
  std::shared_ptr<const ScreenFilm> whole_film_;  // without grain, leak and faded places
};

// The scanner's geometry under these settings; its field is the frame's width. sensor: with the
// lines that the pass uses.
[[nodiscard]] ScanGeometry geometry_of(const SimSpec& spec, const SensorSpec& sensor);

// The spread function of a channel (0 to 3: R G B IR) at a delivered pixel of a window, in optical
// pixels; see sample_psf(). Throws InputError as that does.
[[nodiscard]] PsfGrid psf_at(const SimSpec& spec, const ScanWindow& window, int channel, double x,
                             double y, int samples_per_px, int radius_px);

// What is known of a window under the film's and the scanner's settings.
[[nodiscard]] FilmTruth truth_of(const SimSpec& spec, const ScanWindow& window);
// The whole first frame at optical resolution.
[[nodiscard]] ScanWindow frame_window(const SimSpec& spec);

struct SimulatedScan {
  LineFormat format;                   // red, green, blue, infrared
  std::vector<std::uint16_t> samples;  // canonical: [line][channel][pixel], full scale 65535
  FilmTruth truth;
};

// The whole first frame at optical resolution; its size is spec.film.frame, so a small frame holds
// the whole scene. Bare light reaches spec.sensor.clear_level in every channel.
[[nodiscard]] SimulatedScan simulate_frame(const SimSpec& spec);
// Any window of the film. Throws InputError when the window is empty.
[[nodiscard]] SimulatedScan simulate_window(const SimSpec& spec, const ScanWindow& window);

}  // namespace reseau::sim
