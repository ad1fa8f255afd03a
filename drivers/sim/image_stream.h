// The bytes of a scan, record by record, rendered a band ahead of the reader.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/scan_layout.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/sensor.h"
#include "drivers/sim/wire_bytes.h"

namespace reseau::sim {

// One 16-bit table per plane R G B IR; empty = identity. Index and value have the A/D's bits.
using LookupTables = std::array<std::vector<std::uint16_t>, 4>;

// Thread-bound. A helper thread of its own renders ahead; it is joined by the destructor.
class ImageStream {
 public:
  ImageStream(const ScanLayout& layout, std::shared_ptr<const Film> film, const OpticsSpec& optics,
              const SensorSpec& sensor, const SensorPass& pass, const ScanWindow& window,
              const ScanGeometry& geometry, LookupTables tables);
  ~ImageStream();
  ImageStream(const ImageStream&) = delete;
  ImageStream& operator=(const ImageStream&) = delete;

  [[nodiscard]] int records_left() const { return layout_.n_records() - next_record_; }
  [[nodiscard]] const ScanLayout& layout() const { return layout_; }
  // Appends the next n records (n <= records_left()).
  void read(int n, Bytes& to);

 private:
  // A/D values of consecutive film lines: [reading][line][channel][pixel].
  struct Band {
    int first_line = 0, n_lines = 0;
    std::vector<std::vector<std::uint16_t>> readings;
  };
  [[nodiscard]] Band render(int first_line) const;
  const Band& band_of(int line);
  void append_record(int record, Bytes& to);
  void append_plane(const Band& band, int reading, std::size_t plane, int first_line, Bytes& to);
  void append_pad(std::size_t n, Bytes& to);

  ScanLayout layout_;
  SensorSpec sensor_;
  SensorPass pass_;
  LookupTables tables_;
  ScanRenderer renderer_;
  int band_lines_;
  int next_record_ = 0;
  std::uint16_t pad_counter_ = 0;
  Band band_;
  std::future<Band> ahead_;
};

}  // namespace reseau::sim
