// What one SCAN will deliver: the arithmetic of lines, padding and cooperation records, from the
// windows alone. Source: LS-5000 interface specification, image data; recorded Nikon Scan session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "drivers/sim/sense.h"
#include "drivers/sim/unit_model.h"
#include "drivers/sim/windows.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// A record is the smallest unit a READ may end at: one film line, or one of each sensor line. gap
// records make a block: record p, sensor line l is film line l * gap + p of it. A record
// consists of one block per reading; every block is its colour planes, each after
// plane_pad bytes, then pad bytes.
struct ScanLayout {
  std::vector<int> window_ids;      // as listed by SCAN
  std::vector<std::size_t> planes;  // indices of R G B IR in the order of the wire
  int width_px = 0, n_lines = 0;    // delivered, without surplus
  int pitch = 1;
  int depth_bits = 16;
  int readings = 1;
  int sensor_lines = 1;
  int gap = 1;
  int top_lines = 0;  // surplus before the image
  bool thumbnail = false;
  bool curves = false;          // the host is to correct the sensor's lines
  int x_px = 0, y_px = 0;       // optical pixels, of the first line on the wire
  int packet_bytes = 0;         // of the link, 0 without packets
  int frame_lines = 0;          // of a thumbnail
  std::size_t plane_bytes = 0;  // of one plane of a record, without its pad
  std::size_t plane_pad = 0;
  std::size_t first_pad = 0;  // after the first reading
  std::size_t other_pad = 0;  // after readings without infrared
  Exposures exposure{};

  [[nodiscard]] int lines_per_record() const { return sensor_lines; }
  [[nodiscard]] int lines_per_block() const { return sensor_lines * gap; }
  [[nodiscard]] int n_blocks() const {
    return (top_lines + n_lines + lines_per_block() - 1) / lines_per_block();
  }
  [[nodiscard]] int n_records() const { return n_blocks() * gap; }
  [[nodiscard]] int wire_lines() const { return n_blocks() * lines_per_block(); }
  [[nodiscard]] int bytes_per_sample() const { return depth_bits > 8 ? 2 : 1; }
  // Planes of the second and later readings: infrared is read once.
  [[nodiscard]] std::size_t visible_planes() const {
    return planes.back() == 3 ? planes.size() - 1 : planes.size();
  }
  [[nodiscard]] std::size_t record_bytes() const;
};

// What the host is asked to do before the scan begins.
struct CooperationRequest {
  Sense sense;
  Bytes reply;  // data type 87, header included
};

// The layout, or the refusal of SCAN. mud: measurement units per inch.
[[nodiscard]] std::variant<ScanLayout, Sense> plan_scan(const UnitModel& model,
                                                        const AdapterState& adapter,
                                                        const WindowStore& windows,
                                                        const std::vector<int>& ids, int mud,
                                                        int packet_bytes);

// In the order in which SCAN raises them.
[[nodiscard]] std::vector<CooperationRequest> cooperation_requests(const ScanLayout& layout);

}  // namespace reseau::sim
