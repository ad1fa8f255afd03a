// Pictures of the caller's as scenes, read by OpenImageIO.
#pragma once

#include <string>

#include "drivers/sim/scene.h"

namespace reseau::sim {

// Any picture that OpenImageIO reads, as linear light: samples that say they are sRGB (8 and 16
// bits unless they say otherwise) are decoded, one channel counts for all three, what is below 0 is
// 0. An orientation that the file asks for is obeyed. Throws InputError for what cannot be read.
//
// OpenImageIO brings 260 libraries (0.6 s and 130 MB per start of the program), so it sits in a
// module of its own, lib/reseau/reseau_pictures.so, which is opened when a picture is asked for.
[[nodiscard]] SceneRaster read_scene_picture(const std::string& path);

}  // namespace reseau::sim
