// The lines of one pass as the wire carries them, rendered a band ahead of the reader.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <memory>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/pie/pie_sensor.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/sensor.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim::pie {

// What a pass delivers.
struct PieJob {
  ScanWindow window;  // on the film; x from the left side of the scan area
  int x0_px = 0;      // of the window on the sensor [px of the highest resolution]
  bool infrared = false, two_bytes = true, bottom_up = false;
  int filter_offset = 0;          // rows by which each colour comes after the one before
  std::array<double, 4> level{};  // fraction of full scale that bare light reaches
};

// Two equal tag bytes, then the samples, little-endian. Thread-bound; a helper thread of its own
// renders ahead and is joined by the destructor.
class PieStream {
 public:
  PieStream(const PieJob& job, const PieSensor& sensor, std::shared_ptr<const Film> film,
            const OpticsSpec& optics, const SensorSpec& noise, const ScanGeometry& geometry,
            std::uint64_t seed, std::uint64_t pass);
  ~PieStream();
  PieStream(const PieStream&) = delete;
  PieStream& operator=(const PieStream&) = delete;

  [[nodiscard]] int lines_left() const { return n_lines_ - next_line_; }
  [[nodiscard]] std::size_t line_bytes() const;
  [[nodiscard]] const PieJob& job() const { return job_; }
  // Appends the next n lines (n <= lines_left()).
  void read(int n, Bytes& to);

 private:
  struct Band {
    int first_row = -1, n_rows = 0;
    std::vector<std::uint16_t> values;  // [row][channel][pixel]
  };
  [[nodiscard]] Band render(int first_row) const;
  const Band& band_of(int row);
  void append_line(int row, int channel, Bytes& to);

  PieJob job_;
  const PieSensor& sensor_;
  SensorSpec noise_;
  SensorPass pass_;
  ScanRenderer renderer_;
  std::vector<int> columns_;                  // sensor pixel of each column
  std::vector<std::array<int, 2>> sequence_;  // row and channel of each line
  int n_lines_ = 0, next_line_ = 0;
  std::vector<Band> bands_;  // those that are still needed
  std::future<Band> ahead_;
};

// n_lines calibration lines of the whole sensor: colours in turn, 16 bit.
// light: fraction of full scale per colour, 0 = lamp off.
void append_calibration(const PieSensor& sensor, int n_lines, int n_colours,
                        const std::array<double, 4>& light, double noise, std::uint64_t seed,
                        Bytes& to);

}  // namespace reseau::sim::pie
