// The passes of a simulated PIE unit: SCAN, calibration, lines.
#include <algorithm>
#include <cmath>

#include "drivers/sim/pie/pie_unit.h"
#include "drivers/sim/simulate.h"

namespace reseau::sim::pie {
namespace {

constexpr PieSense kPassDone{0x05, 0x20, 0x00}, kWrongOrder{0x05, 0x2c, 0x00};
constexpr PieSense kWrongLength{0x06, 0x1a, 0x00}, kCalibrateFirst{0x06, 0x82, 0x00};
constexpr std::uint16_t kSkipShadingBit = 0x0008, kCalibrateNowBit = 0x0800;
constexpr int kEntries = 4, kLinesPerEntry = 20;
// What an RPS 7200 sends, dark and light together.
constexpr int kOwnPassTotal = 160;
constexpr int kCursedRead = 64;
constexpr int kMostReadLines = 255;

void append16le(Bytes& to, int v) {
  put8(to, static_cast<std::uint32_t>(v) & 0xff);
  put8(to, static_cast<std::uint32_t>(v) >> 8 & 0xff);
}

// Factor of a gain field, between the steps that SANE's table gives.
double gain_factor(int field) {
  static constexpr std::array kTable{1.000, 1.075, 1.154, 1.251, 1.362, 1.491, 1.653,
                                     1.858, 2.115, 2.458, 2.935, 3.638, 4.627};
  const double at = std::clamp(field, 0, 60) / 5.0;
  const auto i = std::min(static_cast<std::size_t>(at), kTable.size() - 2);
  return kTable[i] + (kTable[i + 1] - kTable[i]) * (at - static_cast<double>(i));
}

}  // namespace

ScanWindow PieUnit::window() const {
  ScanWindow window;
  window.pitch = model_.max_dpi / std::max(mode_.dpi, 1);
  window.x_px = frame_.x0;
  const double moved_px = fine_move_mm_ * model_.max_dpi / 25.4;
  window.y_px = frame_.y0 + frame_counter_ * spec_.film.frame.height_px +
                static_cast<int>(std::lround(moved_px));
  window.width_px = std::max(1, (frame_.x1 - frame_.x0 + 1) / window.pitch);
  window.n_lines = std::max(1, (frame_.y1 - frame_.y0 + 1) / window.pitch);
  return window;
}

std::array<double, 4> PieUnit::levels() const {
  std::array<double, 4> level{};
  for (std::size_t c = 0; c < level.size(); ++c) {
    level[c] = spec_.sensor.clear_level * exposure_[c] / model_.exposure[c] *
               gain_factor(gain_[c]) / gain_factor(model_.gain[c]);
  }
  if (mode_.infrared) level[2] *= model_.infrared_blue;
  return level;
}

PieReply PieUnit::scan(int flag) {
  if (flag != 1 || !frame_set_ || !mode_set_) return check(kWrongOrder);
  if (model_.own_calibration && (mode_.quality & kCalibrateNowBit) != 0) {
    queue_calibration(kOwnPassTotal / 2, true);
    return {.busy_polls = spec_.unit.busy_polls};
  }
  const bool may_skip = calibrated_ && (!model_.confirms_frame || frame_confirmed_);
  const bool skips = (mode_.quality & kSkipShadingBit) != 0 && may_skip;
  if (!skips && model_.own_calibration) return check(kCalibrateFirst);
  if (skips) {
    start_image();
    return {.busy_polls = spec_.unit.busy_polls};
  }
  begin_calibrated_image();
  return check(kCalibrateFirst);
}

void PieUnit::begin_calibrated_image() {
  start_image();
  queue_calibration(kEntries * kLinesPerEntry, false);
}

void PieUnit::queue_calibration(int n_lines, bool with_dark) {
  // Not through film: the light is even, and blue is not that of an infrared pass.
  std::array<double, 4> light = levels();
  if (mode_.infrared) light[2] /= model_.infrared_blue;
  calibration_.clear();
  calibration_at_ = 0;
  const int n_colours = model_.own_calibration ? 3 : 4;
  const std::uint64_t seed = spec_.film.seed + 0x5ade + n_passes_++;
  if (with_dark) {
    append_calibration(sensor_, n_lines, n_colours, {}, spec_.sensor.noise, seed, calibration_);
  }
  append_calibration(sensor_, n_lines, n_colours, light, spec_.sensor.noise, seed + 1,
                     calibration_);
  calibration_lines_ = with_dark ? 2 * n_lines : n_lines;
}

void PieUnit::start_image() {
  PieJob job;
  job.window = window();
  job.x0_px = frame_.x0;
  job.infrared = mode_.infrared;
  job.two_bytes = mode_.two_bytes;
  job.bottom_up = spec_.unit.bottom_up;
  job.filter_offset = std::max(0, model_.filter_offset / job.window.pitch);
  job.level = levels();
  again_left_ = spec_.unit.again;
  stream_ =
      std::make_unique<PieStream>(job, sensor_, film_, spec_.optics, spec_.sensor,
                                  geometry_of(spec_, spec_.sensor), spec_.film.seed, ++n_passes_);
}

PieReply PieUnit::read(int length) {
  if (info_prepared_) {
    info_prepared_ = false;
    if (length != 32) return check(kWrongLength);
    Bytes info{0x95, 0x00, 0x1c, 0x00, kEntries, 6, 4, 0};
    for (const std::uint32_t type : {0x00U, 0x08U, 0x10U, 0x20U}) {
      put8(info, type);
      put8(info, 0x10);
      put8(info, 0x10);
      put8(info, kLinesPerEntry);
      append16le(info, model_.sensor_px);
    }
    return {.next = PieReply::Next::kDataIn, .in = std::move(info)};
  }
  if (length < 1 || length > kMostReadLines) return check(kWrongLength);
  if (again_left_ > 0) {
    --again_left_;
    return {.again = true};
  }
  PieReply reply{.next = PieReply::Next::kDataIn, .busy_polls = spec_.unit.busy_phases};
  if (model_.fragile && length == kCursedRead && pass_open()) {
    reply.silent = true;
    hang();
    return reply;
  }
  if (calibration_lines_ > 0) {
    const std::size_t line_bytes = 2 + 2 * static_cast<std::size_t>(model_.sensor_px);
    if (length > calibration_lines_) {
      calibration_lines_ = 0;
      calibration_.clear();
      return check(kPassDone);
    }
    const std::size_t n_bytes = static_cast<std::size_t>(length) * line_bytes;
    append(reply.in, ByteView(calibration_).subspan(calibration_at_, n_bytes));
    calibration_at_ += n_bytes;
    calibration_lines_ -= length;
    if (calibration_lines_ == 0) calibrated_ = true;
    return reply;
  }
  if (stream_ == nullptr || length > stream_->lines_left()) {
    stream_.reset();
    return check(kPassDone);
  }
  stream_->read(length, reply.in);
  if (stream_->lines_left() == 0) {
    stream_.reset();
    // Not kept after a scan.
    exposure_ = model_.exposure;
    gain_ = model_.gain;
  }
  return reply;
}

PieReply PieUnit::mask(std::size_t length) {
  if (!frame_set_ || !mode_set_) return check(kWrongOrder);
  if (length != static_cast<std::size_t>(model_.sensor_px)) return check(kWrongLength);
  constexpr std::uint8_t kUsed = 0x00, kUnused = 0x70;
  Bytes mask(length, kUnused);
  const ScanWindow w = window();
  for (int i = 0; i < w.width_px; ++i) {
    const int pixel = sensor_.pixel_at(w.x_px + i * w.pitch + (w.pitch - 1) / 2.0);
    mask[static_cast<std::size_t>(pixel)] = kUsed;
  }
  return {.next = PieReply::Next::kDataIn, .in = std::move(mask)};
}

PieReply PieUnit::parameters(std::size_t length) {
  if (length != 18) return check(kWrongLength);
  if (!pass_open()) return check(kWrongOrder);
  const ScanWindow w = window();
  Bytes b;
  append16le(b, w.width_px);
  append16le(b, w.n_lines);
  append16le(b, w.width_px * (mode_.two_bytes ? 2 : 1));
  put8(b, static_cast<std::uint32_t>(model_.filter_offset / w.pitch));
  put8(b, static_cast<std::uint32_t>(2 * model_.filter_offset / w.pitch));
  for (int i = 0; i < 4; ++i) put8(b, 0);  // period
  append16le(b, 0);                        // rate
  append16le(b, stream_ == nullptr ? 0 : std::min(stream_->lines_left(), kMostReadLines));
  append16le(b, 0);
  return {.next = PieReply::Next::kDataIn, .in = std::move(b)};
}

}  // namespace reseau::sim::pie
