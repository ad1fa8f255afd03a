// Everything that depends on how sharp the silver is, for one or several degrees of blur.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/blurred_cell.h"
#include "core/reconstruct/deconvolution.h"
#include "core/reconstruct/kernel_tables.h"
#include "core/screen/screen_pattern.h"

namespace reseau {

struct BlurLevel {
  double sigma_px;
  std::optional<SharpeningKernel> sharpening;  // of the silver, before all else
  BlurredCell cell;
  ElementKernels elements;
  std::optional<DetailKernels> detail;
};

struct BlurLevelSettings {
  Mat2 screen_from_scan;  // [periods/px]
  double noise_sd = 0;    // of a pixel's silver over the light there
  double least_sigma_px = 0, most_sigma_px = 0;
  BlurShape shape;
  double ratio = 1.08;  // between neighbouring levels at most
  bool detail = false;
  Vec2 detail_offset_px;
  double line_alternation_sd = 0;  // as EstimatorSettings
  int line_color = 0;
  Deconvolution deconvolution = Deconvolution::kNone;
};

// Immutable, thread-safe.
class BlurLevels {
 public:
  BlurLevels(const ScreenPattern& pattern, const BlurLevelSettings& settings);

  [[nodiscard]] const std::vector<BlurLevel>& levels() const { return levels_; }
  [[nodiscard]] const std::vector<ElementSite>& sites() const { return sites_; }
  // Index of the first site of each colour.
  [[nodiscard]] const std::array<std::size_t, 3>& first_site() const { return first_site_; }

  // Between two levels.
  struct Place {
    std::size_t index = 0;
    float toward_next = 0;  // 0..1
  };
  [[nodiscard]] Place place(double sigma_px) const;

 private:
  std::vector<ElementSite> sites_;
  std::array<std::size_t, 3> first_site_{};
  std::vector<BlurLevel> levels_;
};

}  // namespace reseau
