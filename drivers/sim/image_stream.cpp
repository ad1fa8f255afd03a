#include "drivers/sim/image_stream.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"

namespace reseau::sim {
namespace {

constexpr int kBandLines = 128;

}  // namespace

ImageStream::ImageStream(const ScanLayout& layout, std::shared_ptr<const Film> film,
                         const OpticsSpec& optics, const SensorSpec& sensor, const SensorPass& pass,
                         const ScanWindow& window, const ScanGeometry& geometry,
                         LookupTables tables)
    : layout_(layout),
      sensor_(sensor),
      pass_(pass),
      tables_(std::move(tables)),
      renderer_(std::move(film), optics, window, geometry),
      // Whole blocks, so that a record never straddles two bands.
      band_lines_((kBandLines + layout.lines_per_block() - 1) / layout.lines_per_block() *
                  layout.lines_per_block()) {}

ImageStream::~ImageStream() {
  if (ahead_.valid()) ahead_.wait();
}

ImageStream::Band ImageStream::render(int first_line) const {
  const ScanWindow& window = renderer_.window();
  Band band;
  band.first_line = first_line;
  band.n_lines = std::min(band_lines_, window.n_lines - first_line);
  const std::size_t size = static_cast<std::size_t>(band.n_lines) * kChannels *
                           static_cast<std::size_t>(window.width_px);
  std::vector<float> light(size);
  renderer_.transmittance(first_line, band.n_lines, light);
  for (int r = 0; r < layout_.readings; ++r) {
    SensorPass pass = pass_;
    pass.reading = r;
    std::vector<std::uint16_t>& values = band.readings.emplace_back(size);
    digitise(light, window, first_line, sensor_, pass, values);
  }
  return band;
}

const ImageStream::Band& ImageStream::band_of(int line) {
  const auto inside = [line](const Band& band) {
    return line >= band.first_line && line < band.first_line + band.n_lines;
  };
  if (inside(band_)) return band_;
  const int first = line / band_lines_ * band_lines_;
  band_ = ahead_.valid() ? ahead_.get() : Band{};
  if (!inside(band_)) band_ = render(first);
  const int next = first + band_lines_;
  if (next < renderer_.window().n_lines) {
    ahead_ = std::async(std::launch::async, [this, next] { return render(next); });
  }
  return band_;
}

void ImageStream::append_pad(std::size_t n, Bytes& to) {
  // Garbage as a unit sends it: a pattern with a counter.
  for (std::size_t i = 0; i < n; ++i) {
    switch (i % 4) {
      case 0:
        put8(to, 0xaa);
        break;
      case 1:
        put8(to, 0x55);
        break;
      case 2:
        put8(to, pad_counter_ >> 8);
        break;
      default:
        put8(to, pad_counter_++ & 0xffU);
        break;
    }
  }
}

void ImageStream::append_plane(const Band& band, int reading, std::size_t plane, int first_line,
                               Bytes& to) {
  const auto width = static_cast<std::size_t>(layout_.width_px);
  const std::vector<std::uint16_t>& values = band.readings[static_cast<std::size_t>(reading)];
  const std::vector<std::uint16_t>& table = tables_[plane];
  const int per_record = layout_.lines_per_record();
  const std::uint16_t* rows[3] = {nullptr, nullptr, nullptr};
  for (int k = 0; k < per_record; ++k) {
    const auto line = static_cast<std::size_t>(first_line + k * layout_.gap - band.first_line);
    rows[k] = values.data() + (line * kChannels + plane) * width;
  }
  const bool two_bytes = layout_.bytes_per_sample() == 2;
  const int drop_bits = sensor_.adc_bits - layout_.depth_bits;
  const std::size_t at = to.size();
  to.resize(at + layout_.plane_bytes);
  std::uint8_t* byte = to.data() + at;
  // The sensor is read out from the far film edge.
  for (std::size_t i = width; i-- > 0;) {
    for (int k = 0; k < per_record; ++k) {
      std::uint32_t value = rows[k][i];
      if (!table.empty()) value = table[value];
      value >>= drop_bits;
      if (two_bytes) *byte++ = static_cast<std::uint8_t>(value >> 8);
      *byte++ = static_cast<std::uint8_t>(value & 0xff);
    }
  }
}

void ImageStream::append_record(int record, Bytes& to) {
  // Of the block's records every one begins a line later.
  const int first_line = record / layout_.gap * layout_.lines_per_block() + record % layout_.gap;
  const Band& band = band_of(first_line);
  for (int r = 0; r < layout_.readings; ++r) {
    const std::size_t n_planes = r == 0 ? layout_.planes.size() : layout_.visible_planes();
    for (std::size_t p = 0; p < n_planes; ++p) {
      append_pad(layout_.plane_pad, to);
      append_plane(band, r, layout_.planes[p], first_line, to);
    }
    append_pad(r == 0 ? layout_.first_pad : layout_.other_pad, to);
  }
}

void ImageStream::read(int n, Bytes& to) {
  CHECK(n >= 0 && n <= records_left());
  to.reserve(to.size() + static_cast<std::size_t>(n) * layout_.record_bytes());
  for (int i = 0; i < n; ++i) append_record(next_record_++, to);
}

}  // namespace reseau::sim
