// How the straight edges of a film lie to the grid of the scan.
#pragma once

#include "drivers/sim/film.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// Smallest angle between a straight, sharp edge (of elements, of scene=edges) and an axis of the
// scan [degree]; kNoEdgesDeg for a film without such edges. Deformation is left out.
[[nodiscard]] double edges_off_axes_deg(const FilmSpec& spec);

}  // namespace reseau::sim
