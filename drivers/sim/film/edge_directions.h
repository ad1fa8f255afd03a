// How the edges of a film lie to the grid of the scan.
#pragma once

#include "drivers/sim/film.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// Of the sharp edges of elements and of scene=edges. Deformation is left out.
[[nodiscard]] Film::Edges edges_of(const FilmSpec& spec);

}  // namespace reseau::sim
