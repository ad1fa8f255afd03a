// How two pictures are brought to one colour space.
#pragma once

#include <string>

#include "capture/compare/compare.h"

namespace reseau::compare {

struct Pairing {
  PictureChoice a, b;
  std::string sentence;
  bool process_rgb = false;
};

// A truth holds element intensities and says nothing of primaries: it is seen through those of the
// result beside it, so that the difference is that of the reconstruction. A result that names no
// primaries (another program's) is held against what the camera saw, where the truth has it. Two
// results keep the colours that each declares. Throws InputError when a layer is asked for that is
// not there.
[[nodiscard]] Pairing pair_pictures(const PictureHeader& a, const PictureHeader& b,
                                    const CompareOptions& options);

}  // namespace reseau::compare
