#include "drivers/sim/film/element_painter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/check.h"
#include "drivers/sim/film.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/hash.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

// Keeps local coordinates positive, whatever sums of them shapes need.
constexpr int kAhead = 8;
constexpr float kPositive = 64;
// Cells with a corner are divided so often along each side.
constexpr int kFine = 4;
constexpr float kWhole = 0.9999F;  // rounding left aside
// Relative change of the lattice's gradient that the edges of a cell may ignore: near the axes of
// the scan a ramp that is wrong by this much costs 1e-5 of the light.
constexpr double kStraight = 0.004;

float floor_of(float t) {  // t > -kPositive
  return static_cast<float>(static_cast<int>(t + kPositive)) - kPositive;
}

}  // namespace

// Places on the screen within 16 pixels, whole periods taken off.
struct ElementPainter::Block {
  double base_u = 0, base_v = 0;    // whole numbers; place = base - kAhead + local
  std::array<double, 17> u{}, v{};  // local, at pixels 0 … 16 (every node_px of them)
  // Cubic between nodes: value at t = (pixel - 4 j) / 4 of interval j.
  std::array<std::array<double, 4>, 4> cubic_u{}, cubic_v{};

  // Place of pixel i + offset.
  void at(int i, double offset, int node_px, float& at_u, float& at_v) const {
    if (node_px == kBlockPx) {
      const double t = (i + offset) / kBlockPx;
      at_u = static_cast<float>(u[0] + t * (u[16] - u[0]));
      at_v = static_cast<float>(v[0] + t * (v[16] - v[0]));
      return;
    }
    const auto j = static_cast<std::size_t>(i / 4);
    const double t = (i % 4 + offset) / 4;
    const std::array<double, 4>&cu = cubic_u[j], &cv = cubic_v[j];
    at_u = static_cast<float>(cu[0] + t * (cu[1] + t * (cu[2] + t * cu[3])));
    at_v = static_cast<float>(cv[0] + t * (cv[1] + t * (cv[2] + t * cv[3])));
  }
};

struct ElementPainter::Shape {
  Shape(const ScreenShape* of, const PrintingNoise& errors) : shape(of), noise(errors) {}
  const ScreenShape* shape = nullptr;
  PrintingNoise noise;
  std::vector<EdgeRamp> ramps, fine_ramps;  // of a cell, of a kFine-th of its side
  std::vector<float> per_px;                // length of the gradient of each band [1/px]
  std::array<float, 4> px_of{};             // x and y of one period of u, of v
  std::array<float, 4> per_cell{};          // change of u and v over a cell along x, along y
  float cell_px = 0;
  bool tents = false;
};

// How a row is painted.
struct ElementPainter::Painting {
  std::vector<Shape> shapes, fine;  // of cells, of their parts
  bool divides = false, tents = false;
};

struct ElementPainter::Cover {
  std::array<float, kBlockPx> inner{}, outer{};  // equal where nothing overlaps and nothing gapes
};

ElementPainter::ElementPainter(const FilmSpec& spec)
    : screen_(spec),
      description_(describe_screen(spec.screen)),
      print_(spec.print),
      pixel_um_(spec.frame.pixel_um),
      seed_(mix64(spec.seed, 0x9e55)),
      errors_(spec.print.position_noise_um > 0 || spec.print.width_noise_um > 0 ||
              spec.print.missing > 0) {
  // Straight over a block, within a thousandth of a pixel, or cubic between closer nodes.
  constexpr double kStraightPx = 1e-3;
  node_px_ = screen_.largest_curvature() * kBlockPx * kBlockPx / 8 < kStraightPx ? kBlockPx : 4;
  strained_ = screen_.largest_strain() > kStraight;
  for (const int width : {4, 2, 1}) {
    if (screen_.largest_curvature() * strip_px_ / 2 > 2 * kStraight) strip_px_ = width;
  }
  std::array<bool, kDyeSets> occurs{};
  occurs[std::size_t{1} << static_cast<unsigned>(description_.ground)] = true;
  for (const ScreenShape& shape : description_.shapes) {
    const int bit = 1 << shape.color;
    const std::array<bool, kDyeSets> before = occurs;
    for (int set = 0; set < kDyeSets && print_.overlap_um != 0; ++set) {
      if (before[static_cast<std::size_t>(set)]) {
        occurs[static_cast<std::size_t>(between(set, bit))] = true;
      }
    }
    occurs[static_cast<std::size_t>(bit)] = true;
  }
  slot_of_set_.fill(-1);
  for (int set = 0; set < kDyeSets; ++set) {
    if (!occurs[static_cast<std::size_t>(set)]) continue;
    slot_of_set_[static_cast<std::size_t>(set)] = static_cast<int>(sets_.size());
    sets_.push_back(set);
  }
}

