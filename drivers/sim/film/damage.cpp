#include "drivers/sim/film/damage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "drivers/sim/hash.h"
#include "drivers/sim/smooth_step.h"

namespace reseau::sim {
namespace {

constexpr double kBandPx = 64;
constexpr double kEdgePx = 0.7;    // softness of dust and scratches
constexpr double kBesidePx = 160;  // film beside and before the frames that dust falls on
constexpr double kUmPerCm = 10000;

// A stream of random numbers for one mark.
class Lots {
 public:
  Lots(std::uint64_t key, std::uint64_t index) : key_(mix64(key, index)) {}
  double between(double low, double high) {
    const double unit = (static_cast<double>(signed_unit(mix64(key_, ++n_))) + 1) / 2;
    return low + (high - low) * unit;
  }

 private:
  std::uint64_t key_, n_ = 0;
};

float soft_inside(double distance_px) {  // 1 inside, 0 outside
  return smooth_step(static_cast<float>(distance_px / (2 * kEdgePx)));
}

}  // namespace

Damage::Damage(const FilmSpec& spec)
    : spec_(spec.damage),
      fade_map_(mix64(spec.seed, 0xfade), 450),
      stain_map_(mix64(spec.seed, 0x57a1), 280),
      wander_(mix64(spec.seed, 0x5c7a), 120) {
  throw_lots(spec);
  if (marks_.empty()) return;
  double last_y = -1e9;
  first_y_ = 1e9;
  for (const Mark& mark : marks_) {
    first_y_ = std::min(first_y_, mark.y - mark.half_height);
    last_y = std::max(last_y, mark.y + mark.half_height);
  }
  bands_.resize(static_cast<std::size_t>((last_y - first_y_) / kBandPx) + 1);
  for (std::size_t k = 0; k < marks_.size(); ++k) {
    const Mark& mark = marks_[k];
    const auto from = static_cast<std::size_t>((mark.y - mark.half_height - first_y_) / kBandPx);
    const auto to = static_cast<std::size_t>((mark.y + mark.half_height - first_y_) / kBandPx);
    for (std::size_t band = from; band <= std::min(to, bands_.size() - 1); ++band) {
      bands_[band].push_back(static_cast<std::uint32_t>(k));
    }
  }
}

void Damage::throw_lots(const FilmSpec& spec) {
  const double um = spec.frame.pixel_um;
  const double width = spec.frame.width_px + 2 * kBesidePx;
  const double height =
      static_cast<double>(spec.frame.height_px) * spec.frame.n_frames + 2 * kBesidePx;
  const double cm2 = width * height * um * um / (kUmPerCm * kUmPerCm);
  const auto place = [&](Lots& lots, Mark& mark) {
    mark.x = lots.between(-kBesidePx, width - kBesidePx);
    mark.y = lots.between(-kBesidePx, height - kBesidePx);
  };
  const auto n_of = [](double n) { return static_cast<std::uint64_t>(std::lround(n)); };

  const std::uint64_t dust_key = mix64(spec.seed, 0xd057);
  for (std::uint64_t k = 0; k < n_of(spec_.dust_per_cm2 * cm2); ++k) {
    Lots lots(dust_key, k);
    Mark mark{Kind::kDust, 0, 0, 0, 0, 0, 0, 0};
    place(lots, mark);
    mark.angle = lots.between(0, std::numbers::pi);
    mark.strength = lots.between(0.6, 0.98);
    const double size = spec_.dust_um / um * std::exp(lots.between(-1.0, 0.7));
    if (lots.between(0, 1) < 0.15) {
      mark.kind = Kind::kHair;  // an arc: radius a, half width b, from angle on
      mark.a = 12 * size;
      mark.b = std::max(0.6, 5 / um);
      mark.half_height = mark.a + mark.b + 2;
    } else {
      mark.a = size;
      mark.b = size * lots.between(0.4, 1.0);
      mark.half_height = mark.a + 2;
    }
    marks_.push_back(mark);
  }
  const std::uint64_t bubble_key = mix64(spec.seed, 0xb0bb);
  for (std::uint64_t k = 0; k < n_of(spec_.bubbles_per_cm2 * cm2); ++k) {
    Lots lots(bubble_key, k);
    Mark mark{Kind::kBubble, 0, 0, 0, 0, 0, 0, 0};
    place(lots, mark);
    mark.a = spec_.bubble_um / um * std::exp(lots.between(-0.8, 0.6));
    mark.b = std::max(1.0, 0.12 * mark.a);  // of the rim
    mark.strength = lots.between(0.25, 0.6);
    mark.half_height = mark.a + 3 * mark.b;
    marks_.push_back(mark);
  }
  const std::uint64_t scratch_key = mix64(spec.seed, 0x5c4a);
  const double cm = width * um / kUmPerCm;
  for (std::uint64_t k = 0; k < n_of(spec_.scratches_per_cm * cm); ++k) {
    Lots lots(scratch_key, k);
    Mark mark{lots.between(0, 1) < 0.5 ? Kind::kBaseScratch : Kind::kEmulsionScratch,
              0,
              0,
              0,
              0,
              0,
              0,
              0};
    place(lots, mark);
    mark.a = lots.between(2, 7) / um;        // half width
    mark.angle = lots.between(-0.01, 0.01);  // slope
    mark.strength = lots.between(0.3, 1.0);
    mark.half_height = std::min(height, lots.between(0.05, 0.6) * spec.frame.height_px);
    marks_.push_back(mark);
  }
}

bool Damage::local(double y, double x0, double step_px, const Local& out) const {
  if (marks_.empty() || y < first_y_) return false;
  const auto band = static_cast<std::size_t>((y - first_y_) / kBandPx);
  if (band >= bands_.size() || bands_[band].empty()) return false;
  std::ranges::fill(out.transmittance, 1.0F);
  std::ranges::fill(out.bared, 0.0F);
  for (const std::uint32_t k : bands_[band]) {
    if (std::abs(y - marks_[k].y) <= marks_[k].half_height) {
      draw(marks_[k], y, x0, step_px, out);
    }
  }
  return true;
}

void Damage::draw(const Mark& mark, double y, double x0, double step_px, const Local& out) const {
  const double dy = y - mark.y;
  double centre = mark.x;
  double reach = std::sqrt(std::max(mark.half_height * mark.half_height - dy * dy, 0.0));
  const bool scratch = mark.kind == Kind::kBaseScratch || mark.kind == Kind::kEmulsionScratch;
  if (scratch) {
    std::array<float, 1> sway{};
    wander_.add_row(y, mark.x, 4.0F, sway);
    centre += mark.angle * dy + static_cast<double>(sway[0]);
    reach = mark.a + 2;
  }
  // Cells from the one end of the reach to the other.
  const auto n = static_cast<double>(out.bared.size());
  double from = (centre - reach - x0) / step_px, to = (centre + reach - x0) / step_px;
  if (from > to) std::swap(from, to);
  const auto begin = static_cast<std::size_t>(std::clamp(std::floor(from), 0.0, n));
  const auto end = static_cast<std::size_t>(std::clamp(std::ceil(to) + 1, 0.0, n));
  const double c = std::cos(mark.angle), s = std::sin(mark.angle);
  const float end_of = scratch ? soft_inside(mark.half_height - 1 - std::abs(dy)) : 1.0F;
  for (std::size_t i = begin; i < end; ++i) {
    const double dx = x0 + step_px * static_cast<double>(i) - centre;
    float& t = out.transmittance[i];
    const auto darken = [&](float amount) {
      t = std::min(t, 1 - static_cast<float>(mark.strength) * amount);
    };
    switch (mark.kind) {
      case Kind::kDust: {
        const double p = dx * c + dy * s, q = dy * c - dx * s;
        const double r2 = p * p / (mark.a * mark.a) + q * q / (mark.b * mark.b);
        const double ends = 1 + kEdgePx / mark.b;
        if (r2 < ends * ends) darken(soft_inside((1 - std::sqrt(r2)) * mark.b));
        break;
      }
      case Kind::kHair: {
        const double r2 = dx * dx + dy * dy, wide = mark.b + kEdgePx;
        const double least = std::max(mark.a - wide, 0.0);
        if (r2 < least * least || r2 > (mark.a + wide) * (mark.a + wide)) break;
        const double r = std::sqrt(r2);
        // An arc with soft ends.
        const float part = soft_inside(dx * c + dy * s - 0.3 * mark.a);
        darken(part * soft_inside(mark.b - std::abs(r - mark.a)));
        break;
      }
      case Kind::kBubble: {
        const double r = (std::sqrt(dx * dx + dy * dy) - mark.a) / mark.b;
        const double rim = std::exp(-r * r);
        constexpr double kInside = 0.15;
        darken(static_cast<float>(r < 0 ? kInside + (1 - kInside) * rim : rim));
        break;
      }
      case Kind::kBaseScratch:
        darken(end_of * soft_inside(mark.a - std::abs(dx)));
        break;
      case Kind::kEmulsionScratch:
        out.bared[i] = std::max(out.bared[i], static_cast<float>(mark.strength) * end_of *
                                                  soft_inside(mark.a - std::abs(dx)));
        break;
    }
  }
}

void Damage::faded(double y, double x0, std::span<float> out) const {
  std::ranges::fill(out, 0.0F);
  fade_map_.add_row(y, x0, 1.0F, out);
  const auto depth = static_cast<float>(spec_.faded_areas);
  for (float& v : out) v = depth * smooth_step((v - 0.12F) / 0.3F);
}

void Damage::stained(double y, double x0, std::span<float> out) const {
  std::ranges::fill(out, 0.0F);
  stain_map_.add_row(y, x0, 1.0F, out);
  const auto depth = static_cast<float>(spec_.stains);
  for (float& v : out) v = depth * smooth_step((v - 0.15F) / 0.12F);
}

}  // namespace reseau::sim
