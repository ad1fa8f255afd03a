#include "core/reconstruct/tile_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/base/check.h"
#include "core/base/float4.h"
#include "core/reconstruct/cubic_weights.h"
#include "core/reconstruct/silver_ratio.h"

namespace reseau {
namespace {

// Elements on either side of a pixel that interpolation takes, in lattice steps.
constexpr int kLatticeReach = 2;
constexpr int kDetailReach = DetailKernels::kRadius;

// Of the cubic between elements: at 0.5 it overshoots at edges of the scene, at 0 it flattens what
// is soft; here the colour at the scale of elements is truest (reseau bench reconstruction).
constexpr float kSlope = 0.2F;

// Interpolation weights by the fraction of a lattice step, rounded to 1/1024.
class WeightTable {
 public:
  static constexpr int kSteps = 1024;
  explicit WeightTable(Demosaic demosaic) {
    for (int i = 0; i <= kSteps; ++i) {
      const float t = static_cast<float>(i) / kSteps;
      const float next = t < kHalf ? 0.0F : 1.0F;
      const std::array<float, 4> w =
          demosaic == Demosaic::kNearest    ? std::array{0.0F, 1 - next, next, 0.0F}
          : demosaic == Demosaic::kBilinear ? std::array{0.0F, 1 - t, t, 0.0F}
                                            : cubic_weights(t, kSlope);
      std::copy(w.begin(), w.end(), weights_.begin() + static_cast<std::ptrdiff_t>(i) * 4);
    }
  }
  // Of fractions, 0..1; they are not negative, so this rounds.
  [[nodiscard]] static Int4 step(Float4 fraction) {
    return truncated(fraction * static_cast<float>(kSteps) + kHalf);
  }
  [[nodiscard]] const float* of(int step) const {
    return weights_.data() + static_cast<std::ptrdiff_t>(step) * 4;
  }