int ElementPainter::between(int set, int bit) const {
  if (print_.overlap_um < 0 || set == kOpaque) return print_.dark_gaps ? kOpaque : 0;
  const int both = set | bit;
  // At the border of two shapes the ground under them is not a third dye.
  return both == 7 ? both & ~(1 << description_.ground) : both;
}

void ElementPainter::place(double y, int first_px, Block& block) const {
  const auto local = [&](double x, double& u, double& v) {
    const ScreenPoint p = screen_.screen_from_scan(first_px + x, y);
    u = p.u - block.base_u + kAhead;
    v = p.v - block.base_v + kAhead;
  };
  const ScreenPoint first = screen_.screen_from_scan(first_px, y);
  block.base_u = std::floor(first.u);
  block.base_v = std::floor(first.v);
  if (node_px_ == kBlockPx) {
    local(0, block.u[0], block.v[0]);
    local(kBlockPx, block.u[16], block.v[16]);
    return;
  }
  std::array<double, 7> u{}, v{};  // nodes at -4, 0 … 20
  for (std::size_t j = 0; j < 7; ++j) local(4.0 * (static_cast<double>(j) - 1), u[j], v[j]);
  const auto fit = [](const std::array<double, 7>& p, std::array<std::array<double, 4>, 4>& out) {
    for (std::size_t j = 0; j < 4; ++j) {  // through p[j] … p[j + 3] at t = -1, 0, 1, 2
      const double a = p[j], b = p[j + 1], c = p[j + 2], d = p[j + 3];
      out[j] = {b, c - b / 2 - a / 3 - d / 6, (a + c) / 2 - b, (d - a) / 6 + (b - c) / 2};
    }
  };
  fit(u, block.cubic_u);
  fit(v, block.cubic_v);
}

void ElementPainter::ramps(const ScreenGradient& g, double cell_px, bool tents,
                           std::vector<Shape>& shapes) const {
  const double det = g.u_x * g.v_y - g.u_y * g.v_x;
  for (Shape& shape : shapes) {
    shape.cell_px = static_cast<float>(cell_px);
    shape.px_of = {static_cast<float>(g.v_y / det), static_cast<float>(-g.v_x / det),
                   static_cast<float>(-g.u_y / det), static_cast<float>(g.u_x / det)};
    shape.per_cell = {static_cast<float>(g.u_x * cell_px), static_cast<float>(g.v_x * cell_px),
                      static_cast<float>(g.u_y * cell_px), static_cast<float>(g.v_y * cell_px)};
    shape.tents = tents;
    shape.ramps.clear();
    shape.fine_ramps.clear();
    shape.per_px.clear();
    for (const ScreenBand& band : shape.shape->bands) {
      const double x = band.n.x * g.u_x + band.n.y * g.v_x;
      const double y = band.n.x * g.u_y + band.n.y * g.v_y;
      shape.ramps.push_back(tents ? EdgeRamp::tent(x * cell_px, y * cell_px)
                                  : EdgeRamp(x * cell_px, y * cell_px));
      shape.fine_ramps.emplace_back(x * cell_px / kFine, y * cell_px / kFine);
      shape.per_px.push_back(static_cast<float>(std::hypot(x, y)));
    }
  }
}

void ElementPainter::cover_disc(const Shape& shape, float du, float dv, float grow_px, float& inner,
                                float& outer) const {
  const float x = du * shape.px_of[0] + dv * shape.px_of[2];
  const float y = du * shape.px_of[1] + dv * shape.px_of[3];
  const auto radius_px = static_cast<float>(shape.shape->radius_um / pixel_um_);
  const float r = std::max(std::sqrt(x * x + y * y), 0.01F);
  const float inside = radius_px + grow_px - r;
  const float half_band = static_cast<float>(std::abs(print_.overlap_um) / 2 / pixel_um_);
  if (inside > 2 * shape.cell_px + half_band || inside < -2 * shape.cell_px - half_band) {
    inner = outer = inside > 0 ? 1.0F : 0.0F;
    return;
  }
  const float h = shape.cell_px;
  const EdgeRamp ramp(static_cast<double>(x / r * h), static_cast<double>(y / r * h));
  // Over the cell the circle leaves its tangent by this on average.
  const float sagitta = h * h / (24 * r);
  inner = ramp(inside - half_band - sagitta);
  outer = half_band > 0 ? ramp(inside + half_band - sagitta) : inner;
}

