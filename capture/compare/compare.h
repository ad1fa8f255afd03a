// Two pictures, or a result and its truth: colour difference, registration, resolution, noise.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "capture/compare/block_stats.h"
#include "capture/compare/edge_mtf.h"
#include "capture/compare/map_error.h"
#include "capture/compare/picture.h"

namespace reseau::compare {

struct Rect {
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;
};

enum class Fit {
  kNone,
  kGain,   // one factor on B, least squares on Y
  kWhite,  // the mean colour of B brought onto that of A (Bradford, luminance included)
};

// Which white CIELAB is taken against. XYZ are relative to D65; for another illuminant they are
// adapted to it (Bradford) and its own white is used, so that a neutral stays a neutral.
enum class LabWhite { kD65, kD50, kA, kB, kC, kE, kOwn };  // own: (1, 1, 1) of each picture

enum class Layer { kAuto, kProcess, kScene };  // of a truth

// Words of options and results: none, gain, white; D65, D50, A, B, C, E, own; auto, process, scene.
// Parsing anything else: InputError.
[[nodiscard]] std::string word_of(Fit fit);
[[nodiscard]] std::string word_of(LabWhite white);
[[nodiscard]] Fit parse_fit(std::string_view word);
[[nodiscard]] LabWhite parse_lab_white(std::string_view word);
[[nodiscard]] Layer parse_layer(std::string_view word);

struct CompareOptions {
  Fit fit = Fit::kNone;
  LabWhite white = LabWhite::kD65;
  bool clamp_xyz = false;        // X, Y and Z to 0..1 before CIELAB
  double worst_fraction = 0.01;  // left out of `trimmed`
  bool adapt_own_white = false;  // each picture's own (1, 1, 1) becomes D65 first (Bradford)
  bool untagged_is_linear = false;
  Layer layer = Layer::kAuto;
  std::optional<Rect> crop;              // of A
  int border_px = 0;                     // left out on every side, after the crop
  int offset_x_px = 0, offset_y_px = 0;  // pixel of B where pixel (0, 0) of A is
  std::optional<Rect> edge;              // where the slanted edge is, in A; absent: searched for
  std::filesystem::path map_a, map_b;    // EXR with u and v, instead of the pictures' own
};

struct DifferenceFigures {
  double mean = 0, median = 0, p95 = 0, max = 0;
  long long n = 0;
};

struct ColorFigures {
  long long n_not_finite = 0;  // left out: NaN, infinity or transparent in one of the two
  DifferenceFigures all;
  DifferenceFigures without_worst_percent;
  DifferenceFigures trimmed;  // without options.worst_fraction
  BiasFigures bias;
  double gain = 1;                  // of Fit::kGain
  Matrix3 fit_matrix = kIdentity3;  // on XYZ of B
};

struct ResolutionFigures {
  Rect edge;  // in A
  EdgeMtf a, b;
  double shift_px = 0;                       // of B's edge across the edge, along the normal
  std::vector<std::optional<double>> ratio;  // B over A; absent where A has less than 0.1
};

// One value per square of `cell_px` pixels: mean colour difference, NaN where no pixel counted.
struct ErrorRaster {
  int cell_px = 1, width = 0, height = 0;
  std::vector<float> mean_delta_e;
  [[nodiscard]] float at(int x, int y) const {
    return mean_delta_e[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x)];
  }
};

struct Comparison {
  PictureHeader a, b;
  std::string encoding_a, encoding_b;
  std::vector<std::string> notes_a, notes_b;
  std::string pairing;       // a sentence: how the two were brought to one colour space
  bool process_rgb = false;  // both are process RGB, seen through `primaries`
  Rect area;                 // of A
  bool identical = false;    // every sample, as the files hold them
  double max_abs = 0;        // largest difference of samples as the files hold them
  Xyz lab_white_a{}, lab_white_b{};

  // Each absent with a reason (a sentence).
  std::optional<ColorFigures> color;
  std::string no_color;
  std::optional<MapError> registration;
  std::string no_registration;
  std::optional<ResolutionFigures> resolution;
  std::string no_resolution;
  std::optional<NoiseFigures> noise;
  std::string no_noise;
  std::optional<ShiftFigures> shift;
  std::string no_shift;

  ErrorRaster raster;                 // empty without colour
  std::vector<std::string> warnings;  // sentences
};

// Reads both by bands on all cores; memory is two floats per pixel plus what the file formats need
// (PNG and tiled TIFF are decoded whole). The figures do not depend on the number of threads.
// Throws InputError for files that cannot be compared, std::system_error; returns nothing when
// stopped.
[[nodiscard]] std::optional<Comparison> compare_files(const std::filesystem::path& a,
                                                      const std::filesystem::path& b,
                                                      const CompareOptions& options,
                                                      const std::stop_token& stop);

}  // namespace reseau::compare
