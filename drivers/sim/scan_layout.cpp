#include "drivers/sim/scan_layout.h"

#include <algorithm>

namespace reseau::sim {
namespace {

std::size_t plane_of_window(int id) {
  switch (id) {
    case 1:
      return 0;
    case 3:
      return 2;
    case 9:
      return 3;
    default:
      return 1;
  }
}

std::size_t pad_to_packet(std::size_t bytes, int packet_bytes) {
  if (packet_bytes == 0) return 0;
  const auto packet = static_cast<std::size_t>(packet_bytes);
  return (packet - bytes % packet) % packet;
}

// Windows of one scan agree in everything but colour and exposure.
bool agree(const Window& a, const Window& b) {
  if (!std::equal(a.raw.begin() + 2, a.raw.begin() + 40, b.raw.begin() + 2)) return false;
  return (a.raw[42] & 0x6f) == (b.raw[42] & 0x6f) && a.raw[41] == b.raw[41] &&
         a.raw[43] == b.raw[43] && a.raw[44] == b.raw[44] && a.raw[40] >> 4 == b.raw[40] >> 4;
}

Sense check_list(const WindowStore& windows, const std::vector<int>& ids) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Window* window = windows.find(ids[i]);
    if (window == nullptr || ids[i] == 4) return kBadParameter;
    if (std::count(ids.begin(), ids.end(), ids[i]) > 1) return kBadCombination;
    if (ids[i] == 0 && ids.size() > 1) return kBadCombination;
    if (ids.size() > 1 && window->composition() != 0x05) return kBadComposition;
    if (!agree(*window, *windows.find(ids[0]))) return kBadCombination;
    if (window->thumbnail() && (ids.size() > 3 || ids[i] == 9)) return kBadCombination;
  }
  return kGood;
}

Bytes record_reply(ByteView record) {
  Bytes reply;
  put16(reply, 0x8708);
  put32(reply, static_cast<std::uint32_t>(record.size()));
  append(reply, record);
  return reply;
}

Bytes begin_record(std::uint8_t type, const Sense& sense, std::size_t size) {
  Bytes record(size, 0);
  record[0] = type;
  record[1] = sense.key;
  record[2] = sense.asc;
  record[3] = sense.ascq;
  record[4] = sense.tsc;
  return record;
}

CooperationRequest average_request(const ScanLayout& layout) {
  const Sense sense{0x09, 0x80, 0x02, 0x01};
  Bytes record = begin_record(0x02, sense, 18);
  set16(record, 5, static_cast<std::uint32_t>(layout.width_px));
  set16(record, 7, static_cast<std::uint32_t>(layout.n_lines * layout.readings));
  record[9] = static_cast<std::uint8_t>(layout.depth_bits);
  set16(record, 10, static_cast<std::uint32_t>(layout.n_lines));
  record[12] = static_cast<std::uint8_t>(layout.readings);
  return {sense, record_reply(record)};
}

CooperationRequest padding_request(const ScanLayout& layout) {
  // Without packets the fourth code is 0, as an LS-9000 has it.
  const Sense sense{0x09, 0x80, 0x06, static_cast<std::uint8_t>(layout.packet_bytes > 0 ? 1 : 0)};
  Bytes record = begin_record(0x06, sense, 27);
  // The record counts film lines.
  const auto per_line = static_cast<std::size_t>(layout.sensor_lines);
  const bool infrared_once = layout.readings > 1 && layout.planes.back() == 3;
  const std::size_t main_pad = layout.readings > 1 ? layout.other_pad : layout.first_pad;
  const int surplus = layout.wire_lines() - layout.top_lines - layout.n_lines;
  if (layout.plane_pad > 0) {
    record[5] |= 0x01;
    set16(record, 7, static_cast<std::uint32_t>(layout.plane_pad));
  }
  if (main_pad > 0 || (infrared_once && layout.first_pad > 0)) record[5] |= 0x08;
  set16(record, 13, static_cast<std::uint32_t>(main_pad / per_line));
  if (infrared_once) {
    record[5] |= 0x20;
    set16(record, 17, static_cast<std::uint32_t>(layout.first_pad / per_line));
  }
  if (layout.top_lines > 0) {
    record[5] |= 0x40;
    set16(record, 19, static_cast<std::uint32_t>(layout.top_lines));
  }
  if (surplus > 0) {
    record[5] |= 0x80;
    set16(record, 21, static_cast<std::uint32_t>(surplus));
  }
  return {sense, record_reply(record)};
}

CooperationRequest thumbnail_request(const ScanLayout& layout) {
  const Sense sense{0x09, 0x80, 0x01, 0x06};
  Bytes record = begin_record(0x01, sense, 18);
  const int lines_per_frame = layout.frame_lines;
  const int frames = layout.n_lines / lines_per_frame - 2;  // the window is two frames longer
  set16(record, 5, static_cast<std::uint32_t>(layout.plane_bytes * layout.planes.size()));
  set16(record, 7, static_cast<std::uint32_t>(std::max(frames, 1) * lines_per_frame));
  record[9] = static_cast<std::uint8_t>(layout.depth_bits);
  set16(record, 10, static_cast<std::uint32_t>(lines_per_frame));
  return {sense, record_reply(record)};
}

