// Any picture as XYZ: EXR, TIFF and PNG, each by what it says about its own colours.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/color/colorimetry.h"
#include "core/color/rgb_space.h"

namespace reseau::compare {

// What a file says of itself before a pixel is read.
struct PictureHeader {
  std::filesystem::path path;
  std::string format;  // "OpenEXR", "TIFF", "PNG"
  int width_px = 0, height_px = 0;
  bool has_color = false;
  bool has_process = false;  // EXR of simulated truth: element intensities in R, G, B
  bool has_scene = false;    // the same: what the camera saw, in scene.R, scene.G, scene.B
  bool has_map = false;      // EXR with u and v: screen coordinates of every pixel, in periods
  std::optional<Chromaticities> chromaticities;
  std::optional<Chromaticity> adopted_neutral;  // x, y that should look neutral
  // Element intensities to samples, where the file holds it.
  std::optional<Matrix3> output_from_process;
  // Of our own reconstructions and truths; empty when the file does not say.
  std::string space;  // "process", "xyz", "srgb-linear" ...
  std::string primaries, balance;
};

// XYZ relative to D65 from the samples of an EXR by its chromaticities. A neutral that it adopts is
// adapted to D65 (Bradford); without one, its white stays what it is. Nothing where it declares no
// chromaticities.
[[nodiscard]] std::optional<Matrix3> declared_xyz(const PictureHeader& header);

// Throws InputError when the file is missing, damaged, or no EXR, TIFF or PNG; std::system_error
// when it cannot be opened.
[[nodiscard]] PictureHeader read_picture_header(const std::filesystem::path& path);

// How a picture is to be read.
struct PictureChoice {
  bool scene_layer = false;  // of a truth: scene.R, scene.G, scene.B instead of R, G, B
  // Instead of what the file declares, for linear samples: XYZ (D65, Y = 1) from its R, G, B.
  std::optional<Matrix3> xyz_from_samples = {};
  // For TIFF and PNG without a profile: samples are linear, with the primaries of sRGB. Otherwise
  // integer samples are taken as sRGB and float ones as linear.
  bool untagged_is_linear = false;
};

// Thread-bound but for to_xyz(). One file each.
class Picture {
 public:
  virtual ~Picture() = default;

  [[nodiscard]] const PictureHeader& header() const { return header_; }
  // Sentences: how samples become colours, what was left out.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  // One word or two for a result: "chromaticities", "ICC profile", "sRGB", "linear sRGB assumed".
  [[nodiscard]] const std::string& encoding() const { return encoding_; }
  // XYZ of the file's own (1, 1, 1), D65 where it does not say.
  [[nodiscard]] const Xyz& own_white() const { return own_white_; }

  // [row][pixel][3] as stored; integers as fractions of full scale; NaN where alpha is 0. Throws
  // InputError for damaged data.
  virtual void read(int first_row, int n_rows, std::span<float> out) = 0;
  // The same layout to XYZ relative to D65, Y of white = 1, not clipped. Thread-safe. `xyz` may be
  // `samples`.
  virtual void to_xyz(std::span<const float> samples, std::span<float> xyz) const = 0;
  // [row][pixel][u, v] in periods; header().has_map must hold.
  virtual void read_map(int first_row, int n_rows, std::span<float> out);

 protected:
  explicit Picture(PictureHeader header) : header_(std::move(header)) {}
  PictureHeader header_;
  std::vector<std::string> notes_;
  std::string encoding_;
  Xyz own_white_{};
};

// Throws as read_picture_header; InputError also when the file has neither colours nor a map.
[[nodiscard]] std::unique_ptr<Picture> open_picture(const PictureHeader& header,
                                                    const PictureChoice& choice = {});

}  // namespace reseau::compare
