// A picture by which a person sees at once whether a registration is right.
#pragma once

#include <filesystem>

#include "core/line/line_source.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

// PNG: nine windows from all over the scan (or the whole scan when it is small), magnified, and on
// every element a dot of its colour as the map places it: red dots on red elements, or it is
// wrong. Every window is as bright as its own light allows. Throws InputError when the name is
// taken, std::system_error when it cannot be written, and what the source throws.
void write_overlay(const LineSource& source, const ToneCurves& tone,
                   const Registration& registration, const std::filesystem::path& path);

}  // namespace reseau
