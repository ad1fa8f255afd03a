// Finds the slanted edge of two flat areas that tells most about resolution.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "capture/compare/block_stats.h"
#include "capture/compare/compare.h"

namespace reseau::compare {

// XYZ to one signal along the direction in which the region varies most: the two colours of an edge
// become two levels. Only directions in linear light are used, so the profile stays that of light.
// Nothing for a region of one colour.
class EdgeSignal {
 public:
  [[nodiscard]] static std::optional<EdgeSignal> of(std::span<const float> xyz);
  // [pixel]; NaN where the colour is not finite.
  [[nodiscard]] std::vector<double> apply(std::span<const float> xyz) const;

 private:
  Vector3 mean_{}, direction_{};
};

struct FoundEdge {
  Rect area;  // within the compared area
  EdgeMtf mtf;
};

// `blocks` of the reference, row by row, `across` in a row; `read` gives XYZ of a part of the
// compared area. The edge of highest contrast times root of its length over its residual, among the
// most promising places at three sizes. Nothing when no place holds a usable edge.
[[nodiscard]] std::optional<FoundEdge> find_edge(
    std::span<const Block> blocks, int across,
    const std::function<std::vector<float>(const Rect&)>& read);

}  // namespace reseau::compare