float ElementPainter::cover_polygon(const Shape& s, float du, float dv, float grow_px) const {
  const std::vector<ScreenBand>& bands = s.shape->bands;
  const auto product = [&](float u, float v, const std::vector<EdgeRamp>& ramps, int& edges) {
    float covered = 1;
    for (std::size_t b = 0; b < bands.size(); ++b) {
      const float distance =
          std::abs(static_cast<float>(bands[b].n.x) * u + static_cast<float>(bands[b].n.y) * v);
      const float one =
          ramps[b](static_cast<float>(bands[b].half) + grow_px * s.per_px[b] - distance);
      edges += one < kWhole ? 1 : 0;
      covered *= one;
    }
    return covered;
  };
  int edges = 0;
  const float whole = product(du, dv, s.ramps, edges);
  if (edges < 2 || whole == 0) return whole;
  float sum = 0, weights = 0;
  const int side = s.tents ? 2 * kFine : kFine;  // a tent is two cells wide
  const float middle = 0.5F * static_cast<float>(side);
  for (int j = 0; j < side; ++j) {
    const float y = (static_cast<float>(j) + 0.5F - middle) / kFine;
    for (int i = 0; i < side; ++i) {
      const float x = (static_cast<float>(i) + 0.5F - middle) / kFine;
      const float weight = s.tents ? (1 - std::abs(x)) * (1 - std::abs(y)) : 1.0F;
      weights += weight;
      sum += weight * product(du + x * s.per_cell[0] + y * s.per_cell[2],
                              dv + x * s.per_cell[1] + y * s.per_cell[3], s.fine_ramps, edges);
    }
  }
  return sum / weights;
}

// cover_polygon() of a block of cells; only those with a corner one by one.
void ElementPainter::cover_polygons(const Shape& s, const float* u, const float* v, float grow_px,
                                    std::array<float, kBlockPx>& out) const {
  const auto cu = static_cast<float>(s.shape->center.x), cv = static_cast<float>(s.shape->center.y);
  std::array<float, kBlockPx> du{}, dv{}, edges{};
  float *const off_u = du.data(), *const off_v = dv.data(), *const met = edges.data();
  float* const covered = out.data();
  widest([=]() RESEAU_SIM_INLINE {
    float* __restrict const to_u = off_u, * __restrict const to_v = off_v;
    for (std::size_t i = 0; i < kBlockPx; ++i) {
      to_u[i] = u[i] - cu - floor_of(u[i] - cu + 0.5F);
      to_v[i] = v[i] - cv - floor_of(v[i] - cv + 0.5F);
      covered[i] = 1;
    }
  });
  const std::vector<ScreenBand>& bands = s.shape->bands;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const auto n_u = static_cast<float>(bands[b].n.x), n_v = static_cast<float>(bands[b].n.y);
    const float half = static_cast<float>(bands[b].half) + grow_px * s.per_px[b];
    const EdgeRamp ramp = s.ramps[b];
    widest([=]() RESEAU_SIM_INLINE {
      float* __restrict const to = covered, * __restrict const to_met = met;
      for (std::size_t i = 0; i < kBlockPx; ++i) {
        const float one = ramp(half - std::abs(n_u * off_u[i] + n_v * off_v[i]));
        to_met[i] += one < kWhole ? 1.0F : 0.0F;
        to[i] *= one;
      }
    });
  }
  for (std::size_t i = 0; i < kBlockPx; ++i) {
    if (edges[i] > 1 && out[i] != 0) out[i] = cover_polygon(s, du[i], dv[i], grow_px);
  }
}

