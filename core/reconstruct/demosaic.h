// How three interleaved lattices of elements become one picture.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace reseau {

// draft, standard, best: from coarse and fast to fine and slow. Each stands for a way to demosaic.
enum class Quality { kDraft, kStandard, kBest };
// "draft", "standard" or "best"; InputError for anything else.
[[nodiscard]] Quality parse_quality(std::string_view name);

// Elements are collected, and their loss of saturation is undone, the same way in all of them.
// nearest: the element at the pixel or nearest to it. bilinear, bicubic: between elements. ratio:
// bicubic, then brighter or darker as the silver is than that picture would make it. joint: what
// the silver holds beyond the bicubic picture goes through the inverse of réseau and blur.
enum class Demosaic { kNearest, kBilinear, kBicubic, kRatio, kJoint };
inline constexpr std::array kDemosaics{Demosaic::kNearest, Demosaic::kBilinear, Demosaic::kBicubic,
                                       Demosaic::kRatio, Demosaic::kJoint};
[[nodiscard]] std::string_view demosaic_name(Demosaic demosaic);
// By that name; InputError for anything else.
[[nodiscard]] Demosaic parse_demosaic(std::string_view name);
// Of a quality where none was chosen.
[[nodiscard]] Demosaic demosaic_of(Quality quality, std::optional<Demosaic> chosen);

}  // namespace reseau
