#include "drivers/sim/windows.h"

#include <algorithm>

namespace reseau::sim {
namespace {

constexpr std::size_t kDescriptor = 50;
constexpr std::size_t kHeader = 8;

// Index of red, green, blue, infrared for a window id; the default window is the green one.
std::size_t exposure_index(int id) {
  switch (id) {
    case 1:
    case 4:
      return 0;
    case 3:
      return 2;
    case 9:
      return 3;
    default:
      return 1;
  }
}

Window power_on_window(const UnitModel& model, int id) {
  const bool visible_part = id == 0 || id == 4;
  Window w;
  w.raw.assign(kDescriptor, 0);
  w.raw[0] = static_cast<std::uint8_t>(id);
  set16(w.raw, 2, static_cast<std::uint32_t>(model.optical_dpi));
  set16(w.raw, 4, static_cast<std::uint32_t>(model.optical_dpi));
  set32(w.raw, 14, visible_part ? 0x0480U : static_cast<std::uint32_t>(model.sensor_px));
  set32(w.raw, 18, visible_part ? 0x06c2U : static_cast<std::uint32_t>(model.frame_height_px));
  w.raw[25] = 0x02;
  w.raw[26] = static_cast<std::uint8_t>(model.adc_bits);
  w.raw[41] = visible_part ? 0x01 : 0x81;
  w.raw[42] = 0x01;
  w.raw[43] = 0x02;
  w.raw[44] = 0x02;
  w.raw[45] = 0xff;
  set32(w.raw, 46, model.default_exposure[exposure_index(id)]);
  return w;
}

bool one_bit_of(std::uint8_t value, std::uint8_t allowed) {
  return value != 0 && (value & (value - 1)) == 0 && (value & allowed) == value;
}

}  // namespace

int pitch_for_dpi(const UnitModel& model, int dpi) {
  int pitch = std::max(model.optical_dpi / dpi, 1);
  if (model.pitch_rule == PitchRule::kOneOrEven && pitch > 1) pitch -= pitch % 2;
  if (model.pitch_rule == PitchRule::kDivisorsOfGap) {
    while (model.line_gap % pitch != 0) --pitch;
  }
  return pitch;
}

WindowStore::WindowStore(const UnitModel& model) : model_(&model) {
  for (const int id : {0, 1, 2, 3, 4, 9}) windows_.emplace(id, power_on_window(model, id));
}

Sense WindowStore::set(ByteView list, const AdapterState& adapter, int mud, bool infrared_bit) {
  if (list.size() < kHeader + 1) return kBadParameter;
  const ByteView fields = list.subspan(kHeader);
  if (get16(list, 6) != fields.size()) return kBadParameter;
  const int id = fields[0];
  const auto stored = windows_.find(id);
  if (stored == windows_.end()) return kBadParameter;
  // The first generation knows no flags in the control byte.
  if (id == 9 && !infrared_bit && !model_->page_d1.empty()) return kBadCdb;
  Window window = stored->second;
  const std::uint32_t old_exposure = window.exposure();
  const std::size_t known = std::min(fields.size(), kDescriptor);
  std::copy_n(fields.begin(), known, window.raw.begin());
  if (window.exposure() == 0) set32(window.raw, 46, old_exposure);
  if (window.raw[45] == 0) window.raw[45] = 0xff;
  const Sense sense = check(window, adapter, mud);
  if (sense.good() || sense == kRounded) stored->second = window;
  return sense;
}

Sense WindowStore::check(Window& window, const AdapterState& adapter, int mud) const {
  const Bytes& raw = window.raw;
  const std::uint8_t colour_order = raw[40] & 0x0f;
  const bool order_known = colour_order <= 4 || colour_order == 9;
  const bool depth_known =
      std::ranges::find(model_->depths_bits, window.depth_bits()) != model_->depths_bits.end();
  const bool rest_zero =
      std::all_of(raw.begin() + 27, raw.begin() + 40, [](std::uint8_t byte) { return byte == 0; });
  const std::uint8_t mode = raw[43];
  if (!order_known || !depth_known || !rest_zero || (raw[40] >> 4 > 0 && !model_->multi_reading) ||
      (raw[41] & 0x1e) != 0 || !one_bit_of(raw[42], model_->page_d1.empty() ? 0x01 : 0x03) ||
      mode == 0 || (mode & ~model_->scan_modes) != 0 ||
      !one_bit_of(raw[44], model_->interleavings) ||
      (window.composition() != 0x02 && window.composition() != 0x05) ||
      window.exposure() > kExposureMax) {
    return kBadParameter;
  }
  // Limits hold in optical pixels whatever the measurement unit is.
  const int optical_dpi = model_->optical_dpi;
  const auto optical = [mud, optical_dpi](std::uint32_t v) {
    return static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(optical_dpi) /
           static_cast<std::uint64_t>(mud);
  };
  const std::uint64_t max_height =
      window.thumbnail() ? adapter.max_y_origin() : std::uint64_t{adapter.frame_height()};
  const bool across = optical(window.x_origin()) + optical(window.width()) > adapter.x_end() ||
                      optical(window.width()) > adapter.max_width();
  const bool along =
      optical(window.y_origin()) > adapter.max_y_origin() || optical(window.height()) > max_height;
  if (across || (along && !model_->stage_can_jam)) return kBadParameter;
  if (window.thumbnail()) {
    const int dpi = model_->thumbnail_dpi;
    if (window.x_dpi() != dpi || (!adapter.strip() && !adapter.holder())) return kBadParameter;
    set16(window.raw, 4, static_cast<std::uint32_t>(dpi));
    return kGood;
  }
  if (window.x_dpi() < model_->min_dpi || window.x_dpi() > optical_dpi) return kBadParameter;
  const int pitch = pitch_for_dpi(*model_, window.x_dpi());
  const int granted = optical_dpi / pitch;
  if (optical(window.width()) < static_cast<std::uint64_t>(pitch)) return kBadParameter;
  const bool rounded = granted != window.x_dpi();
  set16(window.raw, 2, static_cast<std::uint32_t>(granted));
  set16(window.raw, 4, static_cast<std::uint32_t>(granted));
  return rounded ? kRounded : kGood;
}

void WindowStore::append_descriptor(Bytes& to, const Window& window) const {
  append(to, window.raw);
  to.resize(to.size() + static_cast<std::size_t>(model_->descriptor_bytes) - kDescriptor, 0);
}

std::optional<Bytes> WindowStore::reply_one(int id) const {
  const Window* window = find(id);
  if (window == nullptr) return std::nullopt;
  const auto length = static_cast<std::uint32_t>(model_->descriptor_bytes);
  Bytes reply;
  put16(reply, 6 + length);
  put16(reply, model_->window_reply_tag);
  put16(reply, 0);
  put16(reply, length);
  append_descriptor(reply, *window);
  return reply;
}

Bytes WindowStore::reply_all() const {
  const auto length = static_cast<std::uint32_t>(model_->descriptor_bytes);
  Bytes reply;
  put16(reply, 6 + 5 * length);
  put16(reply, model_->window_reply_tag);
  put16(reply, 0);
  put16(reply, length);
  for (const int id : {0, 1, 2, 3, 9}) append_descriptor(reply, windows_.at(id));
  return reply;
}

const Window* WindowStore::find(int id) const {
  const auto found = windows_.find(id);
  return found == windows_.end() ? nullptr : &found->second;
}

}  // namespace reseau::sim
