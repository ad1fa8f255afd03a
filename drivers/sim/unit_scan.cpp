// SCAN, READ and SEND of a unit.
#include <algorithm>
#include <cmath>
#include <string_view>
#include <variant>

#include "core/base/check.h"
#include "drivers/sim/sensor_curves.h"
#include "drivers/sim/simulate.h"
#include "drivers/sim/unit.h"

namespace reseau::sim {
namespace {

// Blur of a step away from the best focus, added in quadrature [px].
constexpr double kBlurPerFocusStep = 0.015;
// The same for a lens: at f/8 it widens the blur disc as much.
constexpr double kMicrometrePerFocusStep = 3;
constexpr std::uint8_t kImage = 0x00, kLut = 0x03, kCooperation = 0x87, kWhiteBalance = 0x8c;
constexpr std::uint8_t kRectangles = 0x88, kPerforations = 0x8e, kFrames = 0x8f, kCurves = 0x91,
                       kLeak = 0x93;

std::optional<std::size_t> plane_of_colour(int colour) {
  switch (colour) {
    case 1:
      return 0;
    case 2:
      return 1;
    case 3:
      return 2;
    case 9:
      return 3;
    default:
      return std::nullopt;
  }
}

// Size code that a READ or SEND of this type must carry; empty for the image, where both occur.
std::optional<int> element_code(std::uint8_t type) {
  switch (type) {
    case kLut:
    case kCurves:
    case kLeak:
      return 1;
    case kCooperation:
    case kPerforations:
      return 0;
    case kWhiteBalance:
    case kRectangles:
    case kFrames:
      return 3;
    default:
      return std::nullopt;
  }
}

Bytes with_header(std::uint8_t type, std::uint8_t bits, ByteView data) {
  Bytes reply;
  put8(reply, type);
  put8(reply, bits);
  put32(reply, static_cast<std::uint32_t>(data.size()));
  append(reply, data);
  return reply;
}

}  // namespace

void Unit::end_scan() {
  stream_.reset();
  unread_.clear();
  requests_.clear();
  raised_.reset();
  requests_open_ = false;
}

Sense Unit::scan(ByteView ids) {
  std::vector<int> list(ids.begin(), ids.end());
  if (list.empty()) list = scan_ids_;
  if (!requests_open_ || list != scan_ids_) {
    end_scan();
    std::variant<ScanLayout, Sense> plan =
        plan_scan(*model_, adapter_, windows_, list, mud_, packet_bytes_);
    if (const Sense* refused = std::get_if<Sense>(&plan)) return *refused;
    if (!adapter_.film_present) return without_film();
    scan_ids_ = list;
    requests_open_ = true;
    for (CooperationRequest& request : cooperation_requests(std::get<ScanLayout>(plan))) {
      requests_.push_back(std::move(request));
    }
  }
  // Each job is asked for once: a host that repeats SCAN without having read the record (SANE) has
  // taken note of it.
  raised_.reset();
  if (!requests_.empty()) {
    raised_ = std::move(requests_.front());
    requests_.pop_front();
    return raised_->sense;
  }
  requests_open_ = false;
  return start_scan(
      std::get<ScanLayout>(plan_scan(*model_, adapter_, windows_, list, mud_, packet_bytes_)));
}

Sense Unit::start_scan(const ScanLayout& layout) {
  const auto end = static_cast<std::uint32_t>(layout.y_px + layout.n_lines * layout.pitch);
  if (model_->stage_can_jam && !layout.thumbnail && end > adapter_.max_y_origin() + 1) {
    jammed_ = true;
    return kGood;  // what happens shows at the next poll
  }
  ScanWindow window;
  window.x_px = layout.x_px;
  window.y_px =
      layout.thumbnail || adapter_.holder() || !adapter_.strip()
          ? layout.y_px - adapter_.holder_top()
          : static_cast<int>(frames_.film_position(static_cast<std::uint32_t>(layout.y_px)));
  window.width_px = layout.width_px;
  window.n_lines = layout.wire_lines();
  window.pitch = layout.pitch;
  if (layout.thumbnail) window.line_step = model_->thumbnail_step_px;

  OpticsSpec optics = spec_.optics;
  const int focus_steps = focus_ - kBestFocus;
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (optics.f_number[c] > 0) continue;
    optics.blur_px[c] = std::hypot(optics.blur_px[c], kBlurPerFocusStep * focus_steps);
  }
  optics.focus_um += kMicrometrePerFocusStep * focus_steps;
  SensorSpec sensor = spec_.sensor;
  sensor.adc_bits = model_->adc_bits;
  sensor.n_lines = layout.sensor_lines;
  sensor.line_gap_px = layout.sensor_lines > 1 ? model_->line_gap : 1;
  // Units that measure how their lines differ have lines that differ.
  sensor.line_response = model_->has_ccd_curves ? spec_.unit.line_response : 0;
  sensor.one_response = model_->sensor_lines > 2;
  sensor.line_origin_px = window.y_px;
  SensorPass pass;
  pass.seed = spec_.film.seed;
  pass.pass = ++n_passes_;
  pass.field_px = spec_.film.frame.width_px;
  for (std::size_t c = 0; c < kChannels; ++c) {
    pass.level[c] =
        spec_.sensor.clear_level * layout.exposure[c] / model_->white_balance_exposure[c];
  }
  stream_ = std::make_unique<ImageStream>(layout, film_, optics, sensor, pass, window,
                                          geometry_of(spec_, sensor), luts_);
  operation_ = Operation{kOperationRuns, spec_.unit.busy_polls, 0};
  return kGood;
}

