#pragma once

#include <optional>

#include "core/color/colorimetry.h"

namespace reseau {

// Wavelength [nm] where the ray from `white` through `color` leaves the spectral locus, taken as
// straight segments between the wavelengths of the observer: 1 nm instead of 5 nm segments move a
// Dufaycolor element by up to 0.21 nm, so the grid belongs to the figure. Nothing for purples (the
// ray leaves through the line that joins the ends) and for the white itself. Pure, reentrant.
[[nodiscard]] std::optional<double> dominant_wavelength_nm(const Chromaticity& color,
                                                           const Chromaticity& white,
                                                           const Observer& observer);

// Whether some light has this colour: it lies within the spectral locus and the line that joins its
// ends, or outside by no more than `tolerance`. Pure, reentrant.
[[nodiscard]] bool is_color_of_light(const Chromaticity& color, const Observer& observer,
                                     double tolerance);

}  // namespace reseau
