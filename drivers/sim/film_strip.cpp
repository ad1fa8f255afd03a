#include "drivers/sim/film_strip.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "drivers/sim/hash.h"
#include "drivers/sim/smooth_step.h"

namespace reseau::sim {
namespace {

constexpr float kDarkBorder = 0.006F;  // density 2.2
constexpr double kFrameEdgePx = 3.0;   // width of the transitions between rebate, border, picture
constexpr double kLeaderPx = 240;      // film before the first frame and after the last

float edge_weight(double distance_px) {
  return smooth_step(static_cast<float>(distance_px / kFrameEdgePx));
}

}  // namespace

FilmStrip::FilmStrip(const FilmSpec& spec)
    : spec_(spec),
      taking_(make_taking(spec.emulsion.ideal_taking)),
      hd_(spec.emulsion.hd),
      margin_px_(spec.frame.rebate_px + spec.frame.border_px) {
  const double width = spec.frame.width_px - 2 * (margin_px_ + spec.frame.outside_px);
  const double height = spec.frame.height_px - 2 * margin_px_;
  CHECK(width > 0 && height > 0 && spec.frame.n_frames >= 1);
  switch (spec.scene) {
    case SceneKind::kChart:
      scenes_.push_back(make_chart_scene(width, height));
      break;
    case SceneKind::kNatural:
      for (int k = 0; k < spec.frame.n_frames; ++k) {
        scenes_.push_back(
            make_natural_scene(width, height, mix64(spec.seed, static_cast<std::uint64_t>(k))));
      }
      break;
    case SceneKind::kSweep:
      scenes_.push_back(make_sweep_scene(width, height));
      break;
    case SceneKind::kEdges:
      scenes_.push_back(make_edges_scene(width, height, spec.edge_angle_deg));
      break;
    case SceneKind::kZone:
      scenes_.push_back(make_zone_scene(width, height, spec.finest_cy_per_px));
      break;
    case SceneKind::kStar:
      scenes_.push_back(make_star_scene(width, height, spec.spokes));
      break;
    case SceneKind::kRazor:
      scenes_.push_back(make_razor_scene(width, height, spec.edge_angle_deg));
      break;
    case SceneKind::kRandom:
      scenes_.push_back(make_random_scene(width, height, spec.seed,
                                          spec.random_cell_um / spec.frame.pixel_um,
                                          spec.edge_angle_deg));
      break;
    case SceneKind::kClear:
      scenes_.push_back(make_clear_scene());
      break;
    case SceneKind::kImage:
      scenes_.push_back(make_image_scene(spec.raster, width, height));
      break;
  }
}

FilmPoint FilmStrip::film_from_scan(double x, double y) const {
  return {spec_.mirrored ? spec_.frame.width_px - 1 - x : x, y};
}

bool FilmStrip::on_film(double y) const {
  const double film_y = film_from_scan(0, y).y;
  const double length = static_cast<double>(spec_.frame.n_frames) * spec_.frame.height_px;
  return film_y > -kLeaderPx && film_y < length + kLeaderPx;
}

Film::Extent FilmStrip::extent() const {
  constexpr int kMarginPx = 160;  // more than any blur and stage error
  return {-kMarginPx, spec_.frame.width_px + kMarginPx};
}

int FilmStrip::frame_at(double film_y) const {
  const double frame = std::floor((film_y + 0.5) / spec_.frame.height_px);
  return static_cast<int>(std::clamp(frame, 0.0, spec_.frame.n_frames - 1.0));
}

double FilmStrip::finest_cy_per_px(double y, double x0, double x1) const {
  const FilmPoint a = film_from_scan(x0, y), b = film_from_scan(x1, y);
  const int frame = frame_at(a.y);
  const Scene& scene = *scenes_[scenes_.size() == 1 ? 0 : static_cast<std::size_t>(frame)];
  const double side = margin_px_ + spec_.frame.outside_px;
  const double top = margin_px_ + static_cast<double>(frame) * spec_.frame.height_px;
  // Border and rebate are even.
  const double left = std::min(a.x, b.x) - side + kFrameEdgePx;
  const double right = std::max(a.x, b.x) - side - kFrameEdgePx;
  const double row = a.y - top;
  if (margin_px_ > 0 &&
      (right < 0 || left > spec_.frame.width_px - 2 * side || row < -kFrameEdgePx ||
       row > spec_.frame.height_px - 2 * margin_px_ + kFrameEdgePx)) {
    return 0;
  }
  // Behind a curve the mean of the light is not that of the transmittance; where light spreads it
  // has become so smooth before that it is.
  const bool curved = !hd_.is_identity() && spec_.emulsion.spread_um == 0;
  constexpr double kCurved = 5;
  return (curved ? kCurved : 1.0) *
         scene.finest_cy_per_px(a.y - top, std::min(a.x, b.x) - side, std::max(a.x, b.x) - side);
}

bool FilmStrip::near_frame(double y, double x0, double x1) const {
  // A border alone is even enough.
  if (spec_.frame.rebate_px == 0) return false;
  const FilmPoint a = film_from_scan(x0, y), b = film_from_scan(x1, y);
  const FrameSpec& frame = spec_.frame;
  const double top = static_cast<double>(frame_at(a.y)) * frame.height_px;
  const double low = std::min(a.x, b.x) + 0.5 - frame.outside_px;
  const double high = std::max(a.x, b.x) + 0.5 - frame.outside_px;
  const double width = frame.width_px - 2.0 * frame.outside_px;
  const double row = a.y - top + 0.5;
  const double margins[] = {frame.rebate_px, margin_px_};
  return std::ranges::any_of(margins, [&](double margin) {
    const auto within = [margin](double from, double to, double length) {
      return (from < margin + kFrameEdgePx && to > margin - kFrameEdgePx) ||
             (from < length - margin + kFrameEdgePx && to > length - margin - kFrameEdgePx);
    };
    return within(low, high, width) || within(row, row, frame.height_px);
  });
}

void FilmStrip::silver_row(double y, double x0, const RgbRow& out) const {
  if (!on_film(y)) {
    for (const std::span<float> band : {out.r, out.g, out.b}) std::ranges::fill(band, 1.0F);
    return;
  }
  exposure(y, x0, 0, false, out);
  for (const std::span<float> band : {out.r, out.g, out.b}) hd_.apply(band);
}

void FilmStrip::exposure_cells(double y, double x0, double side_px, const RgbRow& out,
                               bool tents) const {
  exposure(y, x0, side_px, tents, out);
}

void FilmStrip::exposure(double y, double x0, double side_px, bool tents, const RgbRow& out) const {
  if (!spec_.mirrored) {
    const FilmPoint p = film_from_scan(x0, y);
    exposure_in_film(p.y, p.x, side_px, tents, out);
    return;
  }
  const double step = side_px == 0 ? 1.0 : side_px;
  const FilmPoint last = film_from_scan(x0 + (static_cast<double>(out.r.size()) - 1) * step, y);
  exposure_in_film(last.y, last.x, side_px, tents, out);
  for (const std::span<float> band : {out.r, out.g, out.b}) std::ranges::reverse(band);
}

void FilmStrip::exposure_in_film(double film_y, double film_x0, double side_px, bool tents,
                                 const RgbRow& out) const {
  const int frame = frame_at(film_y);
  const double local_y = film_y - static_cast<double>(frame) * spec_.frame.height_px;
  const Scene& scene = *scenes_[scenes_.size() == 1 ? 0 : static_cast<std::size_t>(frame)];
  const double x0 = film_x0 - margin_px_ - spec_.frame.outside_px;
  if (side_px == 0) {
    scene.row(local_y - margin_px_, x0, out);
  } else if (tents) {
    scene.tents(local_y - margin_px_, x0, side_px, out);
  } else {
    scene.cells(local_y - margin_px_, x0, side_px, out);
  }
  if (!taking_.is_identity && !scene.is_filtered()) apply_taking(out);
  apply_frame(local_y, film_x0, side_px, tents, out);
}

void FilmStrip::apply_taking(const RgbRow& out) const {
  for (std::size_t i = 0; i < out.r.size(); ++i) {
    const std::array<double, 3> light{out.r[i], out.g[i], out.b[i]};
    std::array<float, 3> behind{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& row = taking_.matrix[k];
      behind[k] = static_cast<float>(row[0] * light[0] + row[1] * light[1] + row[2] * light[2]);
    }
    out.r[i] = behind[0];
    out.g[i] = behind[1];
    out.b[i] = behind[2];
  }
}

void FilmStrip::apply_frame(double local_y, double film_x0, double side_px, bool tents,
                            const RgbRow& out) const {
  const FrameSpec& frame = spec_.frame;
  if (margin_px_ == 0) return;
  const double step_px = side_px == 0 ? 1.0 : side_px;
  const double side = frame.outside_px;
  const double border = kFrameEdgePx + step_px;
  const double inside_y = std::min(local_y + 0.5, frame.height_px - 0.5 - local_y);
  const bool row_is_picture = inside_y > margin_px_ + border;
  const double picture_begin = side + margin_px_ + border - 0.5;
  const double picture_end = frame.width_px - 0.5 - side - margin_px_ - border;
  struct Weights {
    float film, picture;  // not rebate; not border either
  };
  // Between two sides, the mean over a cell from the values at three places.
  const float bend = tents ? 1.0F / 12 : 1.0F / 24;
  const auto between = [&](double from_begin, double from_end, double cell_px) {
    const auto weight = [&](double d) {
      if (std::abs(d) > kFrameEdgePx / 2 + cell_px) return d > 0 ? 1.0F : 0.0F;
      const auto at = [](double e) { return edge_weight(e); };
      const float here = at(d);
      if (cell_px == 0) return here;
      return here + (at(d - cell_px) + at(d + cell_px) - 2 * here) * bend;
    };
    const float film = frame.rebate_px > 0 ? weight(from_begin - frame.rebate_px) *
                                                 weight(from_end - frame.rebate_px)
                                           : 1.0F;
    const float picture = frame.border_px > 0
                              ? weight(from_begin - margin_px_) * weight(from_end - margin_px_)
                              : 1.0F;
    return Weights{film, film * picture};
  };
  // Rows that are no means along y become that later.
  const Weights row =
      between(local_y + 0.5, frame.height_px - 0.5 - local_y, has_fine_detail() ? side_px : 0);
  const auto frame_cell = [&](std::size_t i) {
    const double x = film_x0 + static_cast<double>(i) * step_px;
    const Weights column = between(x + 0.5 - side, frame.width_px - 0.5 - side - x, side_px);
    const float film = row.film * column.film, picture = row.picture * column.picture;
    for (const std::span<float> band : {out.r, out.g, out.b}) {
      band[i] = 1 - film * (1 - kDarkBorder) + picture * (band[i] - kDarkBorder);
    }
  };
  // Within the picture there is nothing to do.
  const std::size_t n = out.r.size();
  std::size_t first = n, end = n;
  if (row_is_picture && picture_begin < picture_end) {
    const auto cell_after = [&](double x) {
      const double at = std::clamp((x - film_x0) / step_px, 0.0, static_cast<double>(n));
      return static_cast<std::size_t>(std::ceil(at));
    };
    first = cell_after(picture_begin);
    end = std::max(first, cell_after(picture_end));
  }
  for (std::size_t i = 0; i < first; ++i) frame_cell(i);
  for (std::size_t i = end; i < n; ++i) frame_cell(i);
}

std::array<double, 3> FilmStrip::silver_at(double x, double y) const {
  std::array<float, 3> rgb{};
  silver_row(y, x, {{&rgb[0], 1}, {&rgb[1], 1}, {&rgb[2], 1}});
  return {rgb[0], rgb[1], rgb[2]};
}

std::vector<Patch> FilmStrip::patches() const {
  std::vector<Patch> result;
  const double side = margin_px_ + spec_.frame.outside_px;
  for (int k = 0; k < spec_.frame.n_frames; ++k) {
    const std::size_t scene = scenes_.size() == 1 ? 0 : static_cast<std::size_t>(k);
    const double top = margin_px_ + static_cast<double>(k) * spec_.frame.height_px;
    for (Patch patch : scenes_[scene]->patches()) {
      patch.x0 += side;
      patch.x1 += side;
      if (spec_.mirrored) {
        const double mirror = spec_.frame.width_px - 1;
        const double left = mirror - patch.x1;
        patch.x1 = mirror - patch.x0;
        patch.x0 = left;
      }
      patch.y0 += top;
      patch.y1 += top;
      patch.rgb = silver_of(patch.rgb);
      result.push_back(patch);
    }
  }
  return result;
}

std::vector<Edge> FilmStrip::edges() const {
  std::vector<Edge> result;
  const double side = margin_px_ + spec_.frame.outside_px;
  const double mirror = spec_.frame.width_px - 1;
  for (int k = 0; k < spec_.frame.n_frames; ++k) {
    const std::size_t scene = scenes_.size() == 1 ? 0 : static_cast<std::size_t>(k);
    const double top = margin_px_ + static_cast<double>(k) * spec_.frame.height_px;
    for (Edge edge : scenes_[scene]->edges()) {
      for (double* x : {&edge.x, &edge.x0, &edge.x1}) *x += side;
      for (double* y : {&edge.y, &edge.y0, &edge.y1}) *y += top;
      if (spec_.mirrored) {
        for (double* x : {&edge.x, &edge.x0, &edge.x1}) *x = mirror - *x;
        std::swap(edge.x0, edge.x1);
        std::swap(edge.left, edge.right);
        edge.angle_deg = -edge.angle_deg;
      }
      edge.left = silver_of(edge.left);
      edge.right = silver_of(edge.right);
      result.push_back(edge);
    }
  }
  return result;
}

std::array<double, 3> FilmStrip::silver_of(const std::array<double, 3>& light) const {
  std::array<double, 3> result = light;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!taking_.is_identity) {
      const auto& row = taking_.matrix[k];
      result[k] = row[0] * light[0] + row[1] * light[1] + row[2] * light[2];
    }
    result[k] = hd_.transmittance(result[k]);
  }
  return result;
}

}  // namespace reseau::sim
