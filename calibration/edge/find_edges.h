// Slanted edges anywhere in a picture.
#pragma once

#include <vector>

#include "core/base/span2d.h"

namespace reseau {

struct EdgePlace {
  int x = 0, y = 0, width = 0, height = 0;
  double merit = 0;  // contrast over what two flat halves do not explain, times root of the length
};

// Regions that look like one edge between two flat areas, the most promising first, at most
// `n_most`, not overlapping. A small picture is one region itself.
[[nodiscard]] std::vector<EdgePlace> find_edges(Span2D<const float> samples, int n_most);

}  // namespace reseau
