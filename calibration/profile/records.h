// Parts of a profile beyond one number for a channel. Plain values; absent = not measured.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/profile/measured.h"

namespace reseau {

// Of one channel, from scans of an open frame. Levels of full scale.
struct GateRecord {
  std::optional<double> dark_level_sd;  // of Profile::dark_level
  // Covariance of Profile::noise: of a, of a with b, of b.
  std::optional<std::array<double, 3>> noise_covariance;
  std::optional<double> flat_gain_sd;    // of one of Profile::flat_gain
  std::optional<double> shading;         // relative fall of the light, brightest to darkest tenth
  std::optional<double> pixel_gain_rms;  // relative, from pixel to pixel
  std::optional<double> lamp_rms;        // relative, from line to line
  std::vector<Measured> line_gains;      // of each line of the sensor, mean 1
  std::optional<Measured> nonlinearity;  // largest departure of level against exposure
  // Share of this channel's light that comes with the light of red, green, blue, infrared.
  std::array<std::optional<Measured>, 4> leakage;
  bool operator==(const GateRecord&) const = default;
};

// Of one channel, from an edge at several focus settings.
struct FocusRecord {
  double f_cy_per_px = 0;  // of the modulation that was followed
  Measured best_steps;     // setting of the unit
  std::optional<Measured> from_green_steps;
  std::optional<Measured> half_depth_steps;  // to `depth_share` of the best modulation
  double depth_share = 0;
  // Setting, modulation, deviation.
  std::vector<std::array<double, 3>> curve;
  bool operator==(const FocusRecord&) const = default;
};

// Of one channel, from a random target: the spread of a point in both directions.
struct RandomRecord {
  double seed = 0, cell_um = 0;  // of the target
  int side = 0;                  // samples along each axis, step_px apart, the middle one at (0, 0)
  double step_px = 0;
  std::vector<double> psf, sd;  // [row][column], per px squared
  double relative_sd = 0;       // of the whole
  Measured light_outside;       // share that goes beyond
  std::optional<Measured> mtf50_x, mtf50_y;
  // Frequency, modulation of all light, deviation, along the sensor and along the motion.
  std::vector<std::array<double, 3>> along_x, along_y;
  bool operator==(const RandomRecord&) const = default;
};

// Deviations of where a channel lies against green.
struct OffsetSd {
  double x_px = 0, y_px = 0;
  bool operator==(const OffsetSd&) const = default;
};

// Local part of the blur over the frame: a polynomial in x and y, each -1 to 1 over the frame,
// for the Gaussian variance [px^2] that comes on top of the model's.
struct FieldRecord {
  int order = 0;                              // 0, 1 or 2; coefficients of 1, x, y, x^2, x y, y^2
  std::vector<double> coefficients;           // 1, 3 or 6
  std::vector<double> covariance;             // row by row
  std::vector<std::array<double, 4>> places;  // x, y, value, deviation of each edge
  bool operator==(const FieldRecord&) const = default;
  // At a place, with the deviation that the covariance gives.
  [[nodiscard]] Measured at(double x, double y) const;
};

// Every parameter of the physical model as a surface over the frame, fitted to all edges together.
// x and y run from -1 to 1 over the frame of `frame_px`.
struct PsfFieldRecord {
  struct Surface {
    std::string name;  // as in PsfRecord; those of the unit count for every channel
    int order = 0;     // 0, 1 or 2; 1, 3 or 6 coefficients of 1, x, y, x^2, x y, y^2
    bool determined = true;
    bool operator==(const Surface&) const = default;
  };
  std::array<int, 2> frame_px{};
  int edges = 0;
  bool known = false;  // edges lie in enough places to tell a change
  bool has_focus = false;
  double focus = 0;  // setting that `mtf50` stands for: green's best in the middle
  std::vector<Surface> surfaces;
  std::vector<double> coefficients;  // of all surfaces, one after the other
  std::vector<double> covariance;    // of all of them, row by row
  int rank = 0;                      // of as many coefficients
  double scatter = 1;                // of the edges about the surfaces, over what they claim
  struct Pair {
    std::string a, b;
    double r = 0;
    bool operator==(const Pair&) const = default;
  };
  std::vector<Pair> correlated;      // beyond +-0.95 in the middle of the frame
  std::vector<std::string> remarks;  // what cannot be told, as sentences
  bool operator==(const PsfFieldRecord&) const = default;

  // Nothing for a name that is not among them.
  [[nodiscard]] std::optional<Measured> at(const std::string& name, double x, double y) const;
  [[nodiscard]] const Surface* find(const std::string& name) const;
  // How a parameter at a place depends on the coefficients: as many numbers as there are.
  [[nodiscard]] std::vector<double> weights(const std::string& name, double x, double y) const;
};

// Physical model of the optics (calibration/psf), parameters by name.
struct PsfRecord {
  std::vector<std::string> names;
  std::vector<double> values, sd;
  std::vector<bool> determined;
  std::vector<double> covariance;  // of the names, row by row
  double chi2_per_freedom = 0;
  std::array<std::optional<FieldRecord>, 4> field;
  std::optional<PsfFieldRecord> surfaces;
  bool operator==(const PsfRecord&) const = default;
};

}  // namespace reseau
