#pragma once

#include <memory>

#include "drivers/sim/film.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// The film of the spec, by the fast path where that renders it. Throws InputError for a scene that
// cannot be used.
[[nodiscard]] std::unique_ptr<Film> make_film(const FilmSpec& spec);

}  // namespace reseau::sim