void ElementPainter::cover(Shape& s, const Block& block, const float* u, const float* v,
                           Cover& out) const {
  const ScreenShape& shape = *s.shape;
  const auto half_band_px = static_cast<float>(std::abs(print_.overlap_um) / 2 / pixel_um_);
  const auto cu = static_cast<float>(shape.center.x), cv = static_cast<float>(shape.center.y);
  const auto position_px = static_cast<float>(print_.position_noise_um / pixel_um_);
  const auto width_px = static_cast<float>(print_.width_noise_um / 2 / pixel_um_);
  if (shape.kind == ScreenShape::Kind::kLine) {
    const ScreenBand& band = shape.bands[0];
    const auto n_u = static_cast<float>(band.n.x), n_v = static_cast<float>(band.n.y);
    const auto half = static_cast<float>(band.half);
    const float grow = half_band_px * s.per_px[0];
    const float centre = n_u * cu + n_v * cv;
    const EdgeRamp ramp = s.ramps[0];
    if (!errors_) {
      float *const inner = out.inner.data(), *const outer = out.outer.data();
      widest([=]() RESEAU_SIM_INLINE {
        float* __restrict const to_inner = inner, * __restrict const to_outer = outer;
        if (grow == 0) {
          for (std::size_t i = 0; i < kBlockPx; ++i) {
            const float t = n_u * u[i] + n_v * v[i] - centre;
            const float covered = ramp(half - std::abs(t - floor_of(t + 0.5F)));
            to_inner[i] = covered;
            to_outer[i] = covered;
          }
          return;
        }
        for (std::size_t i = 0; i < kBlockPx; ++i) {
          const float t = n_u * u[i] + n_v * v[i] - centre;
          const float d = std::abs(t - floor_of(t + 0.5F));
          to_inner[i] = ramp(half - grow - d);
          to_outer[i] = ramp(half + grow - d);
        }
      });
      return;
    }
    const double base = band.n.x * (block.base_u - kAhead) + band.n.y * (block.base_v - kAhead);
    const double along_base =
        band.n.x * (block.base_v - kAhead) - band.n.y * (block.base_u - kAhead);
    const double along_um = band.n.x != 0 ? screen_.spec().period_v_um : screen_.spec().period_u_um;
    const double per_length = along_um / print_.noise_length_um;
    // Errors matter near an edge only.
    const float per_px = s.per_px[0];
    const float near =
        ramp.reach() + grow + PrintingNoise::kLargest * (position_px + width_px) * per_px;
    std::array<float, kBlockPx> line{}, off{};
    for (std::size_t i = 0; i < kBlockPx; ++i) {
      const float t = n_u * u[i] + n_v * v[i] - centre;
      line[i] = floor_of(t + 0.5F);
      off[i] = t - line[i];
    }
    const auto base_line = static_cast<std::int64_t>(base);
    for (std::size_t i = 0; i < kBlockPx; ++i) {
      const float inside = half - std::abs(off[i]);
      const std::int64_t index = base_line + static_cast<std::int64_t>(line[i]);
      if (inside < -near || (s.noise.can_miss() && s.noise.is_missing(index))) {
        out.inner[i] = out.outer[i] = 0;
      } else if (inside > near) {
        out.inner[i] = out.outer[i] = 1;
      } else {
        const double along = along_base + static_cast<double>(n_u * v[i] - n_v * u[i]);
        const PrintError e = s.noise.line(index, along * per_length);
        const float wide = half + e.width * width_px * per_px;
        const float d = std::abs(off[i] - e.across * position_px * per_px);
        out.inner[i] = ramp(wide - grow - d);
        out.outer[i] = grow > 0 ? ramp(wide + grow - d) : out.inner[i];
      }
    }
    return;
  }
  if (!errors_ && shape.kind == ScreenShape::Kind::kPolygon) {
    cover_polygons(s, u, v, -half_band_px, out.inner);
    out.outer = out.inner;
    if (half_band_px > 0) cover_polygons(s, u, v, half_band_px, out.outer);
    return;
  }
  for (std::size_t i = 0; i < kBlockPx; ++i) {
    const float index_u = floor_of(u[i] - cu + 0.5F), index_v = floor_of(v[i] - cv + 0.5F);
    float du = u[i] - cu - index_u, dv = v[i] - cv - index_v;
    PrintError e;
    if (errors_) {
      e = s.noise.shape(
          static_cast<std::int64_t>(block.base_u) + static_cast<std::int64_t>(index_u),
          static_cast<std::int64_t>(block.base_v) + static_cast<std::int64_t>(index_v));
      du -= e.across * position_px / std::hypot(s.px_of[0], s.px_of[1]);
      dv -= e.along * position_px / std::hypot(s.px_of[2], s.px_of[3]);
    }
    const float grow_px = e.width * width_px;
    float inner = 1, outer = 1;
    if (e.missing) {
      inner = outer = 0;
    } else if (shape.kind == ScreenShape::Kind::kDisc) {
      cover_disc(s, du, dv, grow_px, inner, outer);
    } else {
      inner = cover_polygon(s, du, dv, grow_px - half_band_px);
      outer = half_band_px > 0 ? cover_polygon(s, du, dv, grow_px + half_band_px) : inner;
    }
    out.inner[i] = inner;
    out.outer[i] = outer;
  }
}

