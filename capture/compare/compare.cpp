#include "capture/compare/compare.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "capture/compare/color_pass.h"
#include "capture/compare/pairing.h"
#include "capture/compare/parts.h"
#include "capture/compare/sides.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

constexpr int kRasterSide = 1200;
// What is worth a sentence.
constexpr double kShiftWorthWarningPx = 0.1;
constexpr double kSlipsWorthWarning = 0.001;     // of the pixels
constexpr double kGradientsWorthWarning = 0.02;  // relative

// Returns false when stopped.
bool compare_colors(Picture& a, Picture& b, const CompareOptions& options, Comparison& result,
                    const std::stop_token& stop) {
  Side side_a = make_side(a, result.area, options);
  Rect area_b = result.area;
  area_b.x_px += options.offset_x_px;
  area_b.y_px += options.offset_y_px;
  Side side_b = make_side(b, area_b, options);
  ColorFigures color;
  fit_sides(side_a, side_b, options, color, stop);
  adapt_to_lab_white(side_a, options.white);
  adapt_to_lab_white(side_b, options.white);
  result.lab_white_a = side_a.white;
  result.lab_white_b = side_b.white;
  ColorPass pass = run_color_pass(side_a, side_b, stop);
  if (pass.stopped || stop.stop_requested()) return false;
  result.raster = raster_of(pass.delta_e, result.area.width_px, result.area.height_px, kRasterSide);
  color.n_not_finite = pass.n_not_finite;
  result.max_abs = pass.max_abs;
  const auto end = std::remove_if(pass.delta_e.begin(), pass.delta_e.end(),
                                  [](float v) { return !std::isfinite(v); });
  pass.delta_e.erase(end, pass.delta_e.end());
  if (pass.delta_e.empty()) {
    throw InputError("No pixel is finite in both pictures; there is nothing to compare.");
  }
  color.all = figures_of(pass.delta_e, 0);
  color.without_worst_percent = figures_of(pass.delta_e, 0.01);
  color.trimmed = figures_of(pass.delta_e, options.worst_fraction);
  color.bias = bias_of(pass.blocks);
  result.identical = pass.same_samples && color.all.max == 0;
  result.color = color;

  const NoiseFigures noise = noise_of(pass.blocks);
  if (noise.n_blocks > 0) {
    result.noise = noise;
  } else {
    result.no_noise = "A has no square of 16 × 16 pixels between black and white.";
  }
  const ShiftFigures shift = shift_of(pass.blocks);
  if (shift.measured) {
    result.shift = shift;
  } else {
    result.no_shift = "A has too little detail in both directions to tell a shift.";
  }
  compare_resolution(side_a, side_b, pass, options, result);
  return true;
}

void warn(Comparison& result) {
  const auto add = [&result](std::string sentence) {
    result.warnings.push_back(std::move(sentence));
  };
  if (result.color && result.color->n_not_finite > 0) {
    add(fmt::format(
        "{} pixels are not finite (or transparent) in one of the pictures and were left "
        "out.",
        result.color->n_not_finite));
  }
  if (result.registration) {
    const MapError& r = *result.registration;
    if (r.equivalence.swapped) {
      add("The axes of the two maps are exchanged: u of A is v of B. Unless the screen looks the "
          "same "
          "that way, red lines are taken for the other direction.");
    }
    if (r.equivalence.gradient_mismatch > kGradientsWorthWarning) {
      add(
          fmt::format("The two maps do not describe the same lattice: their gradients differ by "
                      "{:.1f} %.",
                      100 * r.equivalence.gradient_mismatch));
    }
    if (static_cast<double>(r.n_slipped) > kSlipsWorthWarning * static_cast<double>(r.n)) {
      add(fmt::format("At {} pixels one of the maps is a whole period off against the rest.",
                      r.n_slipped));
    }
    if (r.rms_px > kShiftWorthWarningPx) {
      add(fmt::format("The registration differs by {:.2f} px rms.", r.rms_px));
    }
  }
  if (result.shift) {
    const ShiftFigures& s = *result.shift;
    const double length = std::hypot(s.x_px, s.y_px);
    if (length > kShiftWorthWarningPx && length > 4 * std::hypot(s.sd_x_px, s.sd_y_px)) {
      add(fmt::format("B seems displaced against A by {:+.2f}, {:+.2f} px (x, y).", s.x_px,
                      s.y_px));
    }
  }
}

}  // namespace

std::optional<Comparison> compare_files(const std::filesystem::path& a,
                                        const std::filesystem::path& b,
                                        const CompareOptions& options,
                                        const std::stop_token& stop) {
  CHECK(options.border_px >= 0 && options.worst_fraction >= 0 && options.worst_fraction < 1);
  Comparison result;
  result.a = read_picture_header(a);
  result.b = read_picture_header(b);
  result.area = area_of(result.a, result.b, options);
  const Pairing pairing = pair_pictures(result.a, result.b, options);
  const bool color = result.a.has_color && result.b.has_color;
  {
    const auto picture_a = open_picture(result.a, pairing.a);
    const auto picture_b = open_picture(result.b, pairing.b);
    result.encoding_a = picture_a->encoding();
    result.encoding_b = picture_b->encoding();
    result.notes_a = picture_a->notes();
    result.notes_b = picture_b->notes();
    if (color) {
      result.pairing = pairing.sentence;
      result.process_rgb = pairing.process_rgb;
      if (!compare_colors(*picture_a, *picture_b, options, result, stop)) return std::nullopt;
    } else {
      const char* which =
          result.a.has_color ? "B has" : (result.b.has_color ? "A has" : "Neither has");
      result.no_color = fmt::format("{} colours.", result.a.has_color || result.b.has_color
                                                       ? std::string(which) + " no"
                                                       : std::string(which));
      result.no_resolution = result.no_noise = result.no_shift = result.no_color;
    }
  }
  if (stop.stop_requested()) return std::nullopt;
  compare_registration(options, result);
  if (!result.color && !result.registration) {
    throw InputError(
        fmt::format("There is nothing to compare. {} {}", result.no_color, result.no_registration));
  }
  warn(result);
  return result;
}

}  // namespace reseau::compare