 private:
  static constexpr float kHalf = 0.5F;
  std::array<float, (kSteps + 1) * 4> weights_{};
};

const WeightTable& weight_table(Demosaic demosaic) {
  static const WeightTable cubic(Demosaic::kBicubic), linear(Demosaic::kBilinear),
      nearest(Demosaic::kNearest);
  return demosaic == Demosaic::kNearest    ? nearest
         : demosaic == Demosaic::kBilinear ? linear
                                           : cubic;
}

int detail_reach_of(const TileSettings& settings) {
  if (settings.demosaic == Demosaic::kJoint) return kDetailReach;
  if (settings.demosaic != Demosaic::kRatio) return 0;
  const Vec2 shift = settings.silver_shift_px;
  return SilverRatio::kReach +
         static_cast<int>(std::ceil(std::max(std::abs(shift.x), std::abs(shift.y))));
}

int reach_of(const ScreenMap& map) {
  // From a pixel to the farthest element that interpolation takes, along x or y.
  const Mat2 scan_from_screen = map.linear().inverse();
  const double x = std::abs(scan_from_screen.a) + std::abs(scan_from_screen.b);
  const double y = std::abs(scan_from_screen.c) + std::abs(scan_from_screen.d);
  return static_cast<int>(std::ceil(kLatticeReach * std::max(x, y))) + 1;
}

}  // namespace

TileRenderer::TileRenderer(const TileSettings& settings)
    : settings_(settings),
      detail_reach_px_(detail_reach_of(settings)),
      element_reach_px_(reach_of(settings.map) + detail_reach_px_) {}

float TileRenderer::element(const SilverRows& silver, std::size_t site, Vec2 p) const {
  const auto x = static_cast<int>(std::floor(p.x + 0.5)),
             y = static_cast<int>(std::floor(p.y + 0.5));
  const auto fx = static_cast<float>(p.x - x), fy = static_cast<float>(p.y - y);
  const float* corner = silver.at(x - ElementKernels::kRadius, y - ElementKernels::kRadius);
  const std::vector<BlurLevel>& levels = settings_.levels.levels();
  const BlurLevels::Place place =
      levels.size() == 1 ? BlurLevels::Place{} : settings_.levels.place(settings_.blur.sigma_px(p));
  const float* from = corner;
  const float* weight = levels[place.index].elements.of(site, fx, fy);
  Float4 a{}, b{}, c{}, d{};
  if (!(place.toward_next > 0)) {
    for (int row = 0; row < ElementKernels::kSide; ++row) {
      a += load4(weight) * load4(from);
      b += load4(weight + 4) * load4(from + 4);
      c += load4(weight + 8) * load4(from + 8);
      d += load4(weight + 12) * load4(from + 12);
      weight += ElementKernels::kRow;
      from += silver.stride();
    }
    return sum4((a + b) + (c + d));
  }
  // Between two levels: both at once, for the silver is the same.
  const float* next = levels[place.index + 1].elements.of(site, fx, fy);
  Float4 next_a{}, next_b{};
  for (int row = 0; row < ElementKernels::kSide; ++row) {
    const Float4 p0 = load4(from), p1 = load4(from + 4), p2 = load4(from + 8),
                 p3 = load4(from + 12);
    a += load4(weight) * p0;
    b += load4(weight + 4) * p1;
    a += load4(weight + 8) * p2;
    b += load4(weight + 12) * p3;
    next_a += load4(next) * p0;
    next_b += load4(next + 4) * p1;
    next_a += load4(next + 8) * p2;
    next_b += load4(next + 12) * p3;
    weight += ElementKernels::kRow;
    next += ElementKernels::kRow;
    from += silver.stride();
  }
  const Float4 first = a + b;
  return sum4(first + place.toward_next * ((next_a + next_b) - first));
}

TileRenderer::Planes TileRenderer::collect(const SilverRows& silver, const BlankBlocks& blank,
                                           const PixelBounds& rect, Vec2 origin, Vec2 lowest,
                                           Vec2 highest) const {
  Planes planes;
  const Vec2 room{kLatticeReach + 1.0, kLatticeReach + 1.0};
  const Vec2 from = lowest - room, to = highest + room;
  const InverseMapGrid pixel_of(settings_.map, settings_.silver_shift_px, rect, origin, from, to);
  const PixelBounds area = rect.grown(reach_of(settings_.map));
  for (std::size_t c = 0; c < 3; ++c) {
    const ElementLattice& lattice = settings_.pattern.lattices()[c];
    Vec2 first{1e30, 1e30}, last{-1e30, -1e30};
    for (const Vec2 s : {lowest, highest, Vec2{lowest.x, highest.y}, Vec2{highest.x, lowest.y}}) {
      const Vec2 index = lattice.to_index * (s - lattice.origin);
      first = {std::min(first.x, index.x), std::min(first.y, index.y)};
      last = {std::max(last.x, index.x), std::max(last.y, index.y)};
    }
    const auto whole = [](double index) { return static_cast<int>(std::floor(index)); };
    Plane& plane = planes[c];
    plane.first_i = whole(first.x) - kLatticeReach;
    plane.first_j = whole(first.y) - kLatticeReach;
    plane.n_i = whole(last.x) + kLatticeReach + 2 - plane.first_i;
    plane.n_j = whole(last.y) + kLatticeReach + 2 - plane.first_j;
    plane.values.assign(static_cast<std::size_t>(plane.n_i) * static_cast<std::size_t>(plane.n_j),
                        0.0F);
    const Mat2 from_index = lattice.to_index.inverse();
    const std::size_t first_site = settings_.levels.first_site()[c];
    for (int j = 0; j < plane.n_j; ++j) {
      float* row = &plane.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(plane.n_i)];
      for (int i = 0; i < plane.n_i; ++i) {
        const int at_i = plane.first_i + i, at_j = plane.first_j + j;
        const Vec2 s = lattice.origin +
                       from_index * Vec2{static_cast<double>(at_i), static_cast<double>(at_j)};
        if (s.x < from.x || s.x > to.x || s.y < from.y || s.y > to.y) continue;
        const Vec2 p = pixel_of.at(s);
        if (p.x < area.x0 || p.x > area.x1 || p.y < area.y0 || p.y > area.y1) continue;
        const auto x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
        if (blank.around(x, y, ElementKernels::kRadius + 1)) {
          row[i] = blank.mean(x, y);
          continue;
        }
        row[i] =
            element(silver, first_site + static_cast<std::size_t>(lattice.site(at_i, at_j)), p);
      }
    }
  }
  return planes;
}