void ElementPainter::paint_across(const Shape& shape, const Cover& cover,
                                  float (*areas)[kBlockPx]) const {
  const int dye = 1 << shape.shape->color;
  const std::size_t n_sets = sets_.size();
  const float *const inner = cover.inner.data(), *const outer = cover.outer.data();
  if (print_.overlap_um == 0) {
    float* const of_dye = areas[slot_of_set_[static_cast<std::size_t>(dye)]];
    widest([&]() RESEAU_SIM_INLINE {
      for (std::size_t k = 0; k < n_sets; ++k) {
        float* const area = areas[k];
        for (std::size_t i = 0; i < kBlockPx; ++i) area[i] -= inner[i] * area[i];
      }
      for (std::size_t i = 0; i < kBlockPx; ++i) of_dye[i] += inner[i];
    });
    return;
  }
  float after[kDyeSets][kBlockPx];
  widest([&]() RESEAU_SIM_INLINE {
    for (std::size_t k = 0; k < n_sets; ++k) {
      const float* const area = areas[k];
      for (std::size_t i = 0; i < kBlockPx; ++i) after[k][i] = area[i] - outer[i] * area[i];
    }
  });
  for (std::size_t k = 0; k < n_sets && print_.overlap_um != 0; ++k) {
    float* to = after[slot_of_set_[static_cast<std::size_t>(between(sets_[k], dye))]];
    const float* area = areas[k];
    for (std::size_t i = 0; i < kBlockPx; ++i) to[i] += (outer[i] - inner[i]) * area[i];
  }
  float* own = after[slot_of_set_[static_cast<std::size_t>(dye)]];
  for (std::size_t i = 0; i < kBlockPx; ++i) own[i] += inner[i];
  for (std::size_t k = 0; k < n_sets; ++k) std::copy_n(after[k], kBlockPx, areas[k]);
}

void ElementPainter::paint_beside(const Shape& shape, const Cover& cover,
                                  float (*areas)[kBlockPx]) const {
  const int dye = 1 << shape.shape->color;
  const auto slot = [this](int set) { return slot_of_set_[static_cast<std::size_t>(set)]; };
  float* ground = areas[slot(1 << description_.ground)];
  float* own = areas[slot(dye)];
  for (std::size_t i = 0; i < kBlockPx; ++i) {
    const float taken = std::min(cover.inner[i], ground[i]);
    ground[i] -= taken;
    own[i] += taken;
  }
  if (print_.overlap_um == 0) return;
  // The border: what a neighbour shares already first, then the ground.
  for (std::size_t i = 0; i < kBlockPx; ++i) {
    float rest = cover.outer[i] - cover.inner[i];
    if (rest <= 0) continue;
    for (const int set : sets_) {
      if (set == 1 || set == 2 || set == 4 || (set & dye) != 0) continue;
      const float taken = std::min(rest, areas[slot(set)][i]);
      areas[slot(set)][i] -= taken;
      areas[slot(between(set, dye))][i] += taken;
      rest -= taken;
    }
    const float taken = std::min(rest, ground[i]);
    ground[i] -= taken;
    areas[slot(between(1 << description_.ground, dye))][i] += taken;
  }
}

