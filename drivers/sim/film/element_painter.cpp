#include "drivers/sim/film/element_painter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/check.h"
#include "drivers/sim/film.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/hash.h"

namespace reseau::sim {
namespace {

// Keeps local coordinates positive, whatever sums of them shapes need.
constexpr int kAhead = 8;
constexpr float kPositive = 64;

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
};

struct ElementPainter::Shape {
  const ScreenShape* shape = nullptr;
  PrintingNoise noise;
  std::vector<EdgeRamp> ramps;
  std::vector<float> per_px;     // length of the gradient of each band [1/px]
  std::array<float, 4> px_of{};  // x and y of one period of u, of v
  float cell_px = 0;
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
  strained_ = screen_.largest_strain() > 0.01;
  std::array<bool, kDyeSets> occurs{};
  occurs[static_cast<std::size_t>(1 << description_.ground)] = true;
  for (const ScreenShape& shape : description_.shapes) {
    const std::array<bool, kDyeSets> before = occurs;
    for (std::size_t set = 0; set < kOpaque; ++set) {
      if (before[set] && print_.overlap_um > 0) {
        occurs[set | (std::size_t{1} << static_cast<unsigned>(shape.dye))] = true;
      }
    }
    occurs[std::size_t{1} << static_cast<unsigned>(shape.dye)] = true;
  }
  if (print_.overlap_um < 0) occurs[print_.dark_gaps ? kOpaque : 0] = true;
  slot_of_set_.fill(-1);
  for (int set = 0; set < kDyeSets; ++set) {
    if (!occurs[static_cast<std::size_t>(set)]) continue;
    slot_of_set_[static_cast<std::size_t>(set)] = static_cast<int>(sets_.size());
    sets_.push_back(set);
  }
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

void ElementPainter::ramps(const ScreenGradient& g, double cell_px,
                           std::vector<Shape>& shapes) const {
  const double det = g.u_x * g.v_y - g.u_y * g.v_x;
  for (Shape& shape : shapes) {
    shape.cell_px = static_cast<float>(cell_px);
    shape.px_of = {static_cast<float>(g.v_y / det), static_cast<float>(-g.v_x / det),
                   static_cast<float>(-g.u_y / det), static_cast<float>(g.u_x / det)};
    shape.ramps.clear();
    shape.per_px.clear();
    for (const ShapeBand& band : shape.shape->bands) {
      const double x = band.n_u * g.u_x + band.n_v * g.v_x;
      const double y = band.n_u * g.u_y + band.n_v * g.v_y;
      shape.ramps.emplace_back(x * cell_px, y * cell_px);
      shape.per_px.push_back(static_cast<float>(std::hypot(x, y)));
    }
  }
}

void ElementPainter::cover_disc(const Shape& shape, float du, float dv, float grow_px, float& inner,
                                float& outer) const {
  const float x = du * shape.px_of[0] + dv * shape.px_of[2];
  const float y = du * shape.px_of[1] + dv * shape.px_of[3];
  const auto radius_px =
      static_cast<float>(shape.shape->radius * screen_.spec().period_u_um / pixel_um_);
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

void ElementPainter::cover(Shape& s, const Block& block, const float* u, const float* v,
                           Cover& out) const {
  const ScreenShape& shape = *s.shape;
  const auto half_band_px = static_cast<float>(std::abs(print_.overlap_um) / 2 / pixel_um_);
  const auto cu = static_cast<float>(shape.u), cv = static_cast<float>(shape.v);
  const auto position_px = static_cast<float>(print_.position_noise_um / pixel_um_);
  const auto width_px = static_cast<float>(print_.width_noise_um / 2 / pixel_um_);
  if (shape.kind == ScreenShape::Kind::kLine) {
    const ShapeBand& band = shape.bands[0];
    const auto n_u = static_cast<float>(band.n_u), n_v = static_cast<float>(band.n_v);
    const auto half = static_cast<float>(band.half);
    const float grow = half_band_px * s.per_px[0];
    const float centre = n_u * cu + n_v * cv;
    const EdgeRamp& ramp = s.ramps[0];
    if (!errors_) {
      for (std::size_t i = 0; i < kBlockPx; ++i) {
        const float t = n_u * u[i] + n_v * v[i] - centre;
        const float d = std::abs(t - floor_of(t + 0.5F));
        out.inner[i] = ramp(half - grow - d);
        out.outer[i] = ramp(half + grow - d);
      }
      return;
    }
    const double base = band.n_u * (block.base_u - kAhead) + band.n_v * (block.base_v - kAhead);
    const double along_base =
        band.n_u * (block.base_v - kAhead) - band.n_v * (block.base_u - kAhead);
    const double along_um = band.n_u != 0 ? screen_.spec().period_v_um : screen_.spec().period_u_um;
    const double per_length = along_um / print_.noise_length_um;
    for (std::size_t i = 0; i < kBlockPx; ++i) {
      const float t = n_u * u[i] + n_v * v[i] - centre;
      const float n = floor_of(t + 0.5F);
      const double along = along_base + static_cast<double>(n_u * v[i] - n_v * u[i]);
      const PrintError e = s.noise.line(
          static_cast<std::int64_t>(base) + static_cast<std::int64_t>(n), along * per_length);
      const float d = std::abs(t - n - e.across * position_px * s.per_px[0]);
      const float wide = half + e.width * width_px * s.per_px[0];
      out.inner[i] = e.missing ? 0.0F : ramp(wide - grow - d);
      out.outer[i] = e.missing ? 0.0F : ramp(wide + grow - d);
    }
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
      for (std::size_t b = 0; b < s.ramps.size(); ++b) {
        const ShapeBand& band = shape.bands[b];
        const float distance =
            std::abs(static_cast<float>(band.n_u) * du + static_cast<float>(band.n_v) * dv);
        const float half = static_cast<float>(band.half) + grow_px * s.per_px[b];
        const float grow = half_band_px * s.per_px[b];
        inner *= s.ramps[b](half - grow - distance);
        if (half_band_px > 0) outer *= s.ramps[b](half + grow - distance);
      }
      if (half_band_px == 0) outer = inner;
    }
    out.inner[i] = inner;
    out.outer[i] = outer;
  }
}

void ElementPainter::compose(const Shape& shape, const Cover& cover,
                             float (*areas)[kBlockPx]) const {
  const int dye = 1 << shape.shape->dye;
  const int gap = print_.dark_gaps ? kOpaque : 0;
  std::array<float, kDyeSets> here{};
  for (std::size_t i = 0; i < kBlockPx; ++i) {
    const float inner = cover.inner[i], between = cover.outer[i] - inner;
    const float beneath = 1 - cover.outer[i];
    here.fill(0.0F);
    here[static_cast<std::size_t>(dye)] = inner;
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      const int set = sets_[k];
      const float area = areas[k][i];
      here[static_cast<std::size_t>(set)] += beneath * area;
      const int mixed = print_.overlap_um < 0 || set == kOpaque ? gap : set | dye;
      here[static_cast<std::size_t>(mixed)] += between * area;
    }
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      areas[k][i] = here[static_cast<std::size_t>(sets_[k])];
    }
  }
}

