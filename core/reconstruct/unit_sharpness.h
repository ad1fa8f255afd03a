// What a unit's calibration says of its sharpness, as reconstruction needs it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/reconstruct/sharpness_field.h"

namespace reseau {

// Modulation transfer at a frequency [cycles/px of the scan] and its standard deviation.
struct TransferPoint {
  double f_cy_per_px = 0, value = 0, sd = 0;
  bool operator==(const TransferPoint&) const = default;
};

// How a channel's blur changes over the frame that was calibrated: Gaussian variance [px^2] on top
// of what all of it shares, a polynomial of 1, x, y, x^2, x y, y^2 that run from -1 to 1 over it.
struct UnitField {
  std::vector<double> coefficients;  // 1, 3 or 6
  std::vector<double> covariance;    // row by row
  std::array<int, 2> frame_px{};
};

// Curves of a unit in focus, R G B IR, frequencies growing; empty = not measured. Plain value.
struct UnitSharpness {
  std::array<std::vector<TransferPoint>, 4> transfer;
  std::array<std::optional<UnitField>, 4> field;  // nothing = the same all over the frame

  [[nodiscard]] bool empty() const {
    for (const auto& curve : transfer) {
      if (!curve.empty()) return false;
    }
    return true;
  }
};

// Where a réseau looks at it, a curve is a Gaussian and light that goes farther than a period:
// M(f) = (1 - far_share) exp(-2 pi^2 sigma^2 f^2). A scan shows the first by itself; the second
// fades colours as a paler scene would, so that only calibration can tell it.
struct UnitBlur {
  double sigma_px = 0, sd_px = 0;
  double far_share = 0;  // -0.1 to 0.5; a little below zero for an aperture with hard edges
};

// Fitted from the lowest to twice the highest of the réseau's two frequencies. Nothing when the
// curve does not reach that far, or is no curve of a blur. linear: screen from scan [periods/px].
[[nodiscard]] std::optional<UnitBlur> unit_blur(std::span<const TransferPoint> curve,
                                                const Mat2& linear);

// That blur, on the average over the frame, with the change of `field`. Nothing where the scan has
// another size than the frame that was calibrated (by more than 2 %): nobody knows which part it
// is.
[[nodiscard]] std::optional<BlurSurface> unit_surface(const UnitBlur& blur, const UnitField& field,
                                                      Vec2 frame_px);

}  // namespace reseau
