// A reconstruction that exists, in other colours: `reseau colour apply`, and `reseau reconstruct`
// of an EXR.
#pragma once

#include <optional>
#include <string>

#include "capture/cli/program.h"
#include "capture/color/neutral_area.h"
#include "capture/image/view_encoding.h"
#include "core/color/element_color.h"

namespace reseau::cli {

struct RecolorRequest {
  std::string verb;
  std::string file;    // the EXR
  std::string output;  // folder
  ColorRecipe color;
  std::optional<NeutralArea> neutral;
  ViewGamut view_gamut = ViewGamut::kClip;
  int n_threads = 0;
  bool view = true;
};

// Writes NAME.exr, NAME.json and the view copies. Failure kExitOutput when a name is taken.
[[nodiscard]] ExitCode run_recolor(const RecolorRequest& request, Work& work);

// True for a file that begins as OpenEXR files do.
[[nodiscard]] bool is_exr(const std::string& file);

}  // namespace reseau::cli
