// The layout of a film's réseau: the common description of its kind in the sizes of the film.
#pragma once

#include "core/screen/screen_description.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

[[nodiscard]] inline ScreenDescription describe_screen(const ScreenSpec& spec) {
  return reseau::describe_screen(spec.kind, {.period_um = {spec.period_u_um, spec.period_v_um},
                                             .axes_deg = spec.axes_deg,
                                             .line_width = spec.red_fraction,
                                             .first_length = spec.green_fraction});
}

// Sets the kind with its usual periods and fractions.
inline void set_screen_kind(ScreenSpec& screen, ScreenKind kind) {
  const ScreenSizes sizes = usual_sizes(kind);
  screen.kind = kind;
  screen.period_u_um = sizes.period_um.x;
  screen.period_v_um = sizes.period_um.y;
  screen.axes_deg = sizes.axes_deg;
  if (sizes.line_width == 0) return;
  screen.red_fraction = sizes.line_width;
  screen.green_fraction = sizes.first_length;
}

}  // namespace reseau::sim