void TileRenderer::interpolate(const Planes& planes, const BlankBlocks& blank, int x0, int y,
                               const std::vector<ScreenPoint>& at, float* out) const {
  const WeightTable& table = weight_table(settings_.demosaic);
  // A lane for each colour; the fourth is not used.
  struct Axis {
    Float4 of_u{}, of_v{}, start{};
  };
  Axis x_axis, y_axis;
  std::array<const float*, 3> values{};
  std::array<std::ptrdiff_t, 3> n_i{};
  for (std::size_t c = 0; c < 3; ++c) {
    const ElementLattice& lattice = settings_.pattern.lattices()[c];
    const Mat2& m = lattice.to_index;
    const Vec2 start = m * lattice.origin;
    x_axis.of_u[c] = static_cast<float>(m.a);
    x_axis.of_v[c] = static_cast<float>(m.b);
    x_axis.start[c] = static_cast<float>(-start.x - planes[c].first_i);
    y_axis.of_u[c] = static_cast<float>(m.c);
    y_axis.of_v[c] = static_cast<float>(m.d);
    y_axis.start[c] = static_cast<float>(-start.y - planes[c].first_j);
    n_i[c] = planes[c].n_i;
    values[c] = planes[c].values.data() - n_i[c] - 1;  // of the first of 4 x 4 elements
  }
  const int reach = reach_of(settings_.map) + 2;
  for_runs(blank, x0, y, static_cast<int>(at.size()), reach, [&](int begin, int end, bool skip) {
    float* to =
        out + static_cast<std::ptrdiff_t>(begin) * static_cast<std::ptrdiff_t>(kPixelFloats);
    for (int k = begin; k < end; ++k, to += kPixelFloats) {
      if (skip) {
        std::fill_n(to, 3, blank.mean(x0 + k, y));
        continue;
      }
      const ScreenPoint& s = at[static_cast<std::size_t>(k)];
      const Float4 x = s.u * x_axis.of_u + s.v * x_axis.of_v + x_axis.start,
                   y_index = s.u * y_axis.of_u + s.v * y_axis.of_v + y_axis.start;
      const Int4 i = truncated(x), j = truncated(y_index);  // both are positive
      const Int4 step_x = WeightTable::step(x - as_float(i)),
                 step_y = WeightTable::step(y_index - as_float(j));
      std::array<Float4, 3> weighed;
      for (std::size_t c = 0; c < 3; ++c) {
        const float* wy = table.of(step_y[c]);
        const float* row = values[c] + j[c] * n_i[c] + i[c];
        Float4 sum = wy[0] * load4(row);
        sum += wy[1] * load4(row + n_i[c]);
        sum += wy[2] * load4(row + 2 * n_i[c]);
        sum += wy[3] * load4(row + 3 * n_i[c]);
        weighed[c] = sum * load4(table.of(step_x[c]));
      }
      store4(to, sums4(weighed[0], weighed[1], weighed[2], Float4{}));
    }
  });
}