CommandReply Unit::read(ByteView cdb) {
  const std::uint8_t type = cdb[2];
  const std::size_t length = get24(cdb, 6);
  if (type == kImage) return read_image(length);
  const std::optional<int> code = element_code(type);
  if (!code || *code != cdb[5]) return CommandReply::status(kBadCdb);
  std::optional<Bytes> reply = read_data(type, cdb[4], length);
  if (!reply) return CommandReply::status(kBadCdb);
  if (length == 0) return CommandReply::status(kGood);
  const bool short_read = reply->size() < length;
  reply->resize(std::min(reply->size(), length));
  return {.next = CommandReply::Next::kDataIn,
          .in = std::move(*reply),
          .sense = short_read ? kLessData : kGood};
}

CommandReply Unit::read_any_length(std::size_t length) {
  while (unread_.size() < length && stream_->records_left() > 0) stream_->read(1, unread_);
  CommandReply reply{.next = CommandReply::Next::kDataIn};
  const std::size_t n = std::min(length, unread_.size());
  const auto end = unread_.begin() + static_cast<std::ptrdiff_t>(n);
  reply.in.assign(unread_.begin(), end);
  unread_.erase(unread_.begin(), end);
  if (n < length) reply.sense = kLessData;
  if (unread_.empty() && stream_->records_left() == 0) end_scan();
  return reply;
}

CommandReply Unit::read_image(std::size_t length) {
  if (!stream_) return CommandReply::status(kBadSequence);
  if (length == 0) return CommandReply::status(kGood);
  constexpr int kWholeLines = 0x02;
  const bool any_length = (from_hex(model_->page_c1)[4] & kWholeLines) == 0;
  if (any_length && !stream_->layout().thumbnail) return read_any_length(length);
  // A length that ends inside a line is rounded up, which puts the host out of step.
  const std::size_t record = stream_->layout().record_bytes();
  const std::size_t wanted = (length + record - 1) / record;
  auto left = static_cast<std::size_t>(stream_->records_left());
  if (spec_.unit.early_end && stream_->layout().thumbnail) {
    // The film is at its end before the window is.
    const int film_lines =
        spec_.film.frame.n_frames * model_->frame_height_px / model_->thumbnail_step_px + 1;
    const int done = stream_->layout().n_records() - stream_->records_left();
    left = std::min(left, static_cast<std::size_t>(std::max(film_lines - done, 0)));
  }
  CommandReply reply{.next = CommandReply::Next::kDataIn};
  reply.busy_phases = spec_.unit.busy_phases;
  reply.line_bytes = record;
  stream_->read(static_cast<int>(std::min(wanted, left)), reply.in);
  if (wanted > left) reply.sense = kLessData;
  if (stream_->records_left() > 0 && reply.sense.good()) return reply;
  if (stream_->layout().thumbnail) {
    adapter_.counted_frames = std::min(spec_.film.frame.n_frames, adapter_.capacity());
    frames_.index(stream_->layout().n_lines,
                  static_cast<std::uint32_t>(spec_.film.frame.n_frames) * adapter_.frame_height());
    attend(kInquiryChanged);
  }
  end_scan();
  return reply;
}