void ElementPainter::paint(std::vector<Shape>& shapes, const Block& block, const float* u,
                           const float* v, float (*areas)[kBlockPx], float* meet) const {
  for (std::size_t k = 0; k < sets_.size(); ++k) {
    std::fill_n(areas[k], kBlockPx, sets_[k] == 1 << description_.ground ? 1.0F : 0.0F);
  }
  Cover covered;
  for (Shape& shape : shapes) {
    cover(shape, block, u, v, covered);
    if (meet != nullptr) find_meetings(covered, areas, meet);
    if (!shape.shape->across) {
      paint_beside(shape, covered, areas);
    } else {
      paint_across(shape, covered, areas);
    }
  }
}

// Counts where an edge of the shape meets another that was painted before.
void ElementPainter::find_meetings(const Cover& cover, const float (*areas)[kBlockPx],
                                   float* meet) const {
  const float *const inner = cover.inner.data(), *const outer = cover.outer.data();
  const std::size_t n_sets = sets_.size();
  widest([=]() RESEAU_SIM_INLINE {
    constexpr float kPart = 1e-3F;
    float largest[kBlockPx] = {};
    for (std::size_t k = 0; k < n_sets; ++k) {
      const float* const area = areas[k];
      for (std::size_t i = 0; i < kBlockPx; ++i) {
        largest[i] = area[i] > largest[i] ? area[i] : largest[i];
      }
    }
    float* __restrict const met = meet;
    for (std::size_t i = 0; i < kBlockPx; ++i) {
      const float edge = outer[i] < kPart ? 0.0F : 1.0F;
      const float open = inner[i] > 1 - kPart ? 0.0F : edge;
      met[i] += largest[i] < 1 - kPart ? open : 0.0F;
    }
  });
}

// The mean of kFine x kFine parts of the cell at (u, v), of four times as many of a tent.
void ElementPainter::divide(std::vector<Shape>& fine, const Block& block, float u, float v,
                            bool tent, std::size_t cell, float (*areas)[kBlockPx]) const {
  static_assert(kFine * kFine == kBlockPx);
  const std::array<float, 4>& step = fine.front().per_cell;
  float sums[kDyeSets] = {}, weights = 0;
  for (int quarter = 0; quarter < (tent ? 4 : 1); ++quarter) {
    std::array<float, kBlockPx> at_u{}, at_v{}, weight{};
    for (int part = 0; part < kBlockPx; ++part) {
      const int row = part / kFine;
      // From the middle, in parts.
      float x = static_cast<float>(part % kFine) + 0.5F, y = static_cast<float>(row) + 0.5F;
      x -= tent && quarter % 2 == 1 ? kFine : tent ? 0.0F : 0.5F * kFine;
      y -= tent && quarter / 2 == 1 ? kFine : tent ? 0.0F : 0.5F * kFine;
      const auto p = static_cast<std::size_t>(part);
      at_u[p] = u + x * step[0] + y * step[2];
      at_v[p] = v + x * step[1] + y * step[3];
      weight[p] = tent ? (kFine - std::abs(x)) * (kFine - std::abs(y)) : 1.0F;
      weights += weight[p];
    }
    float parts[kDyeSets][kBlockPx];
    paint(fine, block, at_u.data(), at_v.data(), parts, nullptr);
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      for (std::size_t p = 0; p < kBlockPx; ++p) sums[k] += weight[p] * parts[k][p];
    }
  }
  for (std::size_t k = 0; k < sets_.size(); ++k) areas[k][cell] = sums[k] / weights;
}

ScreenGradient ElementPainter::gradient_at(double x, double y) const {
  constexpr double kStep = 1.0;
  const ScreenPoint l = screen_.screen_from_scan(x - kStep, y),
                    r = screen_.screen_from_scan(x + kStep, y),
                    b = screen_.screen_from_scan(x, y - kStep),
                    a = screen_.screen_from_scan(x, y + kStep);
  return {(r.u - l.u) / 2, (a.u - b.u) / 2, (r.v - l.v) / 2, (a.v - b.v) / 2};
}

