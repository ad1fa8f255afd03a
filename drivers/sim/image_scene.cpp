#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"
#include "drivers/sim/scene.h"

namespace reseau::sim {
namespace {

// Integral of the linear interpolation of unit-spaced samples: weights of samples first … in the
// mean over [a, b], in raster pixels, samples at integers, the ends continued.
struct MeanWeights {
  std::ptrdiff_t first = 0;
  std::vector<double> weights;

  MeanWeights(double a, double b) {
    first = static_cast<std::ptrdiff_t>(std::floor(a));
    const auto last = static_cast<std::ptrdiff_t>(std::floor(b)) + 1;
    weights.assign(static_cast<std::size_t>(last - first + 1), 0.0);
    const double length = b - a;
    for (std::ptrdiff_t j = first; j < last; ++j) {
      const auto left = static_cast<double>(j);
      const double from = std::max(a, left) - left, to = std::min(b, left + 1) - left;
      if (to <= from) continue;
      // Over [from, to] the left sample weighs 1 - t, the right one t.
      const double right = (to * to - from * from) / 2;
      weights[static_cast<std::size_t>(j - first)] += (to - from - right) / length;
      weights[static_cast<std::size_t>(j - first) + 1] += right / length;
    }
  }
};

class ImageScene final : public Scene {
 public:
  ImageScene(std::shared_ptr<const SceneRaster> raster, double width_px, double height_px)
      : raster_(std::move(raster)) {
    const double w = raster_->width_px, h = raster_->height_px;
    scale_ = std::min(w / width_px, h / height_px);
    // Places of pixel centres: the picture's middle on the raster's middle.
    shift_x_ = (w - 1) / 2 - scale_ * (width_px - 1) / 2;
    shift_y_ = (h - 1) / 2 - scale_ * (height_px - 1) / 2;
  }

  void row(double y, double x0, const RgbRow& out) const override { cells(y, x0, 1.0, out); }
  [[nodiscard]] bool has_fine_detail() const override { return true; }
  [[nodiscard]] double finest_cy_per_px(double /*y*/, double /*x0*/, double /*x1*/) const override {
    return scale_ / 2;  // two pixels of the raster
  }

  void cells(double y, double x0, double side_px, const RgbRow& out) const override {
    const double half = scale_ * side_px / 2;
    const double centre_y = shift_y_ + scale_ * y;
    const MeanWeights down(centre_y - half, centre_y + half);
    const std::array<std::span<float>, 3> bands{out.r, out.g, out.b};

    // Columns of the raster that the row needs, the vertical mean taken, then their integral from
    // the first of them on.
    thread_local std::vector<double> column, integral;
    const double begin = shift_x_ + scale_ * x0 - half;
    const double end = begin + scale_ * side_px * static_cast<double>(out.r.size());
    const auto first = static_cast<std::ptrdiff_t>(std::floor(begin)) - 1;
    const auto n = static_cast<std::size_t>(std::floor(end) - static_cast<double>(first)) + 3;
    for (std::size_t k = 0; k < 3; ++k) {
      column.assign(n, 0.0);
      for (std::size_t j = 0; j < down.weights.size(); ++j) {
        add_raster_row(down.first + static_cast<std::ptrdiff_t>(j), k, down.weights[j], first,
                       column);
      }
      integral.assign(n, 0.0);
      for (std::size_t i = 1; i < n; ++i) {
        integral[i] = integral[i - 1] + (column[i - 1] + column[i]) / 2;
      }
      const auto until = [&](double x) {  // integral of the interpolation from `first` to x
        const double t = x - static_cast<double>(first);
        const auto i = static_cast<std::size_t>(t);
        const double f = t - static_cast<double>(i);
        return integral[i] + f * (column[i] + f * (column[i + 1] - column[i]) / 2);
      };
      double before = until(begin);
      for (std::size_t i = 0; i < out.r.size(); ++i) {
        const double here = until(begin + scale_ * side_px * static_cast<double>(i + 1));
        bands[k][i] = static_cast<float>((here - before) / (scale_ * side_px));
        before = here;
      }
    }
  }

 private:
  void add_raster_row(std::ptrdiff_t y, std::size_t k, double weight, std::ptrdiff_t first,
                      std::span<double> column) const {
    if (weight == 0) return;
    const std::ptrdiff_t width = raster_->width_px;
    const std::ptrdiff_t at = std::clamp<std::ptrdiff_t>(y, 0, raster_->height_px - 1) * width;
    for (std::size_t i = 0; i < column.size(); ++i) {
      const std::ptrdiff_t x =
          std::clamp<std::ptrdiff_t>(first + static_cast<std::ptrdiff_t>(i), 0, width - 1);
      column[i] +=
          weight * static_cast<double>(raster_->rgb[static_cast<std::size_t>(3 * (at + x)) + k]);
    }
  }

  std::shared_ptr<const SceneRaster> raster_;
  double scale_, shift_x_, shift_y_;  // raster pixel = shift + scale * picture pixel
};

}  // namespace

std::unique_ptr<Scene> make_image_scene(std::shared_ptr<const SceneRaster> raster, double width_px,
                                        double height_px) {
  if (raster == nullptr || raster->width_px < 1 || raster->height_px < 1 ||
      raster->rgb.size() != 3 * static_cast<std::size_t>(raster->width_px) *
                                static_cast<std::size_t>(raster->height_px)) {
    throw InputError(
        "The simulated film needs a picture for scene=image; name its file with image=FILE, or "
        "give red, green and blue of at least one pixel.");
  }
  for (const float v : raster->rgb) {
    if (!std::isfinite(v) || v < 0) {
      throw InputError(
          "The picture for the simulated film holds values that are no exposures (negative, "
          "infinite or not a number); give a picture in linear light from 0 to 1.");
    }
  }
  return std::make_unique<ImageScene>(std::move(raster), width_px, height_px);
}

}  // namespace reseau::sim
