#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibration/profile/records.h"
#include "core/geometry/vec2.h"
#include "core/line/capture_context.h"
#include "core/reconstruct/unit_sharpness.h"

namespace reseau {

// Order of all arrays here: red, green, blue, infrared.
inline constexpr int kProfileChannels = 4;
inline constexpr std::array<const char*, kProfileChannels> kProfileChannelNames = {
    "red", "green", "blue", "infrared"};

// Gaussian-equivalent point spread function, pixel aperture included.
struct PsfWidth {
  double sigma_px = 0;
  double sd_px = 0;  // standard deviation of sigma_px
  bool operator==(const PsfWidth&) const = default;
};

// Variance of a sample = a + b * (level - dark level), in units of full scale (1.0 = 65535)
// squared.
struct NoiseModel {
  double a = 0;
  double b = 0;
  bool operator==(const NoiseModel&) const = default;
};

// What one unit does to light, measured once. Plain value; absent = not measured.
struct Profile {
  static constexpr int kSchemaVersion = 1;

  std::string make, model, serial, firmware, holder;
  double resolution_dpi = 0;
  std::optional<int> focus_position;
  std::string measured_at_utc;  // ISO 8601
  std::string tool_version;

  std::array<std::optional<PsfWidth>, kProfileChannels> psf;
  // Modulation transfer in focus, mean over the edges; empty = not measured.
  std::array<std::vector<TransferPoint>, kProfileChannels> transfer;
  // Where a channel sees the point that green sees at (x, y): (x, y) + offset.
  std::array<std::optional<Vec2>, kProfileChannels> offset_from_green_px;
  // Signal without light, of full scale.
  std::array<std::optional<double>, kProfileChannels> dark_level;
  // Gain per sensor element that flattens the line, mean 1; empty = not measured.
  std::array<std::vector<double>, kProfileChannels> flat_gain;
  std::array<std::optional<NoiseModel>, kProfileChannels> noise;

  // The rest of what the open frame told, with deviations.
  std::array<std::optional<GateRecord>, kProfileChannels> gate;
  // Best focus, where several settings were scanned.
  std::array<std::optional<FocusRecord>, kProfileChannels> focus;
  std::array<std::optional<OffsetSd>, kProfileChannels> offset_sd_px;
  std::array<std::optional<RandomRecord>, kProfileChannels> random;
  // The physical model behind the curves.
  std::optional<PsfRecord> psf_model;

  // Provenance.
  std::string source_file, source_sha256, method;
  std::vector<std::string> remarks;

  bool operator==(const Profile&) const = default;
};

// Throws InputError naming the field when a number is not finite, negative where it cannot be, or a
// needed field is empty (model, resolution_dpi).
void validate(const Profile& profile);

// What differs between the unit and setting that were calibrated and those of a scan, as sentences;
// empty when the profile fits. Fields that either side does not know are not compared. `dpi` 0 =
// unknown.
[[nodiscard]] std::vector<std::string> mismatches(const Profile& profile,
                                                  const CaptureContext& context, double dpi);

}  // namespace reseau
