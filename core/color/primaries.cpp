#include "core/color/primaries.h"

namespace reseau {
namespace {

Viewing under(Illuminant light) {
  Viewing viewing;
  viewing.light = light_of(light);
  return viewing;
}

}  // namespace

Matrix3 element_primaries(std::string_view name, Illuminant light) {
  return element_xyz(find_primary_set(name), under(light));
}

Matrix3 element_primaries_as_stated(std::string_view name, Illuminant light) {
  return element_xyz_as_stated(find_primary_set(name), under(light));
}

Vector3 dufaycolor_areas() { return screen_areas().front().share; }

}  // namespace reseau
