// What the light of an open frame tells of a unit: dark level, flat field, noise against level,
// lines of the sensor that differ, how linear the exposure is, and light of one channel that shows
// in another. Pure, reentrant. Levels are of full scale, exposures in microseconds.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/profile/measured.h"

namespace reseau {

inline constexpr int kGateChannels = 4;  // red, green, blue, infrared

// One scan of the open frame.
struct GateScan {
  int width_px = 0, n_lines = 0;
  // Lines of the sensor that took turns; 0 = not known.
  int sensor_lines = 0;
  // [line][pixel], 0 to 1; empty = the channel was not scanned.
  std::array<std::vector<float>, kGateChannels> light;
  std::array<std::optional<double>, kGateChannels> exposure_us;
};

// One channel of one scan.
struct GateLevel {
  std::optional<double> exposure_us;
  double level = 0, level_sd = 0;        // mean over the frame
  double variance = 0, variance_sd = 0;  // of one sample, pattern and lamp taken out
  bool clipped = false;                  // too many samples at an end of the scale
};

// Variance of a sample = read + shot * (level - dark level), with the covariance of the two.
struct GateNoise {
  double read = 0, shot = 0;
  double read_variance = 0, covariance = 0, shot_variance = 0;
  bool operator==(const GateNoise&) const = default;
};

struct GateChannel {
  std::vector<GateLevel> levels;  // of each scan that has the channel
  // Absent where the scans at hand do not tell; GateResult::remarks say why.
  std::optional<Measured> dark;
  std::vector<double> flat_gain;    // per pixel, takes shading and pixels away; mean 1
  double flat_gain_sd = 0;          // of one of them
  std::optional<double> shading;    // fall of the light from its brightest tenth to its darkest
  std::optional<double> pixel_rms;  // relative, of gain from pixel to pixel, shading taken out
  std::optional<GateNoise> noise;
  std::optional<double> lamp_rms;    // relative, of light from line to line
  std::vector<Measured> line_gains;  // of each line of the sensor, mean 1
  // Largest departure from a straight line of level against exposure.
  std::optional<Measured> nonlinearity;
  // Share of this channel's light that comes with the light of another, at the exposures of the
  // first scan.
  std::array<std::optional<Measured>, kGateChannels> leakage;
};

struct GateResult {
  std::array<GateChannel, kGateChannels> channels;
  std::vector<std::string> remarks;  // sentences: what cannot be told, and what would tell it
};

// Any number of scans of the same frame. Dark level, linearity and leakage need scans of different
// exposures; noise against level needs two levels or more. Throws nothing for anything in the
// samples; scans of another width than the first are left out with a remark.
[[nodiscard]] GateResult measure_gate(const std::vector<GateScan>& scans);

}  // namespace reseau
