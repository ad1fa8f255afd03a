#include "core/color/tables.h"

namespace reseau {
namespace {

constexpr SpectrumRow kHarrisonHorner1939[] = {
#include "core/color/data/harrison_horner_1939.inc"
};
constexpr SpectrumRow kCornwellClyne1951[] = {
#include "core/color/data/cornwell_clyne_1951.inc"
};
constexpr SpectrumRow kCollinsGiles1952[] = {
#include "core/color/data/collins_giles_1952.inc"
};
constexpr SpectrumRow kNeblette1952[] = {
#include "core/color/data/neblette_1952.inc"
};
constexpr ChromaticityRow kChromaticitySets[] = {
#include "core/color/data/chromaticity_sets.inc"
};
constexpr ObserverRow kObserver1nm[] = {
#include "core/color/data/cie_1931_observer_1nm.inc"
};
constexpr ObserverRow kObserver5nm[] = {
#include "core/color/data/cie_1931_observer_5nm.inc"
};
constexpr IlluminantRow kIlluminants[] = {
#include "core/color/data/cie_illuminants_5nm.inc"
};
constexpr DaylightRow kDaylight[] = {
#include "core/color/data/cie_daylight_components_10nm.inc"
};
constexpr GeometryRow kDufaycolorGeometry[] = {
#include "core/color/data/dufaycolor_geometry.inc"
};

// The default stands first.
constexpr SpectrumTable kSpectra[] = {
    {"cornwell-clyne-1951", "Cornwell-Clyne 1951, p. 149", kCornwellClyne1951},
    {"harrison-horner-1939", "Harrison and Horner 1939, p. 325", kHarrisonHorner1939},
    {"collins-giles-1952", "Collins and Giles 1952, p. 435", kCollinsGiles1952},
    {"neblette-1952", "Neblette 1952, p. 446", kNeblette1952},
};

}  // namespace

std::span<const SpectrumTable> spectrum_tables() { return kSpectra; }
std::span<const ChromaticityRow> chromaticity_table() { return kChromaticitySets; }
std::span<const ObserverRow> observer_table_1nm() { return kObserver1nm; }
std::span<const ObserverRow> observer_table_5nm() { return kObserver5nm; }
std::span<const IlluminantRow> illuminant_table() { return kIlluminants; }
std::span<const DaylightRow> daylight_table() { return kDaylight; }
std::span<const GeometryRow> dufaycolor_geometry() { return kDufaycolorGeometry; }

}  // namespace reseau
