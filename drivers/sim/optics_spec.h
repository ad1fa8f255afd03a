// Parameters of the simulated optics, stage and sensor. Plain values; sim_spec.h parses and checks
// them. Channels in the order red, green, blue, infrared. OPTICS.md derives the model.
#pragma once

#include <array>

namespace reseau::sim {

struct OpticsSpec {
  // Standard deviation of the Gaussian core per channel [optical px]; the pixel aperture comes on
  // top.
  std::array<double, 4> blur_px{0.6, 0.6, 0.6, 0.7};
  double aperture_px = 1.0;    // width along the sensor over which a pixel integrates
  double aperture_y_px = 0.0;  // the same along the motion; 0 = as along the sensor
  // Of the numerical integration; 0 = as many as the film's edges need (cells_used()).
  int cells_per_px = 0;
  // Cells are joined while the spread functions allow it and more than these are left.
  int fewest_cells_per_px = 1;

  // The lens: diffraction and defocus. An f-number of 0 leaves both out.
  std::array<double, 4> f_number{0, 0, 0, 0};  // on the film's side
  std::array<double, 4> wavelength_um{0.64, 0.53, 0.46, 0.87};
  double pixel_um = 25400.0 / 4000.0;  // of an optical pixel on the film
  // Distance of the film from best focus, positive towards the lens: a part for all, one per
  // channel, and how it changes along the field (rho from -1 to 1) and with the lines. The film's
  // own height is added.
  double focus_um = 0;
  std::array<double, 4> chromatic_focus_um{0, 0, 0, 0};
  double focus_tilt_um = 0;       // times rho
  double focus_curvature_um = 0;  // times rho squared
  double focus_drift_um = 0;      // per 1000 lines
  double astigmatism_um = 0;      // focus along the sensor minus focus along the motion
  double halo_fraction = 0;       // of the light, in a second, wider Gaussian
  double halo_px = 6;             // its standard deviation
  double flare = 0;               // fraction of the light spread evenly over the lit slit
  // Geometry of the image on the sensor's line. rho is 1 at the end of the field.
  double distortion = 0;  // radial: a sample at rho looks at rho (1 + distortion rho^2)
  // Lateral colour: what a channel is displaced by at rho = 1 in addition to the shift.
  std::array<double, 4> stretch_px{0, 0, 0, 0};
  std::array<double, 4> shift_x_px{0, 0, 0, 0};
  std::array<double, 4> shift_y_px{0, 0, 0, 0};
};

// Errors of the motion, in optical px on the film. All act on the nominal line positions.
struct StageSpec {
  double wobble_px = 0;       // largest error of a lead screw with two periods; a third sideways
  double wave_px = 0;         // amplitude of a sine along the motion
  double wave_lines = 225;    // lines per cycle of it
  double wave_phase_deg = 0;  // at line 0
  double sideways = 0;        // share of the sine that also displaces along the sensor
  double jitter_px = 0;       // standard deviation of a line's own error
  double walk_px = 0;         // standard deviation of the step of a random walk from line to line
};

struct SensorSpec {
  // Standard deviation at full scale, as a fraction of full scale: photon noise and a fifth of it
  // read noise.
  double noise = 0.002;
  int adc_bits = 16;
  double clear_level = 0.90;  // fraction of full scale that bare light reaches

  // Fractions of full scale unless said otherwise.
  double read_noise = 0;    // standard deviation, in addition
  double dark_level = 0;    // what no light reads; nothing below 0 is delivered
  double dark_noise = 0;    // standard deviation of the dark current's own noise
  double dark_pattern = 0;  // standard deviation from pixel to pixel, the same in every line
  double pixel_gain = 0;    // relative standard deviation of gain from pixel to pixel
  double shading = 0;       // relative fall of the light towards both ends of the field
  int readings = 1;         // averaged per line, where no unit stands in between
  // Lines of the sensor: 1, 2 (LS-5000) or 3 (LS-8000, LS-9000), and how far apart [optical px].
  int n_lines = 1;
  int line_gap_px = 1;
  int line_origin_px = 0;  // optical line that the first of them exposes
  // Error of the place of the second and, twofold, the third line.
  double stagger_x_px = 0, stagger_y_px = 0;
  double line_gain = 0;       // relative gain of the second line, minus that of the third
  bool one_response = false;  // every channel's lines differ as green's do
  double line_response = 0;   // 0 equal lines, 1 lines that differ as an LS-5000's curves say
};

// Whether anything is asked for that the plain Gaussian with a square aperture does not hold.
[[nodiscard]] inline bool is_plain(const OpticsSpec& o) {
  for (int c = 0; c < 4; ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (o.f_number[k] != 0 || o.stretch_px[k] != 0 || o.shift_x_px[k] != 0 ||
        o.shift_y_px[k] != 0) {
      return false;
    }
  }
  const bool square = o.aperture_y_px == 0 || o.aperture_y_px == o.aperture_px;
  return square && o.halo_fraction == 0 && o.flare == 0 && o.distortion == 0;
}

}  // namespace reseau::sim
