// How film and stage deviate from a plane lattice, drawn.
#pragma once

#include <string>

#include "core/line/line_format.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau {

// SVG text: the film's displacement as arrows over the frame, made longer by a factor that is
// stated, and below it the error of the stage along the motion, line by line. Pure.
[[nodiscard]] std::string registration_plot(const Registration& registration,
                                            const LineFormat& format);

}  // namespace reseau
