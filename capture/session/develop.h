// From lines to a picture on disk: registration while lines arrive, then reconstruction. The same
// for a running scan and for a file.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "capture/color/neutral_area.h"
#include "capture/image/picture_writer.h"
#include "capture/session/silver_choice.h"
#include "capture/session/unit_profile.h"
#include "core/base/clock.h"
#include "core/color/element_color.h"
#include "core/line/line_source.h"
#include "core/reconstruct/live_picture.h"
#include "core/reconstruct/live_tile_sink.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

struct DevelopOptions {
  ToneCurves tone = ToneCurves::linear();
  ColorRecipe color;
  ViewGamut view_gamut = ViewGamut::kClip;
  // What is to look neutral; its factors multiply those of `color`. Costs a reconstruction more.
  std::optional<NeutralArea> neutral;
  SilverChoice silver;
  double white_level = 1.0, black_level = 0.0;
  UsedProfile profile;            // of the unit
  std::optional<double> blur_px;  // of the silver picture, instead of what is measured
  Quality quality = Quality::kStandard;
  std::optional<Demosaic> demosaic;            // absent: that of the quality
  std::optional<Deconvolution> deconvolution;  // absent: where it gains
  FrameChoice frame;
  int n_threads = 0;
  bool exact = false;
  std::filesystem::path exr, tiff, png;  // exr is required; empty view paths = none
  double dpi = 0;
  std::vector<std::pair<std::string, std::string>> attributes;  // of the EXR
  // Gets the provisional picture while lines arrive, in the colours of `color`; null: there is
  // none. Outlives the call.
  LiveTileSink* live = nullptr;
};

enum class DevelopPhase { kRegister, kReconstruct };
// Phase and fraction 0..1; from the developing thread.
using DevelopProgress = std::function<void(DevelopPhase, double)>;

struct Development {
  bool written = false;  // the picture is on disk
  // Why not, a sentence; empty when written.
  std::string why_not;
  bool stopped = false;  // because of a stop request
  Registration registration;
  // For scans of the same scanner and film without infrared; absent where there is none.
  std::optional<LearnedSilver> learned;
  Vector3 white_balance{1, 1, 1};  // factors on the elements that were used, a neutral included
  std::optional<ReconstructionReport> report;  // when written
  std::optional<PictureResult> picture;        // when written
  std::optional<LiveReport> live;              // of the provisional picture, where one was wanted
  // When all rows were made, whether or not the files were written.
  std::optional<TimePoint> rendered_at;
};

// Waits for lines as they are committed. Dark level and flat field of the profile are taken from
// samples that are linear in light. When the source ends before its last line, nothing is
// written: the caller opens what there is as a file and develops that. Throws what source, colour
// tables and writer throw; then no output file is left.
[[nodiscard]] Development develop(const LineSource& source, const DevelopOptions& options,
                                  const DevelopProgress& progress, const std::stop_token& stop);

}  // namespace reseau