std::size_t TileRenderer::render(const SilverRows& silver, const PixelBounds& rect, float* out,
                                 std::ptrdiff_t row_stride, int step) const {
  CHECK(step == 1 || !has_detail());
  const int reach = detail_reach_px_;
  const bool shifted = !(settings_.silver_shift_px == Vec2{});
  const PixelBounds wide = rect.grown(reach);
  const Vec2 corner =
      settings_.map.screen_from_scan({static_cast<double>(rect.x0), static_cast<double>(rect.y0)});
  const Vec2 origin{std::floor(corner.x), std::floor(corner.y)};
  const MapGrid picture_at(settings_.map, {}, wide, origin);
  const BlankBlocks blank(silver, rect.grown(reach_px() - 1), settings_.blank_noise_sd);
  const Planes planes =
      collect(silver, blank, wide, origin, picture_at.lowest(), picture_at.highest());
  std::vector<ScreenPoint> at;
  const auto n_wide = static_cast<std::size_t>(wide.width()) * kPixelFloats;
  const int n_columns = (rect.width() + step - 1) / step,
            n_rows = (rect.height() + step - 1) / step;
  const auto n_row = static_cast<std::size_t>(n_columns) * kPixelFloats;
  std::vector<float> picture(n_row * static_cast<std::size_t>(n_rows));
  if (step > 1) {
    for (int row = 0; row < n_rows; ++row) {
      picture_at.row(rect.y0 + row * step, at);
      for (int x = 0; x < n_columns; ++x)
        at[static_cast<std::size_t>(x)] =
            at[static_cast<std::size_t>(x) * static_cast<std::size_t>(step)];
      at.resize(static_cast<std::size_t>(n_columns));
      interpolate(planes, {}, rect.x0, rect.y0 + row * step, at,
                  &picture[n_row * static_cast<std::size_t>(row)]);
    }
  } else if (reach == 0) {
    for (int y = rect.y0; y < rect.y1; ++y) {
      picture_at.row(y, at);
      interpolate(planes, blank, rect.x0, y, at,
                  &picture[n_row * static_cast<std::size_t>(y - rect.y0)]);
    }
  } else {
    std::vector<float> smooth(n_wide * static_cast<std::size_t>(wide.height()));
    std::optional<MapGrid> moved;
    if (shifted) moved.emplace(settings_.map, settings_.silver_shift_px, wide, origin);
    const MapGrid& silver_at = shifted ? *moved : picture_at;
    for (int y = wide.y0; y < wide.y1; ++y) {
      silver_at.row(y, at);
      interpolate(planes, blank, wide.x0, y, at,
                  &smooth[n_wide * static_cast<std::size_t>(y - wide.y0)]);
    }
    for (int y = rect.y0; y < rect.y1; ++y) {
      float* to = &picture[n_row * static_cast<std::size_t>(y - rect.y0)];
      if (shifted) {
        picture_at.row(y, at);
        at.erase(at.begin(), at.begin() + reach);
        at.resize(static_cast<std::size_t>(rect.width()));
        interpolate(planes, blank, rect.x0, y, at, to);
      } else {
        std::copy_n(&smooth[n_wide * static_cast<std::size_t>(y - wide.y0) +
                            static_cast<std::size_t>(reach) * kPixelFloats],
                    n_row, to);
      }
    }
    const std::vector<float> predicted = predict(silver_at, wide, smooth);
    if (settings_.demosaic == Demosaic::kJoint) {
      add_detail(silver, blank, silver_at, rect, predicted, picture);
    } else {
      multiply_by_ratio(silver, blank, rect, predicted, picture);
    }
  }
  const std::array<float, 9>& m = settings_.output_from_process;
  const float* p = picture.data();
  for (int y = 0; y < n_rows; ++y) {
    float* to = out + y * row_stride;
    for (int x = 0; x < n_columns; ++x, p += kPixelFloats) {
      *to++ = m[0] * p[0] + m[1] * p[1] + m[2] * p[2];
      *to++ = m[3] * p[0] + m[4] * p[1] + m[5] * p[2];
      *to++ = m[6] * p[0] + m[7] * p[1] + m[8] * p[2];
    }
  }
  std::size_t n_blank = 0;
  for (int y = rect.y0; blank.any() && y < rect.y1; ++y) {
    for_runs(blank, rect.x0, y, rect.width(), reach_of(settings_.map) + 2,
             [&n_blank](int begin, int end, bool skip) {
               if (skip) n_blank += static_cast<std::size_t>(end - begin);
             });
  }
  return n_blank;
}

}  // namespace reseau
