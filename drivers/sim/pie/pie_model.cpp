#include "drivers/sim/pie/pie_model.h"

namespace reseau::sim::pie {
namespace {

constexpr std::array<std::uint16_t, 4> kSaneExposure{2937, 2937, 2937, 2937};
constexpr std::array<std::uint8_t, 4> kSaneGain{19, 19, 19, 19};

constexpr PieModel desktop(std::string_view name, int number, std::string_view product, int dpi,
                           int width_px, int height_px, int sensor_px, int filter_offset) {
  return {name,  number, 0x0145, product, dpi,   width_px, height_px, sensor_px,     filter_offset,
          false, false,  false,  false,   false, false,    1.0,       kSaneExposure, kSaneGain};
}

constexpr PieModel magazine(std::string_view name, int number, std::string_view product, int dpi,
                            int width_px, int height_px, int sensor_px, int filter_offset) {
  PieModel model =
      desktop(name, number, product, dpi, width_px, height_px, sensor_px, filter_offset);
  model.product_id = 0x0142;
  model.has_transport = true;
  model.confirms_frame = true;
  return model;
}

constexpr std::array kPieModels = {
    desktop("crystalscan7200", 0x30, "MF Scanner", 7200, 6660, 10206, 6685, 8),
    desktop("proscan7200", 0x36, "MF Scanner", 7200, 6660, 10206, 6685, 8),
    desktop("proscan10t", 0x47, "MF Scanner", 10000, 9240, 14170, 9300, 12),
    desktop("crystalscan3600", 0x2e, "MF Scanner", 3600, 5172, 3444, 5340, 4),
    magazine("digitdia6000", 0x3a, "MF Scanner", 5000, 7180, 4780, 7400, 6),
    magazine("digitdia5000", 0x2f, "MF Scanner", 3600, 5172, 3444, 5340, 4),
    PieModel{"rps7200",
             0x31,
             0x0144,
             "MF Scanner",
             7200,
             10344,
             6888,
             5172,
             0,
             true,
             true,
             true,
             true,
             true,
             true,
             5.0,
             {9604, 6506, 6506, 7745},
             {0, 0, 0, 0}},
};

}  // namespace

const PieModel* find_pie_model(std::string_view name) {
  for (const PieModel& model : kPieModels) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

std::vector<std::string> pie_model_names() {
  std::vector<std::string> names;
  names.reserve(std::size(kPieModels));
  for (const PieModel& model : kPieModels) names.emplace_back(model.name);
  return names;
}

void set_pie_defaults(const PieModel& model, SimSpec& spec) {
  const double pixel_um = 25400.0 / model.max_dpi;
  // The same spot of light on the film as the other units have.
  const double finer = spec.film.frame.pixel_um / pixel_um;
  for (double& blur_px : spec.optics.blur_px) blur_px *= finer;
  spec.optics.pixel_um = pixel_um;
  spec.film.frame.pixel_um = pixel_um;
  spec.film.frame.width_px = model.width_px;
  spec.film.frame.height_px = model.height_px;
  // Calibration lines lie near 170 and 47000.
  constexpr double kDark = 170.0 / 65535, kLight = 47000.0 / 65535;
  spec.sensor.clear_level = kLight - kDark;
  spec.sensor.dark_level = kDark;
  spec.sensor.dark_pattern = 20.0 / 65535;
  spec.sensor.pixel_gain = 0.02;
  spec.sensor.shading = 0.15;
}

}  // namespace reseau::sim::pie
