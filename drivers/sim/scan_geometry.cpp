#include "drivers/sim/scan_geometry.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace reseau::sim {

SensorLine sensor_line(double y, const SensorSpec& sensor) {
  if (sensor.n_lines <= 1) return {0, y};
  const double gap = sensor.line_gap_px, block = sensor.n_lines * gap;
  // Half a line's tolerance, so that places between two lines belong to one of them.
  const double from_origin = y - sensor.line_origin_px + 0.5;
  const double in_block = from_origin - std::floor(from_origin / block) * block;
  const int index = std::clamp(static_cast<int>(in_block / gap), 0, sensor.n_lines - 1);
  return {index, y - index * gap};
}

ScanGeometry::ScanGeometry() : ScanGeometry({}, {}, {}, 1, 0) {}

ScanGeometry::ScanGeometry(const OpticsSpec& optics, const StageSpec& stage,
                           const SensorSpec& sensor, int field_px, std::uint64_t seed)
    : optics_(optics),
      sensor_(sensor),
      stage_(stage, seed),
      field_px_(field_px),
      axis_px_((field_px - 1) / 2.0),
      half_px_(field_px / 2.0) {
  CHECK(field_px >= 1 && sensor.n_lines >= 1 && sensor.line_gap_px >= 1);
  const bool staggered =
      sensor.n_lines > 1 && (sensor.stagger_x_px != 0 || sensor.stagger_y_px != 0);
  is_perfect_ = !stage_.moves() && !staggered && optics.distortion == 0;
  for (std::size_t c = 0; c < 4; ++c) {
    is_perfect_ = is_perfect_ && optics.stretch_px[c] == 0 && optics.shift_x_px[c] == 0 &&
                  optics.shift_y_px[c] == 0;
  }
}

double ScanGeometry::distorted(double x) const {
  if (optics_.distortion == 0) return x;
  const double r = rho(x);
  return axis_px_ + (x - axis_px_) * (1 + optics_.distortion * r * r);
}

double ScanGeometry::through_lens(int channel, double x) const {
  const auto c = static_cast<std::size_t>(channel);
  double at = distorted(x) + optics_.shift_x_px[c];
  if (optics_.stretch_px[c] != 0) at += optics_.stretch_px[c] * rho(x);
  return at;
}

StageError ScanGeometry::line_error(double y) const {
  const SensorLine line = sensor_line(y, sensor_);
  StageError error = stage_.error_at(line.stage_y);
  error.x += line.index * sensor_.stagger_x_px;
  error.y += line.index * sensor_.stagger_y_px;
  return error;
}

ScanPlace ScanGeometry::place(double x, double y) const {
  if (is_perfect_) return {x, y};
  const StageError error = line_error(y);
  return {distorted(x) + error.x, y + error.y};
}

ScanPlace ScanGeometry::place(int channel, double x, double y) const {
  if (is_perfect_) return {x, y};
  const StageError error = line_error(y);
  const double shift_y = optics_.shift_y_px[static_cast<std::size_t>(channel)];
  return {through_lens(channel, x) + error.x, y + error.y + shift_y};
}

ScanPlace ScanGeometry::largest() const {
  const StageError stage = stage_.largest();
  const int others = sensor_.n_lines - 1;
  ScanPlace most{
      stage.x + others * std::abs(sensor_.stagger_x_px) + std::abs(optics_.distortion) * half_px_,
      stage.y + others * std::abs(sensor_.stagger_y_px)};
  double lateral_x = 0, lateral_y = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    lateral_x =
        std::max(lateral_x, std::abs(optics_.stretch_px[c]) + std::abs(optics_.shift_x_px[c]));
    lateral_y = std::max(lateral_y, std::abs(optics_.shift_y_px[c]));
  }
  return {most.x + lateral_x, most.y + lateral_y};
}

}  // namespace reseau::sim
