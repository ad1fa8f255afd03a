#include "drivers/sim/sim_key.h"

namespace reseau::sim {

const std::vector<NumberKey>& scanner_keys() {
  static const std::vector<NumberKey> keys{
      {"aperture_y_px", 0, 4, false, "the same along the motion; 0 = as along the sensor",
       [](SimSpec& s, double v) { s.optics.aperture_y_px = v; }},
      {"f_number", 0, 64, false, "of the lens on the film's side; 0 = no diffraction, no defocus",
       [](SimSpec& s, double v) { s.optics.f_number.fill(v); }},
      {"ir_f_number", 0, 64, false, "the same in infrared alone",
       [](SimSpec& s, double v) { s.optics.f_number[3] = v; }},
      {"red_nm", 380, 1100, false, "wavelength of the red light",
       [](SimSpec& s, double v) { s.optics.wavelength_um[0] = v / 1000; }},
      {"green_nm", 380, 1100, false, "wavelength of the green light",
       [](SimSpec& s, double v) { s.optics.wavelength_um[1] = v / 1000; }},
      {"blue_nm", 380, 1100, false, "wavelength of the blue light",
       [](SimSpec& s, double v) { s.optics.wavelength_um[2] = v / 1000; }},
      {"ir_nm", 380, 1100, false, "wavelength of the infrared light",
       [](SimSpec& s, double v) { s.optics.wavelength_um[3] = v / 1000; }},
      {"focus_um", -1000, 1000, false, "distance of the film from best focus",
       [](SimSpec& s, double v) { s.optics.focus_um = v; }},
      {"blue_focus_um", -1000, 1000, false, "blue's own part of it",
       [](SimSpec& s, double v) { s.optics.chromatic_focus_um[2] = v; }},
      {"ir_focus_um", -1000, 1000, false, "infrared's own part of it",
       [](SimSpec& s, double v) { s.optics.chromatic_focus_um[3] = v; }},
      {"focus_tilt_um", -1000, 1000, false, "change of focus from the axis to the field's end",
       [](SimSpec& s, double v) { s.optics.focus_tilt_um = v; }},
      {"focus_curve_um", -1000, 1000, false, "curvature of the field, at its ends",
       [](SimSpec& s, double v) { s.optics.focus_curvature_um = v; }},
      {"focus_drift_um", -500, 500, false, "change of focus per 1000 lines",
       [](SimSpec& s, double v) { s.optics.focus_drift_um = v; }},
      {"astigmatism_um", -500, 500, false, "focus along the sensor minus focus along the motion",
       [](SimSpec& s, double v) { s.optics.astigmatism_um = v; }},
      {"halo", 0, 0.9, false, "fraction of the light in a wide Gaussian",
       [](SimSpec& s, double v) { s.optics.halo_fraction = v; }},
      {"halo_px", 0.5, 64, false, "standard deviation of the halo",
       [](SimSpec& s, double v) { s.optics.halo_px = v; }},
      {"flare", 0, 0.5, false, "fraction of the light spread evenly over the lit slit",
       [](SimSpec& s, double v) { s.optics.flare = v; }},
      {"distortion", -0.05, 0.05, false, "radial, relative, at the field's ends",
       [](SimSpec& s, double v) { s.optics.distortion = v; }},
      {"red_stretch_px", -20, 20, false, "lateral colour of red at the field's ends",
       [](SimSpec& s, double v) { s.optics.stretch_px[0] = v; }},
      {"blue_stretch_px", -20, 20, false, "lateral colour of blue at the field's ends",
       [](SimSpec& s, double v) { s.optics.stretch_px[2] = v; }},
      {"ir_stretch_px", -20, 20, false, "lateral colour of infrared at the field's ends",
       [](SimSpec& s, double v) { s.optics.stretch_px[3] = v; }},
      {"red_shift_px", -5, 5, false, "displacement of red along the sensor",
       [](SimSpec& s, double v) { s.optics.shift_x_px[0] = v; }},
      {"blue_shift_px", -5, 5, false, "displacement of blue along the sensor",
       [](SimSpec& s, double v) { s.optics.shift_x_px[2] = v; }},
      {"ir_shift_px", -5, 5, false, "displacement of infrared along the sensor",
       [](SimSpec& s, double v) { s.optics.shift_x_px[3] = v; }},
      {"red_shift_y_px", -5, 5, false, "displacement of red along the motion",
       [](SimSpec& s, double v) { s.optics.shift_y_px[0] = v; }},
      {"blue_shift_y_px", -5, 5, false, "displacement of blue along the motion",
       [](SimSpec& s, double v) { s.optics.shift_y_px[2] = v; }},
      {"ir_shift_y_px", -5, 5, false, "displacement of infrared along the motion",
       [](SimSpec& s, double v) { s.optics.shift_y_px[3] = v; }},
      {"wave_px", 0, 20, false, "amplitude of a sine in the motion",
       [](SimSpec& s, double v) { s.stage.wave_px = v; }},
      {"wave_lines", 2, 100000, false, "lines per cycle of it",
       [](SimSpec& s, double v) { s.stage.wave_lines = v; }},
      {"wave_phase", -360, 360, false, "of it at line 0 [degree]",
       [](SimSpec& s, double v) { s.stage.wave_phase_deg = v; }},
      {"wave_sideways", -1, 1, false, "share of it that displaces along the sensor, too",
       [](SimSpec& s, double v) { s.stage.sideways = v; }},
      {"jitter_px", 0, 2, false, "standard deviation of a line's own error",
       [](SimSpec& s, double v) { s.stage.jitter_px = v; }},
      {"walk_px", 0, 0.1, false, "standard deviation of a random walk's step from line to line",
       [](SimSpec& s, double v) { s.stage.walk_px = v; }},
      {"read_noise", 0, 0.1, false, "standard deviation, added [fraction of full scale]",
       [](SimSpec& s, double v) { s.sensor.read_noise = v; }},
      {"dark", 0, 0.5, false, "dark level [fraction of full scale]",
       [](SimSpec& s, double v) { s.sensor.dark_level = v; }},
      {"dark_noise", 0, 0.1, false, "standard deviation of the dark current's noise",
       [](SimSpec& s, double v) { s.sensor.dark_noise = v; }},
      {"dark_pattern", 0, 0.1, false, "standard deviation of the dark level from pixel to pixel",
       [](SimSpec& s, double v) { s.sensor.dark_pattern = v; }},
      {"pixel_gain", 0, 0.2, false, "relative standard deviation of gain from pixel to pixel",
       [](SimSpec& s, double v) { s.sensor.pixel_gain = v; }},
      {"shading", 0, 1, false, "relative fall of the light towards the field's ends",
       [](SimSpec& s, double v) { s.sensor.shading = v; }},
      {"readings", 1, 64, true, "averaged per line when no unit stands in between",
       [](SimSpec& s, double v) { s.sensor.readings = as_int(v); }},
      {"sensor_lines", 1, 3, true, "lines of the sensor when no unit stands in between",
       [](SimSpec& s, double v) { s.sensor.n_lines = as_int(v); }},
      {"line_gap_px", 1, 12, true, "lines on the film from one of them to the next",
       [](SimSpec& s, double v) { s.sensor.line_gap_px = as_int(v); }},
      {"stagger_px", -2, 2, false, "error of the second line's place along the motion",
       [](SimSpec& s, double v) { s.sensor.stagger_y_px = v; }},
      {"stagger_x_px", -2, 2, false, "error of the second line's place along the sensor",
       [](SimSpec& s, double v) { s.sensor.stagger_x_px = v; }},
      {"line_gain", -0.5, 0.5, false, "gain of the second line over the first, relative",
       [](SimSpec& s, double v) { s.sensor.line_gain = v; }},
      {"line_response", 0, 1, false, "0 equal lines, 1 as an LS-5000's curves differ",
       [](SimSpec& s, double v) { s.sensor.line_response = s.unit.line_response = v; }},
  };
  return keys;
}

void set_coolscan(SimSpec& spec) {
  spec.optics.blur_px = {0.23, 0, 0.21, 0.16};
  // Cutoffs of 1.14, 1.36, 1.51 and 0.94 cycles per pixel at the assumed wavelengths.
  spec.optics.f_number = {8.70, 8.81, 9.14, 7.76};
  spec.optics.aperture_px = 2;
  // 0.41 px rms. The 1.4 px from peak to peak of the real crops are this and the scatter.
  spec.stage.wave_px = 0.58;
  spec.stage.wave_lines = 225;
  spec.stage.jitter_px = 0.038;
}

}  // namespace reseau::sim