std::optional<Bytes> Unit::read_data(std::uint8_t type, int colour, std::size_t length) {
  const std::optional<std::size_t> plane = plane_of_colour(colour);
  switch (type) {
    case kLut: {
      if (!model_->has_lut || !plane) return std::nullopt;
      Bytes data;
      const std::uint32_t entries = 1U << model_->adc_bits;
      for (std::uint32_t v = 0; v < entries; ++v) {
        put16(data, luts_[*plane].empty() ? v : luts_[*plane][v]);
      }
      return data;
    }
    case kCooperation: {
      if (!raised_) return with_header(kCooperation, 0x08, Bytes(12, 0));
      return raised_->reply;
    }
    case kWhiteBalance: {
      if (!plane) return std::nullopt;
      Bytes data;
      put32(data, model_->white_balance_exposure[*plane]);
      return with_header(kWhiteBalance, 0x20, data);
    }
    case kPerforations:
      return frames_.perforations_reply(length != 9);
    case kRectangles:
      if (!adapter_.holder()) return frames_.rectangles_reply();
      if (rectangles_.empty()) return std::nullopt;
      return with_header(kRectangles, 0x20, rectangles_);
    case kFrames:
      return frames_.frames_reply();
    case kCurves: {
      if (!model_->has_ccd_curves || !plane) return std::nullopt;
      // Identical for all colours on an LS-9000.
      const std::size_t measured = model_->sensor_lines > 2 ? 1 : *plane;
      return with_header(kCurves, 0x00,
                         curve_data(measured, model_->sensor_lines,
                                    model_->sensor_lines > 2 ? 10 : 2, spec_.unit.line_response));
    }
    case kLeak:
      return with_header(kLeak, 0x00, from_hex("035F 033A 026D"));
    default:
      return std::nullopt;
  }
}

CommandReply Unit::send(ByteView cdb) const {
  const std::uint8_t type = cdb[2];
  const std::size_t length = get24(cdb, 6);
  const std::optional<int> code = element_code(type);
  const bool lut = type == kLut && model_->has_lut && plane_of_colour(cdb[4]) &&
                   length == std::size_t{2} << model_->adc_bits;
  const bool frames =
      (type == kFrames || type == kRectangles) && adapter_.strip() && !adapter_.holder();
  const bool rectangles = type == kRectangles && adapter_.holder() && !model_->page_e1.empty();
  if (!code || *code != cdb[5] || (!lut && !frames && !rectangles)) {
    return CommandReply::status(kBadCdb);
  }
  if (length == 0) return CommandReply::status(kGood);
  return {.next = CommandReply::Next::kDataOut, .out_bytes = length};
}

Sense Unit::send_data(std::uint8_t type, int colour, ByteView data) {
  if (type == kFrames) return frames_.set_frames(data);
  if (type == kRectangles) {
    if (!adapter_.holder()) return frames_.set_rectangles(data);
    const bool counted = data.size() >= 20 && data[2] >= 1 && data[2] <= 40 &&
                         data.size() == 4 + 16 * std::size_t{data[2]} &&
                         get16(data, 0) == data.size();
    if (!counted) return kBadParameter;
    rectangles_.assign(data.begin(), data.end());
    return kGood;
  }
  const std::optional<std::size_t> plane = plane_of_colour(colour);
  CHECK(plane.has_value());
  std::vector<std::uint16_t> table;
  const std::uint32_t full = (1U << model_->adc_bits) - 1;
  for (std::size_t at = 0; at + 1 < data.size(); at += 2) {
    if (get16(data, at) > full) return kBadParameter;
    table.push_back(static_cast<std::uint16_t>(get16(data, at)));
  }
  luts_[*plane] = std::move(table);
  return kGood;
}

}  // namespace reseau::sim
