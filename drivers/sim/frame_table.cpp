#include "drivers/sim/frame_table.h"

#include <algorithm>

#include "drivers/sim/unit_model.h"

namespace reseau::sim {

FrameTable::FrameTable(const UnitModel& model, int capacity, std::uint32_t frame_height)
    : capacity_(capacity),
      height_(frame_height),
      pulse_px_(static_cast<std::uint32_t>(model.pulse_px)),
      step_px_(static_cast<std::uint32_t>(model.thumbnail_step_px)) {
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(capacity); ++k) {
    frames_.push_back({k * height_, 8 * k, 0, 0});
  }
}

Bytes FrameTable::frames_reply() const {
  const auto n = static_cast<std::uint32_t>(frames_.size());
  Bytes reply;
  put16(reply, 0x8f00);
  put32(reply, 8 * n + 4);
  put16(reply, 8 * n + 2);
  put8(reply, n);
  put8(reply, 0);
  for (const FrameRecord& frame : frames_) {
    put32(reply, frame.address);
    put16(reply, frame.perforation);
    put8(reply, frame.pattern);
    put8(reply, frame.pulse);
  }
  return reply;
}

Bytes FrameTable::perforations_reply(bool swapped) const {
  const auto n = static_cast<std::uint32_t>(line_positions_.size());
  Bytes reply;
  put16(reply, swapped ? 0x008e : 0x8e00);
  put32(reply, 4 * n + 4);
  put24(reply, 4 * n + 1);
  put8(reply, 4);
  for (const std::uint32_t position : line_positions_) {
    const std::uint32_t pulses = position / pulse_px_ % 108;
    put16(reply, position / pulse_px_ / 108);
    put8(reply, pulses / 22 | (pulses < 54 ? 0x80U : 0U));
    put8(reply, pulses % 22);
  }
  return reply;
}

Sense FrameTable::set_frames(ByteView data) {
  if (data.size() < 4) return kBadParameter;
  const std::uint32_t n = data[2];
  if (n < 1 || n > static_cast<std::uint32_t>(capacity_) || get16(data, 0) != 8 * n + 2 ||
      data.size() != 8 * n + 4) {
    return kBadParameter;
  }
  std::vector<FrameRecord> frames;
  for (std::size_t at = 4; at < data.size(); at += 8) {
    frames.push_back({get32(data, at), get16(data, at + 4), data[at + 6], data[at + 7]});
  }
  frames_ = std::move(frames);
  from_host_ = true;
  return kGood;
}

Sense FrameTable::set_rectangles(ByteView data) {
  constexpr std::uint32_t kMost = 40;
  if (data.size() < 4) return kBadParameter;
  const std::uint32_t n = data[2];
  // The length counts itself and everything.
  if (n < 1 || n > kMost || get16(data, 0) != 16 * n + 4 || data.size() != 16 * n + 4) {
    return kBadParameter;
  }
  rectangles_.assign(data.begin(), data.end());
  return kGood;
}

Bytes FrameTable::rectangles_reply() const {
  const Bytes none{0, 4, 0, 0};
  const Bytes& data = rectangles_.empty() ? none : rectangles_;
  Bytes reply;
  put16(reply, 0x8800);
  put32(reply, static_cast<std::uint32_t>(data.size()));
  append(reply, data);
  return reply;
}

void FrameTable::index(int n_lines, std::uint32_t film_length) {
  line_positions_.clear();
  for (int line = 0; line < n_lines; ++line) {
    const auto position = static_cast<std::uint32_t>(line) * step_px_;
    if (position >= film_length) break;
    line_positions_.push_back(position);
  }
}

std::optional<FrameRecord> FrameTable::frame_of(std::uint32_t address) const {
  std::optional<FrameRecord> best;
  for (const FrameRecord& frame : frames_) {
    const bool inside = address >= frame.address && address < frame.address + height_;
    if (inside && (!best || frame.address > best->address)) best = frame;
  }
  return best;
}

bool FrameTable::contains(std::uint32_t address) const { return frame_of(address).has_value(); }

std::uint32_t FrameTable::film_position(std::uint32_t address) const {
  const std::optional<FrameRecord> frame = frame_of(address);
  if (!from_host_ || !frame) return address;
  // Records as at power on stand where they say, whoever sent them.
  const bool as_at_power_on = frame->pattern == 0 && frame->pulse == 0 &&
                              frame->address * 8 == frame->perforation * height_;
  if (as_at_power_on) return address;
  return frame->film_position(pulse_px_) + (address - frame->address);
}

}  // namespace reseau::sim
