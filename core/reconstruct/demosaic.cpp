#include "core/reconstruct/demosaic.h"

#include <string>

#include "core/base/error.h"

namespace reseau {

Quality parse_quality(std::string_view name) {
  if (name == "draft") return Quality::kDraft;
  if (name == "standard") return Quality::kStandard;
  if (name == "best") return Quality::kBest;
  throw InputError("The quality is draft, standard or best, not '" + std::string(name) + "'.");
}

std::string_view demosaic_name(Demosaic demosaic) {
  constexpr std::array<std::string_view, kDemosaics.size()> kNames{"nearest", "bilinear", "bicubic",
                                                                   "ratio", "joint"};
  return kNames[static_cast<std::size_t>(demosaic)];
}

Demosaic parse_demosaic(std::string_view name) {
  for (const Demosaic demosaic : kDemosaics) {
    if (demosaic_name(demosaic) == name) return demosaic;
  }
  throw InputError("A demosaic is nearest, bilinear, bicubic, ratio or joint, not '" +
                   std::string(name) + "'.");
}

Demosaic demosaic_of(Quality quality, std::optional<Demosaic> chosen) {
  if (chosen) return *chosen;
  switch (quality) {
    case Quality::kDraft:
      return Demosaic::kBilinear;
    case Quality::kBest:
      return Demosaic::kJoint;
    case Quality::kStandard:
      break;
  }
  return Demosaic::kBicubic;
}

}  // namespace reseau
