#include <algorithm>
#include <cmath>
#include <cstddef>

#include "drivers/sim/hash.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/smooth_step.h"
#include "drivers/sim/spline_noise.h"

namespace reseau::sim {
namespace {

struct Colour {
  float r, g, b;
};

Colour blend(Colour a, Colour b, float w) {
  return {a.r + w * (b.r - a.r), a.g + w * (b.g - a.g), a.b + w * (b.b - a.b)};
}
Colour scaled(Colour a, float s) { return {a.r * s, a.g * s, a.b * s}; }

// A soft-edged, shaded ellipse; positions and radii as fractions of the picture.
struct Blob {
  float x, y, rx, ry;
  Colour colour;
};

constexpr std::array<Blob, 9> kBlobs{{
    {0.30F, 0.70F, 0.090F, 0.130F, {0.62F, 0.05F, 0.06F}},  // red dress
    {0.30F, 0.54F, 0.045F, 0.042F, {0.66F, 0.40F, 0.29F}},  // face
    {0.24F, 0.79F, 0.018F, 0.020F, {0.60F, 0.36F, 0.26F}},  // hand
    {0.56F, 0.71F, 0.080F, 0.120F, {0.06F, 0.10F, 0.42F}},  // blue coat
    {0.56F, 0.56F, 0.042F, 0.040F, {0.36F, 0.19F, 0.12F}},  // darker face
    {0.80F, 0.72F, 0.075F, 0.110F, {0.86F, 0.84F, 0.78F}},  // white shirt
    {0.80F, 0.58F, 0.040F, 0.040F, {0.72F, 0.48F, 0.37F}},  // fair face
    {0.14F, 0.86F, 0.050F, 0.030F, {0.90F, 0.70F, 0.04F}},  // yellow flowers
    {0.68F, 0.89F, 0.045F, 0.025F, {0.52F, 0.08F, 0.40F}},  // purple flowers
}};

constexpr Colour kZenith{0.12F, 0.26F, 0.62F}, kHaze{0.58F, 0.68F, 0.80F};
constexpr Colour kCloud{0.95F, 0.94F, 0.92F}, kFoliage{0.10F, 0.20F, 0.05F};
constexpr Colour kLawn{0.30F, 0.42F, 0.12F}, kWood{0.34F, 0.22F, 0.13F};
constexpr double kFencePeriodPx = 64;

class NaturalScene final : public Scene {
 public:
  NaturalScene(double width_px, double height_px, std::uint64_t seed)
      : w_(width_px),
        h_(height_px),
        cloud_large_(mix64(seed, 1), 0.16 * width_px),
        cloud_small_(mix64(seed, 2), 0.05 * width_px),
        hills_(mix64(seed, 3), 0.12 * width_px),
        leaves_large_(mix64(seed, 4), 60),
        leaves_small_(mix64(seed, 5), 14),
        grass_(mix64(seed, 6), 24) {}

  void row(double y, double x0, const RgbRow& out) const override {
    // Rows are asked for often and from several threads; the scratch grows once per thread.
    thread_local std::vector<float> scratch;
    const std::size_t n = out.r.size();
    scratch.assign(4 * n, 0.0F);
    const std::span<float> cloud(scratch.data(), n), hill(scratch.data() + n, n);
    const std::span<float> leaves(scratch.data() + 2 * n, n), grass(scratch.data() + 3 * n, n);
    const auto v = static_cast<float>(y / h_);
    hills_.add_row(0, x0, 1.0F, hill);
    if (v < 0.55F) {
      cloud_large_.add_row(y * 1.8, x0, 1.0F, cloud);
      cloud_small_.add_row(y * 1.5, x0, 0.45F, cloud);
    }
    if (v > 0.25F) {
      leaves_large_.add_row(y, x0, 1.2F, leaves);
      leaves_small_.add_row(y, x0, 1.2F, leaves);
      grass_.add_row(y, x0, 1.0F, grass);
    }
    const auto edge = static_cast<float>(h_ / 5.0);  // transitions of 5 px
    const Colour sky = blend(kZenith, kHaze, std::clamp(v / 0.45F, 0.0F, 1.0F));
    const float lawn_here = smooth_step((v - 0.72F) * edge);
    const float in_fence_rows = smooth_step((0.03F - std::abs(v - 0.93F)) * edge);
    for (std::size_t i = 0; i < n; ++i) {
      const double x = x0 + static_cast<double>(i);
      const float cloudy = smooth_step(1.6F * cloud[i] - 0.1F);
      Colour c = blend(sky, kCloud, 0.9F * cloudy);
      const float land = smooth_step((v - 0.40F - 0.10F * hill[i]) * edge);
      if (land > 0) {
        const Colour trees = scaled(kFoliage, 1.0F + 0.9F * leaves[i]);
        const Colour lawn = scaled(kLawn, 1.0F + 0.35F * grass[i]);
        c = blend(c, blend(trees, lawn, lawn_here), land);
      }
      if (in_fence_rows > 0) {
        const auto bar = static_cast<float>(std::cos(2 * kPi * x / kFencePeriodPx));
        c = blend(c, kWood, in_fence_rows * smooth_step(1.5F * bar));
      }
      out.r[i] = c.r;
      out.g[i] = c.g;
      out.b[i] = c.b;
    }
    for (const Blob& blob : kBlobs) add_blob(blob, v, x0, out);
    for (const std::span<float> band : {out.r, out.g, out.b}) {
      for (float& value : band) value = std::clamp(value, 0.004F, 0.98F);
    }
  }

 private:
  static constexpr double kPi = 3.14159265358979323846;

  void add_blob(const Blob& blob, float v, double x0, const RgbRow& out) const {
    const float dy = (v - blob.y) / blob.ry;
    const auto edge = static_cast<float>(blob.rx * w_ / 5.0);  // transitions of 5 px
    // Until the transition has ended, which in small pictures takes longer.
    const float end_r = std::max(1.0F + 0.5F / edge, 1.42F);
    if (std::abs(dy) > end_r) return;
    const double reach = end_r * blob.rx * w_ + 1;
    const double begin = blob.x * w_ - reach - x0, end = blob.x * w_ + reach - x0;
    const auto n = static_cast<double>(out.r.size());
    const auto from = static_cast<std::size_t>(std::clamp(std::floor(begin), 0.0, n));
    const auto to = static_cast<std::size_t>(std::clamp(std::ceil(end), 0.0, n));
    for (std::size_t i = from; i < to; ++i) {
      const auto u = static_cast<float>((x0 + static_cast<double>(i)) / w_);
      const float dx = (u - blob.x) / blob.rx;
      const float r2 = dx * dx + dy * dy;
      const float w = smooth_step((1.0F - std::sqrt(r2)) * edge);
      const float shade = 1.0F - 0.35F * r2 + 0.12F * dx;
      const Colour c = blend({out.r[i], out.g[i], out.b[i]}, scaled(blob.colour, shade), w);
      out.r[i] = c.r;
      out.g[i] = c.g;
      out.b[i] = c.b;
    }
  }

  double w_, h_;
  SplineNoise cloud_large_, cloud_small_, hills_, leaves_large_, leaves_small_, grass_;
};

}  // namespace

std::unique_ptr<Scene> make_natural_scene(double width_px, double height_px, std::uint64_t seed) {
  return std::make_unique<NaturalScene>(width_px, height_px, seed);
}

}  // namespace reseau::sim