void ElementPainter::areas(double y, int first_px, int n_px, int per_px, PlaneRow& out) const {
  CHECK(first_px % kBlockPx == 0 && n_px % kBlockPx == 0 && per_px >= 1);
  const auto n_sets = static_cast<int>(sets_.size());
  out.resize(first_px, n_px, per_px, n_sets);
  const double cell_px = 1.0 / per_px;
  std::vector<Shape> shapes;
  for (const ScreenShape& shape : description_.shapes) {
    shapes.push_back({&shape, PrintingNoise(print_, mix64(seed_, shapes.size())), {}, {}, {}, 0});
  }
  ramps(screen_.scan_gradient(), cell_px, shapes);
  const bool simple = print_.overlap_um == 0;
  Block block;
  Cover covered;
  std::array<float, kBlockPx> u{}, v{};
  float areas[kDyeSets][kBlockPx];
  for (int px = 0; px < n_px; px += kBlockPx) {
    place(y, first_px + px, block);
    if (strained_) {
      const double x = first_px + px + kBlockPx / 2.0, step = 1.0;
      const ScreenPoint l = screen_.screen_from_scan(x - step, y),
                        r = screen_.screen_from_scan(x + step, y),
                        b = screen_.screen_from_scan(x, y - step),
                        a = screen_.screen_from_scan(x, y + step);
      ramps({(r.u - l.u) / 2, (a.u - b.u) / 2, (r.v - l.v) / 2, (a.v - b.v) / 2}, cell_px, shapes);
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
        for (std::size_t i = 0; i < kBlockPx; ++i) {
          const auto& cu = block.cubic_u[i / 4];
          const auto& cv = block.cubic_v[i / 4];
          const double t = (static_cast<double>(i % 4) + offset) / 4;
          u[i] = static_cast<float>(cu[0] + t * (cu[1] + t * (cu[2] + t * cu[3])));
          v[i] = static_cast<float>(cv[0] + t * (cv[1] + t * (cv[2] + t * cv[3])));
        }
      }
      for (int k = 0; k < n_sets; ++k) {
        const bool ground = sets_[static_cast<std::size_t>(k)] == 1 << description_.ground;
        std::fill_n(areas[k], kBlockPx, ground ? 1.0F : 0.0F);
      }
      for (Shape& shape : shapes) {
        cover(shape, block, u.data(), v.data(), covered);
        if (simple) {
          const int own = slot_of_set_[static_cast<std::size_t>(1 << shape.shape->dye)];
          for (int k = 0; k < n_sets; ++k) {
            for (std::size_t i = 0; i < kBlockPx; ++i) {
              areas[k][i] = areas[k][i] - covered.inner[i] * areas[k][i];
            }
          }
          for (std::size_t i = 0; i < kBlockPx; ++i) areas[own][i] += covered.inner[i];
        } else {
          compose(shape, covered, areas);
        }
      }
      for (int k = 0; k < n_sets; ++k) std::copy_n(areas[k], kBlockPx, out.phase(k, s) + px);
    }
  }
}

}  // namespace reseau::sim