CooperationRequest register_request(const ScanLayout& layout) {
  const Sense sense{0x09, 0x80, 0x04, 0x01};
  Bytes record = begin_record(0x04, sense, 18);
  set16(record, 5, static_cast<std::uint32_t>(layout.plane_bytes * layout.planes.size()));
  set16(record, 7, static_cast<std::uint32_t>(layout.n_lines));
  record[9] = static_cast<std::uint8_t>(layout.depth_bits);
  set16(record, 10, static_cast<std::uint32_t>(layout.n_lines));
  record[12] = static_cast<std::uint8_t>(layout.readings);
  set16(record, 13, static_cast<std::uint32_t>(layout.gap));
  return {sense, record_reply(record)};
}

CooperationRequest curve_request() {
  const Sense sense{0x09, 0x80, 0x07, 0x00};
  Bytes record = begin_record(0x07, sense, 18);
  record[5] = record[6] = record[7] = 0x01;
  record[13] = 0x02;
  return {sense, record_reply(record)};
}

}  // namespace

std::size_t ScanLayout::record_bytes() const {
  const std::size_t plane = plane_bytes + plane_pad;
  const auto others = static_cast<std::size_t>(readings - 1);
  return plane * planes.size() + first_pad + others * (plane * visible_planes() + other_pad);
}

std::variant<ScanLayout, Sense> plan_scan(const UnitModel& model, const AdapterState& adapter,
                                          const WindowStore& windows, const std::vector<int>& ids,
                                          int mud, int packet_bytes) {
  if (ids.empty()) return kBadSequence;
  if (const Sense sense = check_list(windows, ids); !sense.good()) return sense;
  const Window& window = *windows.find(ids[0]);
  const auto optical = [mud, &model](std::uint32_t v) {
    return static_cast<int>(static_cast<std::uint64_t>(v) *
                            static_cast<std::uint64_t>(model.optical_dpi) /
                            static_cast<std::uint64_t>(mud));
  };
  ScanLayout layout;
  layout.window_ids = ids;
  layout.packet_bytes = packet_bytes;
  layout.thumbnail = window.thumbnail();
  layout.pitch = layout.thumbnail ? model.thumbnail_pitch() : pitch_for_dpi(model, window.x_dpi());
  layout.frame_lines = static_cast<int>(adapter.frame_height()) / model.thumbnail_pitch();
  layout.x_px = optical(window.x_origin());
  layout.y_px = optical(window.y_origin());
  layout.width_px = optical(window.width()) / layout.pitch;
  layout.n_lines = optical(window.height()) / layout.pitch;
  layout.depth_bits = window.depth_bits();
  layout.readings = window.readings();
  if (layout.width_px < 1 || layout.n_lines < 1) return kBadParameter;
  if (window.multi_line()) {
    if (model.line_gap % layout.pitch != 0) return kBadCombination;
    layout.sensor_lines = model.sensor_lines;
    layout.gap = model.line_gap / layout.pitch;
    layout.curves = model.has_ccd_curves;
    if (layout.sensor_lines == 2) {
      // Its sensor lines begin at even film lines.
      layout.top_lines = layout.y_px % 2;
      layout.y_px -= layout.top_lines;
    } else if (layout.n_lines % layout.lines_per_block() != 0 ||
               layout.x_px % model.line_gap != 0) {
      return kBadCombination;  // whole blocks only
    }
  }
  for (const int id : ids) {
    layout.planes.push_back(plane_of_window(id));
    layout.exposure[plane_of_window(id)] = windows.find(id)->exposure();
  }
  std::ranges::sort(layout.planes);

  const int plane_bytes = layout.width_px * layout.bytes_per_sample() * layout.lines_per_record();
  layout.plane_bytes = static_cast<std::size_t>(plane_bytes);
  layout.plane_pad = model.even_planes ? layout.plane_bytes % 2 : 0;
  const std::size_t plane = layout.plane_bytes + layout.plane_pad;
  // Every film line is padded by itself, also where two share a record.
  const auto lines = static_cast<std::size_t>(layout.lines_per_record());
  layout.first_pad = lines * pad_to_packet(plane * layout.planes.size() / lines, packet_bytes);
  layout.other_pad = lines * pad_to_packet(plane * layout.visible_planes() / lines, packet_bytes);
  return layout;
}

std::vector<CooperationRequest> cooperation_requests(const ScanLayout& layout) {
  std::vector<CooperationRequest> requests;
  if (layout.readings > 1) requests.push_back(average_request(layout));
  if (layout.sensor_lines > 2) requests.push_back(register_request(layout));
  const bool surplus = layout.wire_lines() != layout.n_lines;
  const bool later_pad = layout.readings > 1 && layout.other_pad > 0;
  if (layout.first_pad > 0 || later_pad || layout.plane_pad > 0 || surplus) {
    requests.push_back(padding_request(layout));
  }
  if (layout.thumbnail) requests.push_back(thumbnail_request(layout));
  if (layout.curves) requests.push_back(curve_request());
  return requests;
}

}  // namespace reseau::sim