// Cells of a strip of pixels of a block, in the order of the place.
void ElementPainter::paint_strip(Painting& to, const Block& block, int begin, int end,
                                 int block_in_row, PlaneRow& out) const {
  const int per_px = out.per_px(), n = (end - begin) * per_px;
  const auto n_sets = static_cast<int>(sets_.size());
  std::array<float, kBlockPx> u{}, v{};
  float areas[kDyeSets][kBlockPx];
  for (int first = 0; first < n; first += kBlockPx) {
    for (int k = 0; k < kBlockPx; ++k) {
      const int at = std::min(first + k, n - 1);
      const auto i = static_cast<std::size_t>(k);
      block.at(begin + at / per_px, cell_offset_px(at % per_px, per_px), node_px_, u[i], v[i]);
    }
    std::array<float, kBlockPx> meet{};
    paint(to.shapes, block, u.data(), v.data(), areas, to.divides ? meet.data() : nullptr);
    for (int k = 0; k < std::min(kBlockPx, n - first); ++k) {
      const auto i = static_cast<std::size_t>(k);
      if (meet[i] > 0) divide(to.fine, block, u[i], v[i], to.tents, i, areas);
      const int px = block_in_row + begin + (first + k) / per_px;
      for (int set = 0; set < n_sets; ++set) {
        out.phase(set, (first + k) % per_px)[px] = areas[set][k];
      }
    }
  }
}

void ElementPainter::areas(double y, int first_px, int n_px, int per_px, PlaneRow& out,
                           bool tents) const {
  CHECK(n_px >= 1 && per_px >= 1);
  const auto n_sets = static_cast<int>(sets_.size());
  out.resize(first_px, n_px, per_px, n_sets);
  const double cell_px = 1.0 / per_px;
  Painting to;
  to.tents = tents;
  for (const ScreenShape& shape : description_.shapes) {
    to.shapes.emplace_back(&shape, PrintingNoise(print_, mix64(seed_, to.shapes.size())));
  }
  to.fine = to.shapes;  // of parts of a cell
  to.divides = to.shapes.size() > 1 || print_.overlap_um != 0;
  const auto set_ramps = [&](const ScreenGradient& gradient) {
    ramps(gradient, cell_px, tents, to.shapes);
    if (to.divides) ramps(gradient, cell_px / kFine, false, to.fine);
  };
  set_ramps(screen_.scan_gradient());
  Block block;
  std::array<float, kBlockPx> u{}, v{};
  float areas[kDyeSets][kBlockPx];
  for (int at = floor_to_block(first_px); at < first_px + n_px; at += kBlockPx) {
    const int px = at - first_px;  // in the row
    const int begin = std::max(0, -px), end = std::min(kBlockPx, n_px - px);
    place(y, at, block);
    if (strained_ && strip_px_ < kBlockPx) {
      for (int strip = 0; strip < kBlockPx; strip += strip_px_) {
        if (strip + strip_px_ <= begin || strip >= end) continue;
        set_ramps(gradient_at(at + strip + (strip_px_ - 1) / 2.0, y));
        paint_strip(to, block, std::max(strip, begin), std::min(strip + strip_px_, end), px, out);
      }
      continue;
    }
    if (strained_) set_ramps(gradient_at(at + (kBlockPx - 1) / 2.0, y));
    if (end - begin < kBlockPx) {
      paint_strip(to, block, begin, end, px, out);
      continue;
    }
    for (int s = 0; s < per_px; ++s) {
      const double offset = cell_offset_px(s, per_px);
      if (node_px_ == kBlockPx) {
        const double u_step = (block.u[16] - block.u[0]) / kBlockPx;
        const double v_step = (block.v[16] - block.v[0]) / kBlockPx;
        const auto u0 = static_cast<float>(block.u[0] + u_step * offset);
        const auto v0 = static_cast<float>(block.v[0] + v_step * offset);
        for (std::size_t i = 0; i < kBlockPx; ++i) {
          u[i] = u0 + static_cast<float>(static_cast<int>(i)) * static_cast<float>(u_step);
          v[i] = v0 + static_cast<float>(static_cast<int>(i)) * static_cast<float>(v_step);
        }
      } else {
        for (int i = 0; i < kBlockPx; ++i) {
          const auto k = static_cast<std::size_t>(i);
          block.at(i, offset, node_px_, u[k], v[k]);
        }
      }
      std::array<float, kBlockPx> meet{};
      paint(to.shapes, block, u.data(), v.data(), areas, to.divides ? meet.data() : nullptr);
      for (std::size_t i = 0; i < kBlockPx && to.divides; ++i) {
        if (meet[i] > 0) divide(to.fine, block, u[i], v[i], tents, i, areas);
      }
      for (int k = 0; k < n_sets; ++k) std::copy_n(areas[k], kBlockPx, out.phase(k, s) + px);
    }
  }
}

}  // namespace reseau::sim
