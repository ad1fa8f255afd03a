#include "core/color/tables.h"

namespace reseau {
namespace {

constexpr std::string_view kCornwellClyne1951 =
#include "core/color/data/cornwell_clyne_1951.text.inc"
    ;
constexpr std::string_view kHarrisonHorner1939 =
#include "core/color/data/harrison_horner_1939.text.inc"
    ;
constexpr std::string_view kCollinsGiles1952 =
#include "core/color/data/collins_giles_1952.text.inc"
    ;
constexpr std::string_view kNeblette1952 =
#include "core/color/data/neblette_1952.text.inc"
    ;
constexpr std::string_view kCornwellClyne1951ReadingB =
#include "core/color/data/cornwell_clyne_1951_reading_b.text.inc"
    ;
constexpr std::string_view kDufaycolorManual1938 =
#include "core/color/data/dufaycolor_manual_1938.text.inc"
    ;
constexpr std::string_view kChromaticitySets =
#include "core/color/data/chromaticity_sets.text.inc"
    ;
constexpr std::string_view kHarrisonHorner1939NarrowCut =
#include "core/color/data/harrison_horner_1939_narrow_cut.text.inc"
    ;
constexpr std::string_view kNeblette1952Separation =
#include "core/color/data/neblette_1952_separation.text.inc"
    ;
constexpr std::string_view kThamesMeesPledge1910 =
#include "core/color/data/thames_mees_pledge_1910.text.inc"
    ;
constexpr std::string_view kDioptichromeMeesPledge1910 =
#include "core/color/data/dioptichrome_mees_pledge_1910.text.inc"
    ;
constexpr std::string_view kAutochromeMeesPledge1910 =
#include "core/color/data/autochrome_mees_pledge_1910.text.inc"
    ;
constexpr std::string_view kAutochromeCiortan2025 =
#include "core/color/data/autochrome_ciortan_2025.text.inc"
    ;
constexpr std::string_view kCinecolorTrumpy2021 =
#include "core/color/data/cinecolor_trumpy_2021.text.inc"
    ;
constexpr std::string_view kWratten255847Kodak1945 =
#include "core/color/data/wratten_25_58_47_kodak_1945.text.inc"
    ;
constexpr std::string_view kAutochromeDyesCasellaTsukada2012 =
#include "core/color/data/autochrome_dyes_casella_tsukada_2012.text.inc"
    ;
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
constexpr AreaRow kAreas[] = {
#include "core/color/data/screen_areas.inc"
};
constexpr ConeRow kCones[] = {
#include "core/color/data/cone_matrices.inc"
};
constexpr DifferenceRow kPublishedDifferences[] = {
#include "core/color/data/published_differences.inc"
};
constexpr CropDifferenceRow kColorScreenDifferences[] = {
#include "core/color/data/color_screen_differences.inc"
};
constexpr RgbSpaceRow kRgbSpaces[] = {
#include "core/color/data/rgb_spaces.inc"
};

// The default stands first.
constexpr DataText kSets[] = {
    {"cornwell-clyne-1951", "Dufaycolor réseau", kCornwellClyne1951},
    {"harrison-horner-1939", "Dufaycolor réseau", kHarrisonHorner1939},
    {"collins-giles-1952", "Dufaycolor réseau", kCollinsGiles1952},
    {"neblette-1952", "Dufaycolor réseau", kNeblette1952},
    {"cornwell-clyne-1951-reading-b", "Dufaycolor réseau, the chart read otherwise",
     kCornwellClyne1951ReadingB},
    {"dufaycolor-manual-1938", "Dufaycolor réseau, scale uncertain", kDufaycolorManual1938},
    {"chromaticity sets", "printed x, y, Y", kChromaticitySets},
    {"harrison-horner-1939-narrow-cut", "printing filters for Dufaycolor",
     kHarrisonHorner1939NarrowCut},
    {"neblette-1952-separation", "separation filters for Dufaycolor", kNeblette1952Separation},
    {"thames-mees-pledge-1910", "Thames screen", kThamesMeesPledge1910},
    {"dioptichrome-mees-pledge-1910", "Dioptichrome screen", kDioptichromeMeesPledge1910},
    {"autochrome-mees-pledge-1910", "Autochrome screen", kAutochromeMeesPledge1910},
    {"autochrome-ciortan-2025", "Autochrome grains, unfaded", kAutochromeCiortan2025},
    {"cinecolor-trumpy-2021", "Cinecolor mosaic, aged", kCinecolorTrumpy2021},
    {"wratten-25-58-47-kodak-1945", "tricolour filters", kWratten255847Kodak1945},
};
constexpr DataText kDyes[] = {
    {"autochrome-dyes-casella-tsukada-2012", "single dyes of Autochrome",
     kAutochromeDyesCasellaTsukada2012},
};

}  // namespace

std::span<const DataText> set_texts() { return kSets; }
std::span<const DataText> dye_texts() { return kDyes; }
std::span<const ObserverRow> observer_table_1nm() { return kObserver1nm; }
std::span<const ObserverRow> observer_table_5nm() { return kObserver5nm; }
std::span<const IlluminantRow> illuminant_table() { return kIlluminants; }
std::span<const DaylightRow> daylight_table() { return kDaylight; }
std::span<const GeometryRow> dufaycolor_geometry() { return kDufaycolorGeometry; }
std::span<const AreaRow> area_table() { return kAreas; }
std::span<const ConeRow> cone_table() { return kCones; }
std::span<const RgbSpaceRow> rgb_space_table() { return kRgbSpaces; }
std::span<const DifferenceRow> published_differences() { return kPublishedDifferences; }
std::span<const CropDifferenceRow> color_screen_differences() { return kColorScreenDifferences; }

}  // namespace reseau
