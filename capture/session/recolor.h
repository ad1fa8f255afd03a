// New colours for a reconstruction that is there already: only the last 3x3 is done again.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "capture/color/neutral_area.h"
#include "capture/image/picture_writer.h"
#include "core/color/element_color.h"

namespace reseau {

struct RecolorOptions {
  std::filesystem::path source;  // an EXR that this program made, in any space
  ColorRecipe color;
  // What is to look neutral; its factors multiply those of `color`. Reads the picture once more.
  std::optional<NeutralArea> neutral;
  ViewGamut view_gamut = ViewGamut::kClip;
  int n_threads = 0;
  std::filesystem::path exr, tiff, png;  // exr is required; empty view paths = none
  double dpi = 0;
};

struct Recolored {
  bool written = false;  // false: stopped, nothing is left
  PictureResult picture;
  // What every pixel was multiplied by: new output from process x inverse of the one that the
  // source says it was made with.
  Matrix3 output_from_picture{};
  ColorRecipe color;  // as used: with the factors of a neutral
  // Reading runs beside the other two, so that the whole takes less than their sum.
  double seconds_reading = 0, seconds_color = 0, seconds_writing = 0, seconds = 0;
};

// `progress`: fraction 0..1. Throws InputError when the source is no EXR of ours (it must say the
// matrix its colours were made with) or a name is taken, std::system_error as the writer does.
[[nodiscard]] Recolored recolor(const RecolorOptions& options,
                                const std::function<void(double)>& progress,
                                const std::stop_token& stop);

}  // namespace reseau
