// From committed lines to a picture: the two calls that capture and the tests use.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/channel_offset.h"
#include "core/reconstruct/deconvolution.h"
#include "core/reconstruct/demosaic.h"
#include "core/reconstruct/picture_frame.h"
#include "core/reconstruct/row_sink.h"
#include "core/reconstruct/silver_from_rgb.h"
#include "core/reconstruct/tone_curve.h"
#include "core/reconstruct/unit_sharpness.h"
#include "core/screen/map_uncertainty.h"
#include "core/screen/screen_map.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// Fraction of the work done, 0..1; called from one thread at a time, never after the call returned.
using ProgressFn = std::function<void(double)>;

// What registration found. `found` false means: no réseau, with the reason in `reason`.
struct Registration {
  bool found = false;
  std::string reason;  // a sentence, when not found
  // Not found because a period holds too few pixels, or beats with them.
  bool too_coarse = false;
  std::string screen;     // its name, as in screen_names(), or "none"
  double confidence = 0;  // 0..1
  // That there is no réseau; the probability of `screen` and of the runner-up ("none" too).
  double none_probability = 1, screen_probability = 1;
  std::string runner_up;
  double runner_up_probability = 0;
  // Of a Dufaycolor: whose micrograph has elements of these sizes ("dufaycolor": Hubicka et al.),
  // and how probable that is among those that are known; empty otherwise.
  std::string printing;
  double printing_probability = 0;
  double explained = 0;  // share of what alternates in the brightest tiles that the screen explains
  ScreenMap map;         // screen (u, v) from scan pixels, valid over the whole frame when found
  // How it is known which element has which colour: "colour" as the scan shows it, "given" by hand,
  // or "unknown" in a scan without colours. There the first kind of square (or of two sites) is the
  // brighter one, and response and silver_from_rgb say nothing.
  std::string identity = "colour";
  // A screen of lines alone: nothing repeats along u, which is measured in periods of v and is not
  // known but for the map's own convention.
  bool lines_alone = false;
  std::array<Vec2, 2> lattice_cy_per_px{};  // mean frequency vectors of u (lines alone: 0), of v
  MapUncertainty uncertainty;               // of the map, place by place
  double residual_px = 0;                   // rms of the measured phases about the map
  // rms of blocks under a map that was fitted without them, along u and along v; absent unless
  // asked for.
  std::optional<Vec2> left_out_px;
  double angle_deg = 0;               // of the red lines, from the y axis of the scan
  std::array<double, 2> period_px{};  // of lines alone, that of u is infinite
  std::array<double, 2> period_um{};  // 0 when the resolution is unknown
  double angle_sd_deg = 0;            // of the means over the frame
  std::array<double, 2> period_sd_px{};
  // The symmetric Dufaycolor pattern cannot tell a mirrored film; then absent.
  std::optional<bool> mirrored;
  // Scanner response to each clear element, per unit infrared: [element R G B][channel R G B].
  std::array<std::array<double, 3>, 3> response{};
  // Weights that turn linear RGB into silver transmittance (Barker et al. 2022).
  std::array<double, 3> silver_from_rgb{};
  int n_windows = 0;  // places where phase was measured
  int n_outliers = 0;
  double seconds = 0;
};

// What is known after so many lines, while more arrive: the map holds in lines [0, n_lines), and
// what `registration` says is of those. Immutable: any thread may read it for as long as it likes.
// Without certainty by place; the error of the stage is not yet in it.
struct RegistrationSnapshot {
  int n_lines = 0;
  Registration registration;
};
inline constexpr int kSnapshotLines = 64;

struct RegisterOptions {
  ToneCurves tone = ToneCurves::linear();
  int n_threads = 0;  // 0 = all cores
  // Look for a réseau also where there is one channel, or three alike. Its colours are then not
  // known, and a halftone may pass for one.
  bool allow_grey = false;
  // By hand: which screen it is, as in screen_names(); empty = by evidence. And whether the two
  // kinds of squares (or of the two sites) are the other way round than they seem.
  std::string screen;
  bool exchange = false;
  // Fits again without some of the blocks and says how far those then lie off. Costs a little.
  bool check_left_out = false;
  // Called with a snapshot after every kSnapshotLines committed lines once the réseau shows itself,
  // which takes 256 lines where there is light; from the registering thread, which waits for it.
  // Empty: no snapshots, no cost. The final result is the same either way.
  std::function<void(std::shared_ptr<const RegistrationSnapshot>)> on_snapshot;
};

