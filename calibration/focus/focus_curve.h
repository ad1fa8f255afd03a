// Best focus and depth of field from the modulation of one edge at several focus settings. Pure,
// reentrant.
//
// ln M is even about best focus: a parabola for a blur that grows in quadrature and near the focus
// of any lens, with a fourth power where the settings reach farther and ask for it.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/profile/measured.h"

namespace reseau {

struct FocusPoint {
  double position = 0;  // in steps of the unit
  double modulation = 0, sd = 0;
};

struct FocusFit {
  bool ok = false;
  std::string why;  // a sentence, when not ok

  Measured best;  // position
  Measured peak;  // modulation there
  // How far from best the modulation is kDepthShare of its peak; absent where the settings do not
  // reach so far.
  std::optional<Measured> half_depth;
  double chi2_per_freedom = 0;
  int n_points = 0;                                // that were used
  double slope2 = 0, slope4 = 0;                   // ln M = ln peak - slope2 u^2 - slope4 u^4
  [[nodiscard]] double at(double position) const;  // modulation of the model
};

inline constexpr double kDepthShare = 0.8;

// Three settings or more, with the best one among those inside. Points without modulation (0 or
// less) and those below a third of the best are left out.
[[nodiscard]] FocusFit fit_focus(std::span<const FocusPoint> points);

}  // namespace reseau
