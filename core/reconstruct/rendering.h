// What all pixels of a picture are made with: how sharp the scan is and the tables that follow from
// it. Include from .cpp files of this folder only.
#pragma once

#include <array>
#include <optional>
#include <stop_token>

#include "core/geometry/vec2.h"
#include "core/line/line_source.h"
#include "core/reconstruct/blur_levels.h"
#include "core/reconstruct/demosaic.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/sharpness_field.h"
#include "core/reconstruct/silver_rows.h"
#include "core/reconstruct/silver_sharpener.h"
#include "core/reconstruct/tile_renderer.h"
#include "core/screen/screen_map.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

// Made from the lines that are committed, which is all of them for a final picture. Immutable,
// thread-safe. Renderers and settings borrow from it.
class Rendering {
 public:
  // Measures the sharpness, makes the tables and says in `report` what was found and skipped.
  // Options must outlive it. Throws InputError for options and screens of which no picture can be
  // made. After a stop request it is of no use.
  Rendering(const LineSource& source, const Registration& registration,
            const ReconstructOptions& options, ReconstructionReport& report,
            const std::stop_token& stop);
  ~Rendering() = default;
  Rendering(const Rendering&) = delete;
  Rendering& operator=(const Rendering&) = delete;
  Rendering(Rendering&&) = delete;
  Rendering& operator=(Rendering&&) = delete;

  // The map must outlive the renderer.
  [[nodiscard]] TileRenderer renderer(const ScreenMap& map) const;
  // Of the lines that `source` has, as far around as the renderer needs it.
  [[nodiscard]] SilverSettings silver(const LineSource& source, const TileRenderer& renderer) const;

 private:
  const ReconstructOptions& options_;
  bool infrared_;
  std::array<double, 3> silver_from_rgb_{};
  double offset_ = 0;  // of the silver
  std::array<Vec2, 2> period_px_{};
  std::optional<ScreenPattern> pattern_;
  BlurSurface blur_;
  Vec2 shift_px_;  // of the silver
  Demosaic demosaic_;
  double noise_sd_ = 0, blank_noise_sd_ = 0;
  std::optional<BlurLevels> levels_;
  std::optional<SilverSharpener> sharpener_;
};

}  // namespace reseau
