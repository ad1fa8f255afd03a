#include "capture/compare/sides.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/color/adaptation.h"

namespace reseau::compare {
namespace {

Illuminant illuminant_of(LabWhite white) {
  switch (white) {
    case LabWhite::kD50:
      return Illuminant::kD50;
    case LabWhite::kA:
      return Illuminant::kA;
    case LabWhite::kB:
      return Illuminant::kB;
    case LabWhite::kC:
      return Illuminant::kC;
    case LabWhite::kE:
      return Illuminant::kE;
    case LabWhite::kD65:
    case LabWhite::kOwn:
      break;
  }
  return Illuminant::kD65;
}

bool is_white(const Xyz& xyz) {
  return std::all_of(xyz.begin(), xyz.end(), [](double v) { return std::isfinite(v) && v > 0; });
}

Xyz own_white(const Picture& picture) {
  if (!is_white(picture.own_white())) {
    throw InputError(fmt::format("The white of '{}' is no colour; choose another --lab-white.",
                                 picture.header().path.string()));
  }
  return picture.own_white();
}

}  // namespace

std::string size_text(const PictureHeader& header) {
  return fmt::format("{} × {}", header.width_px, header.height_px);
}

Rect area_of(const PictureHeader& a, const PictureHeader& b, const CompareOptions& o) {
  const bool chosen = o.crop || o.offset_x_px != 0 || o.offset_y_px != 0;
  if (!chosen && (a.width_px != b.width_px || a.height_px != b.height_px)) {
    throw InputError(fmt::format(
        "'{}' has {} pixels and '{}' has {}. Only pictures of the same size can be compared; "
        "--crop and --offset choose a part that both have.",
        a.path.string(), size_text(a), b.path.string(), size_text(b)));
  }
  Rect area{0, 0, a.width_px, a.height_px};
  if (o.crop) {
    const Rect& c = *o.crop;
    if (c.x_px < 0 || c.y_px < 0 || c.width_px < 1 || c.height_px < 1 ||
        c.width_px > a.width_px - c.x_px || c.height_px > a.height_px - c.y_px) {
      throw InputError(fmt::format("The crop does not lie inside '{}', which has {} pixels.",
                                   a.path.string(), size_text(a)));
    }
    area = c;
  }
  const long long left = std::max<long long>(area.x_px, -static_cast<long long>(o.offset_x_px));
  const long long top = std::max<long long>(area.y_px, -static_cast<long long>(o.offset_y_px));
  const long long right = std::min<long long>(area.x_px + area.width_px,
                                              static_cast<long long>(b.width_px) - o.offset_x_px);
  const long long bottom = std::min<long long>(area.y_px + area.height_px,
                                               static_cast<long long>(b.height_px) - o.offset_y_px);
  const long long width = right - left - 2LL * o.border_px;
  const long long height = bottom - top - 2LL * o.border_px;
  if (width < 1 || height < 1) {
    throw InputError(
        "No pixel is left to compare; make the crop larger, or the border or the offset smaller.");
  }
  return {static_cast<int>(left) + o.border_px, static_cast<int>(top) + o.border_px,
          static_cast<int>(width), static_cast<int>(height)};
}

Side make_side(Picture& picture, const Rect& area, const CompareOptions& options) {
  Side side;
  side.picture = &picture;
  side.area = area;
  side.clamp = options.clamp_xyz;
  const Xyz d65 = white_of(Illuminant::kD65);
  if (options.adapt_own_white) {
    side.lab_xyz = bradford_target_from_source(own_white(picture), d65);
  }
  side.white = options.white == LabWhite::kOwn && !options.adapt_own_white
                   ? own_white(picture)
                   : white_of(illuminant_of(options.white));
  return side;
}

void adapt_to_lab_white(Side& side, LabWhite white) {
  if (white == LabWhite::kD65 || white == LabWhite::kOwn) return;
  side.lab_xyz = multiply(
      bradford_target_from_source(white_of(Illuminant::kD65), white_of(illuminant_of(white))),
      side.lab_xyz);
}

void fit_sides(const Side& a, Side& b, const CompareOptions& options, ColorFigures& color,
               const std::stop_token& stop) {
  if (options.fit == Fit::kNone) return;
  const FitSums sums = run_fit_pass(a, b, stop);
  if (stop.stop_requested()) return;
  if (options.fit == Fit::kGain) {
    if (!(sums.ab > 0) || !(sums.bb > 0)) {
      throw InputError("No gain fits: one of the pictures is black. Leave --fit out.");
    }
    color.gain = sums.ab / sums.bb;
    color.fit_matrix = scale(kIdentity3, color.gain);
  } else {
    if (!is_white(sums.mean_a) || !is_white(sums.mean_b)) {
      throw InputError(
          "No white fits: the mean of one of the pictures is no colour. Leave --fit out.");
    }
    color.fit_matrix = bradford_target_from_source(sums.mean_b, sums.mean_a);
    color.gain = sums.mean_a[1] / sums.mean_b[1];
  }
  b.lab_xyz = multiply(color.fit_matrix, b.lab_xyz);
}

}  // namespace reseau::compare
