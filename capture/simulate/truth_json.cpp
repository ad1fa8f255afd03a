#include <algorithm>

#include "capture/simulate/truth_files.h"
#include "drivers/sim/sensor.h"

namespace reseau::simulate {
namespace {

using Json = nlohmann::ordered_json;

Json film_json(const sim::FilmSpec& f) {
  constexpr std::array<const char*, 3> kKinds{"dufay", "none", "empty"};
  constexpr std::array<const char*, 10> kScenes{"chart", "natural", "sweep", "edges", "zone",
                                                "star",  "image",   "razor", "clear", "random"};
  constexpr std::array<const char*, 7> kDyes{"harrison_horner", "cornwell_clyne", "collins_giles",
                                             "neblette",        "thames",         "dioptichrome",
                                             "measured"};
  const sim::ScreenSpec& s = f.screen;
  return {{"film", kKinds[static_cast<std::size_t>(f.kind)]},
          {"scene", kScenes[static_cast<std::size_t>(f.scene)]},
          {"picture", f.picture},
          {"screen", f.kind == sim::FilmKind::kDufay
                         ? Json(screen_names()[static_cast<std::size_t>(s.kind)].name)
                         : Json(nullptr)},
          {"width_px", f.frame.width_px},
          {"height_px", f.frame.height_px},
          {"frames", f.frame.n_frames},
          {"pixel_um", f.frame.pixel_um},
          {"outside_px", f.frame.outside_px},
          {"rebate_px", f.frame.rebate_px},
          {"border_px", f.frame.border_px},
          {"period_u_um", s.period_u_um},
          {"period_v_um", s.period_v_um},
          {"angle_deg", s.angle_deg},
          {"axes_deg", s.axes_deg},
          {"phase_u", s.phase_u},
          {"phase_v", s.phase_v},
          {"red_fraction", s.red_fraction},
          {"green_fraction", s.green_fraction},
          {"bend_px", s.bend_px},
          {"mirrored", f.mirrored},
          {"edge_angle_deg", f.edge_angle_deg},
          {"random_cell_um", f.random_cell_um},
          {"finest_cy_per_px", f.finest_cy_per_px},
          {"spokes", f.spokes},
          {"dyes",
           {{"source", kDyes[static_cast<std::size_t>(f.dyes.source)]},
            {"fade", f.dyes.fade},
            {"infrared_leak", f.dyes.infrared_leak}}},
          {"deformation",
           {{"perspective_x", f.deform.perspective_x},
            {"perspective_y", f.deform.perspective_y},
            {"radial", f.deform.radial},
            {"warp_px", f.deform.warp_px},
            {"warp_length_px", f.deform.warp_length_px},
            {"curl_um", f.deform.curl_um}}},
          {"printing",
           {{"overlap_um", f.print.overlap_um},
            {"dark_gaps", f.print.dark_gaps},
            {"position_noise_um", f.print.position_noise_um},
            {"width_noise_um", f.print.width_noise_um},
            {"noise_length_um", f.print.noise_length_um},
            {"missing", f.print.missing}}},
          {"emulsion",
           {{"taking", f.emulsion.ideal_taking ? "ideal" : "dufay"},
            {"hd_gamma", f.emulsion.hd.gamma},
            {"hd_dmin", f.emulsion.hd.d_min},
            {"hd_dmax", f.emulsion.hd.d_max},
            {"hd_toe", f.emulsion.hd.toe},
            {"hd_speed", f.emulsion.hd.log_speed},
            {"spread_um", f.emulsion.spread_um},
            {"silver_spread_um", f.emulsion.silver_spread_um},
            {"grain", f.emulsion.grain},
            {"grain_um", f.emulsion.grain_um}}},
          {"damage",
           {{"dust_per_cm2", f.damage.dust_per_cm2},
            {"dust_um", f.damage.dust_um},
            {"scratches_per_cm", f.damage.scratches_per_cm},
            {"bubbles_per_cm2", f.damage.bubbles_per_cm2},
            {"bubble_um", f.damage.bubble_um},
            {"faded_areas", f.damage.faded_areas},
            {"stains", f.damage.stains}}}};
}

Json optics_json(const sim::OpticsSpec& o) {
  return {{"blur_px", o.blur_px},
          {"aperture_px", o.aperture_px},
          {"aperture_y_px", o.aperture_y_px},
          {"cells_per_px", o.cells_per_px},
          {"f_number", o.f_number},
          {"wavelength_um", o.wavelength_um},
          {"focus_um", o.focus_um},
          {"chromatic_focus_um", o.chromatic_focus_um},
          {"focus_tilt_um", o.focus_tilt_um},
          {"focus_curvature_um", o.focus_curvature_um},
          {"focus_drift_um", o.focus_drift_um},
          {"astigmatism_um", o.astigmatism_um},
          {"halo_fraction", o.halo_fraction},
          {"halo_px", o.halo_px},
          {"flare", o.flare},
          {"distortion", o.distortion},
          {"stretch_px", o.stretch_px},
          {"shift_x_px", o.shift_x_px},
          {"shift_y_px", o.shift_y_px}};
}

Json stage_json(const sim::StageSpec& s) {
  return {{"wobble_px", s.wobble_px},   {"wave_px", s.wave_px},
          {"wave_lines", s.wave_lines}, {"wave_phase_deg", s.wave_phase_deg},
          {"sideways", s.sideways},     {"jitter_px", s.jitter_px},
          {"walk_px", s.walk_px}};
}

Json sensor_json(const sim::SensorSpec& s) {
  return {{"noise", s.noise},
          {"adc_bits", s.adc_bits},
          {"clear_level", s.clear_level},
          {"read_noise", s.read_noise},
          {"dark_level", s.dark_level},
          {"dark_noise", s.dark_noise},
          {"dark_pattern", s.dark_pattern},
          {"pixel_gain", s.pixel_gain},
          {"shading", s.shading},
          {"readings", s.readings},
          {"n_lines", s.n_lines},
          {"line_gap_px", s.line_gap_px},
          {"line_origin_px", s.line_origin_px},
          {"stagger_x_px", s.stagger_x_px},
          {"stagger_y_px", s.stagger_y_px},
          {"line_gain", s.line_gain},
          {"line_response", s.line_response}};
}

Json psf_json(const sim::FrameSpec& frame) {
  Json places = Json::array();
  for (int j = 0; j < kPsfPlaces; ++j) {
    for (int i = 0; i < kPsfPlaces; ++i) {
      places.push_back({{"x_px", (i + 0.5) * frame.width_px / kPsfPlaces - 0.5},
                        {"y_px", (j + 0.5) * frame.height_px / kPsfPlaces - 0.5}});
    }
  }
  return {{"columns", kPsfPlaces},
          {"rows", kPsfPlaces},
          {"samples_per_px", kPsfSamplesPerPx},
          {"radius_px", kPsfRadiusPx},
          {"side", 2 * kPsfRadiusPx * kPsfSamplesPerPx + 1},
          {"unit", "light per optical pixel squared, pixel aperture included"},
          {"places", places}};
}

}  // namespace

nlohmann::ordered_json truth_to_json(const sim::SimSpec& spec, const KnownScan& scan) {
  const sim::NoiseModel noise = sim::noise_model(spec.sensor, 1);
  Json object = {{"schema", "reseau-truth/1"},
                 {"seed", spec.film.seed},
                 {"width_px", scan.format.width_px},
                 {"height_px", scan.format.n_lines},
                 {"channels", {"red", "green", "blue", "infrared"}},
                 {"film", film_json(spec.film)},
                 {"optics", optics_json(spec.optics)},
                 {"stage", stage_json(spec.stage)},
                 {"sensor", sensor_json(spec.sensor)},
                 // Fractions of full scale squared; variance = constant + per_signal * light +
                 // quantisation, of one reading.
                 {"noise_model",
                  {{"constant", noise.constant},
                   {"per_signal", noise.per_signal},
                   {"quantisation", noise.quantisation}}},
                 {"psf", psf_json(spec.film.frame)}};
  if (scan.truth.has_screen()) {
    const sim::ScreenGradient g = scan.truth.mean_gradient();
    object["screen"] = {{"name", scan.truth.screen_name()},
                        {"lattice_cy_per_px", {{g.u_x, g.u_y}, {g.v_x, g.v_y}}},
                        {"area_fractions", scan.truth.area_fractions()}};
  }
  // How far the samples are from the limit of ever finer cells, bare light = 1.
  const sim::ScanWindow window = sim::frame_window(spec);
  // A small frame needs no more than a few pieces, each of which costs what lies around it.
  constexpr int kFewest = 3, kMost = 12, kPixelsEach = 30'000;
  const int n_pieces = std::clamp(window.width_px * window.n_lines / kPixelsEach, kFewest, kMost);
  const sim::RenderError error = sim::estimate_error(sim::make_film(spec.film), spec.optics, window,
                                                     sim::geometry_of(spec, spec.sensor), n_pieces);
  object["integration"] = {{"cells_per_px", error.cells_per_px},
                           {"estimated_rms_error", error.rms},
                           {"estimated_largest_error", error.largest},
                           {"samples", error.n_samples}};
  Json patches = Json::array();
  for (const sim::Patch& p : scan.truth.patches()) {
    patches.push_back({{"x0", p.x0}, {"y0", p.y0}, {"x1", p.x1}, {"y1", p.y1}, {"rgb", p.rgb}});
  }
  object["patches"] = patches;
  Json edges = Json::array();
  for (const sim::Edge& e : scan.truth.edges()) {
    edges.push_back({{"x", e.x},
                     {"y", e.y},
                     {"angle_deg", e.angle_deg},
                     {"x0", e.x0},
                     {"y0", e.y0},
                     {"x1", e.x1},
                     {"y1", e.y1},
                     {"left", e.left},
                     {"right", e.right}});
  }
  object["edges"] = edges;
  return object;
}

}  // namespace reseau::simulate