// Reads every line as it is committed (live or offline, the same code and the same result) and
// returns after the last. Throws what the source throws; never for a picture without a réseau.
// A stop request returns early with found = false.
[[nodiscard]] Registration register_screen(const LineSource& source, const RegisterOptions& options,
                                           const ProgressFn& progress, const std::stop_token& stop);

struct ReconstructOptions {
  Quality quality = Quality::kStandard;
  std::optional<Demosaic> demosaic;  // absent: that of the quality
  // Of the silver. Absent: Wiener's before the joint demosaic where the whole frame is soft, which
  // is where it gains; else none.
  std::optional<Deconvolution> deconvolution;
  FrameChoice frame;
  ToneCurves tone = ToneCurves::linear();
  // Row-major 3x3 applied to element intensities (process RGB) at the end; identity = process RGB.
  std::array<double, 9> output_from_process{1, 0, 0, 0, 1, 0, 0, 0, 1};
  double white_level = 1.0;  // linear sample value of clear film; intensity 1 there
  double black_level = 0.0;  // and without light; intensity 0 there
  // Blur of the silver picture [px, standard deviation] to undo; absent: what this scan shows.
  std::optional<double> blur_px;
  // What calibration says of the unit: decides where the scan shows too little of its sharpness,
  // and tells the light that goes far, which no scan shows.
  UnitSharpness unit;
  // How silver is made where there is no infrared; absent: by the elements of this very scan.
  std::optional<SilverWeights> silver_from_rgb;
  int n_threads = 0;
  bool exact = false;  // no shortcut that changes a pixel
};

struct BlurPlace {
  Vec2 at_px;
  double sigma_px = 0, sd_px = 0;  // sd 0 = not known
};

struct SharpnessReport {
  // Gaussian-equivalent PSF, pixel aperture included, per channel R G B IR [px]; how each was
  // found.
  std::array<double, 4> sigma_px{};
  std::array<double, 4> sigma_sd_px{};
  // Least and most over the frame, and the degree of the polynomial that describes it (0: the same
  // everywhere).
  std::array<std::array<double, 2>, 4> sigma_range_px{};
  std::array<int, 4> field_degree{};
  // 5 x 5 places, row by row, of channels whose blur changes over the frame.
  std::array<std::vector<BlurPlace>, 4> field;
  // "measured", "pooled", "profile" (of the unit), "default", "absent"
  std::array<std::string, 4> origin;
  // Width in focus beyond which the blur is a disc of defocus; infinite where it is Gaussian. How
  // much wider along x than along y, -1..1, as BlurShape, and its standard deviation.
  double in_focus_px = std::numeric_limits<double>::infinity();
  double stretch = 0, stretch_sd = 0;
  // What the profile says for this réseau, where it does.
  std::array<std::optional<UnitBlur>, 4> of_unit;
  // Printed widths as found in this film, of a screen of lines and squares (red lines and green
  // squares in a Dufaycolor).
  std::optional<ScreenWidths> widths;
  // Where infrared lies relative to RGB [px], by the réseau; zero where the picture does not tell,
  // and then without a deviation.
  Vec2 infrared_shift_px;
  std::optional<Vec2> infrared_shift_sd_px;
  ChannelOffsets channel_offsets;
};

struct ReconstructionReport {
  int width_px = 0, height_px = 0;  // of the picture
  double turned_deg = 0;            // against the scan, for Geometry::kFilm
  bool from_infrared = true;        // false: silver computed from RGB
  SilverWeights silver_from_rgb;    // used when not from infrared
  SharpnessReport sharpness;
  Deconvolution deconvolution = Deconvolution::kNone;  // that was done
  // By how much it raises the noise of a pixel at most, and iterations of Richardson-Lucy.
  double sharpening_noise_gain = 1;
  int sharpening_iterations = 0;
  double unmix_condition = 0;   // 2-norm condition number of the mean 3x3 crosstalk matrix
  double unmix_noise_gain = 0;  // largest row norm of its (regularised) inverse
  std::array<double, 4> clipped_fraction{};  // R G B IR samples at full scale
  std::vector<std::string> skipped;          // what was not needed and why
  double blank_fraction = 0;                 // of the pixels, which were skipped for being blank
  double seconds_sharpness = 0, seconds_render = 0;
};

// Renders, unless another frame is chosen, at the geometry of the scan: output pixel (x, y) lies
// where scan pixel (x, y) was. All lines must be committed. Same bytes for any thread count. Throws
// what source and sink throw. Returns early, without calling sink.end(), on a stop request.
[[nodiscard]] ReconstructionReport reconstruct(const LineSource& source,
                                               const Registration& registration,
                                               const ReconstructOptions& options, RgbRowSink& sink,
                                               const ProgressFn& progress,
                                               const std::stop_token& stop);

}  // namespace reseau
