#include "drivers/sim/film_strip.h"

#include <algorithm>
#include <cmath>

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
    : spec_(spec), margin_px_(spec.frame.rebate_px + spec.frame.border_px) {
  const double width = spec.frame.width_px - 2 * margin_px_;
  const double height = spec.frame.height_px - 2 * margin_px_;
  CHECK(width > 0 && height > 0 && spec.frame.n_frames >= 1);
  if (spec.scene == SceneKind::kChart) {
    scenes_.push_back(make_chart_scene(width, height));
  } else {
    for (int k = 0; k < spec.frame.n_frames; ++k) {
      scenes_.push_back(
          make_natural_scene(width, height, mix64(spec.seed, static_cast<std::uint64_t>(k))));
    }
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

void FilmStrip::silver_row(double y, double x0, const RgbRow& out) const {
  if (!on_film(y)) {
    for (const std::span<float> band : {out.r, out.g, out.b}) std::ranges::fill(band, 1.0F);
    return;
  }
  if (!spec_.mirrored) {
    const FilmPoint p = film_from_scan(x0, y);
    silver_in_film(p.y, p.x, out);
    return;
  }
  const FilmPoint last = film_from_scan(x0 + static_cast<double>(out.r.size()) - 1, y);
  silver_in_film(last.y, last.x, out);
  for (const std::span<float> band : {out.r, out.g, out.b}) std::ranges::reverse(band);
}

void FilmStrip::silver_in_film(double film_y, double film_x0, const RgbRow& out) const {
  const int frame = frame_at(film_y);
  const double local_y = film_y - static_cast<double>(frame) * spec_.frame.height_px;
  const std::size_t scene = scenes_.size() == 1 ? 0 : static_cast<std::size_t>(frame);
  scenes_[scene]->row(local_y - margin_px_, film_x0 - margin_px_, out);
  apply_frame(local_y, film_x0, out);
}

void FilmStrip::apply_frame(double local_y, double film_x0, const RgbRow& out) const {
  const FrameSpec& frame = spec_.frame;
  if (margin_px_ == 0) return;
  const double inside_y = std::min(local_y + 0.5, frame.height_px - 0.5 - local_y);
  const bool row_is_picture = inside_y > margin_px_ + kFrameEdgePx;
  const double picture_begin = margin_px_ + kFrameEdgePx - 0.5;
  const double picture_end = frame.width_px - 0.5 - margin_px_ - kFrameEdgePx;
  for (std::size_t i = 0; i < out.r.size(); ++i) {
    const double x = film_x0 + static_cast<double>(i);
    if (row_is_picture && x > picture_begin && x < picture_end) continue;
    const double inside = std::min({x + 0.5, frame.width_px - 0.5 - x, inside_y});
    const float not_rebate = frame.rebate_px > 0 ? edge_weight(inside - frame.rebate_px) : 1.0F;
    const float picture = frame.border_px > 0 ? edge_weight(inside - margin_px_) : not_rebate;
    for (const std::span<float> band : {out.r, out.g, out.b}) {
      const float exposed = kDarkBorder + picture * (band[i] - kDarkBorder);
      band[i] = 1.0F + not_rebate * (exposed - 1.0F);
    }
  }
}

std::array<double, 3> FilmStrip::silver_at(double x, double y) const {
  std::array<float, 3> rgb{};
  silver_row(y, x, {{&rgb[0], 1}, {&rgb[1], 1}, {&rgb[2], 1}});
  return {rgb[0], rgb[1], rgb[2]};
}

std::vector<Patch> FilmStrip::patches() const {
  std::vector<Patch> result;
  for (int k = 0; k < spec_.frame.n_frames; ++k) {
    const std::size_t scene = scenes_.size() == 1 ? 0 : static_cast<std::size_t>(k);
    for (Patch patch : scenes_[scene]->patches()) {
      const double top = margin_px_ + static_cast<double>(k) * spec_.frame.height_px;
      double left = patch.x0 + margin_px_, right = patch.x1 + margin_px_;
      if (spec_.mirrored) {
        const double mirror = spec_.frame.width_px - 1;
        left = mirror - (patch.x1 + margin_px_);
        right = mirror - (patch.x0 + margin_px_);
      }
      patch.x0 = left;
      patch.x1 = right;
      patch.y0 += top;
      patch.y1 += top;
      result.push_back(patch);
    }
  }
  return result;
}

}  // namespace reseau::sim
