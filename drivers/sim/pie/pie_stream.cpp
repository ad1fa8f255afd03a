#include "drivers/sim/pie/pie_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "drivers/sim/hash.h"

namespace reseau::sim::pie {
namespace {

constexpr int kBandRows = 64;
constexpr unsigned char kTags[] = {'R', 'G', 'B', 'I'};

SensorSpec even_sensor(SensorSpec spec) {
  // Pixels and dark level are this unit's own (PieSensor).
  spec.dark_level = spec.dark_pattern = spec.pixel_gain = spec.shading = 0;
  spec.n_lines = 1;
  spec.adc_bits = 16;
  return spec;
}

}  // namespace

PieStream::PieStream(const PieJob& job, const PieSensor& sensor, std::shared_ptr<const Film> film,
                     const OpticsSpec& optics, const SensorSpec& noise,
                     const ScanGeometry& geometry, std::uint64_t seed, std::uint64_t pass)
    : job_(job),
      sensor_(sensor),
      noise_(even_sensor(noise)),
      renderer_(std::move(film), optics, job.window, geometry) {
  pass_.level = job.level;
  pass_.seed = seed;
  pass_.pass = pass;
  for (int i = 0; i < job.window.width_px; ++i) {
    columns_.push_back(
        sensor.pixel_at(job.x0_px + i * job.window.pitch + (job.window.pitch - 1) / 2.0));
  }
  // Red first and blue last on the way out, blue first and red last on the way back.
  std::vector<int> order = job.infrared ? std::vector<int>{0, 1, 3, 2} : std::vector<int>{0, 1, 2};
  if (job.bottom_up) std::reverse(order.begin(), order.end());
  const int n_rows = job.window.n_lines;
  const int n_colours = static_cast<int>(order.size());
  for (int t = 0; t < n_rows + (n_colours - 1) * job.filter_offset; ++t) {
    for (int k = 0; k < n_colours; ++k) {
      const int row = t - k * job.filter_offset;
      if (row < 0 || row >= n_rows) continue;
      sequence_.push_back(
          {job.bottom_up ? n_rows - 1 - row : row, order[static_cast<std::size_t>(k)]});
    }
  }
  n_lines_ = static_cast<int>(sequence_.size());
}

PieStream::~PieStream() {
  if (ahead_.valid()) ahead_.wait();
}

std::size_t PieStream::line_bytes() const {
  return 2 + static_cast<std::size_t>(job_.window.width_px) * (job_.two_bytes ? 2 : 1);
}

PieStream::Band PieStream::render(int first_row) const {
  const ScanWindow& window = renderer_.window();
  Band band;
  band.first_row = first_row;
  band.n_rows = std::min(kBandRows, window.n_lines - first_row);
  const auto width = static_cast<std::size_t>(window.width_px);
  std::vector<float> light(static_cast<std::size_t>(band.n_rows) * kChannels * width);
  renderer_.transmittance(first_row, band.n_rows, light);
  for (std::size_t i = 0; i < light.size(); ++i) {
    const int channel = static_cast<int>(i / width % kChannels);
    const int pixel = columns_[i % width];
    const auto level = static_cast<float>(pass_.level[static_cast<std::size_t>(channel)]);
    light[i] = light[i] * sensor_.gain(channel, pixel) +
               (level > 0 ? sensor_.dark(channel, pixel) / level : 0.0F);
  }
  band.values.resize(light.size());
  digitise(light, window, first_row, noise_, pass_, band.values);
  return band;
}

const PieStream::Band& PieStream::band_of(int row) {
  const int first = row / kBandRows * kBandRows;
  for (const Band& band : bands_) {
    if (band.first_row == first) return band;
  }
  Band band;
  if (ahead_.valid()) band = ahead_.get();
  if (band.first_row != first) band = render(first);
  // Colours lie less than a band apart.
  if (bands_.size() >= 3) bands_.erase(bands_.begin());
  bands_.push_back(std::move(band));
  const int next = job_.bottom_up ? first - kBandRows : first + kBandRows;
  if (next >= 0 && next < job_.window.n_lines) {
    ahead_ = std::async(std::launch::async, [this, next] { return render(next); });
  }
  return bands_.back();
}

void PieStream::append_line(int row, int channel, Bytes& to) {
  const Band& band = band_of(row);
  const auto width = static_cast<std::size_t>(job_.window.width_px);
  const auto line = static_cast<std::size_t>(row - band.first_row) * kChannels +
                    static_cast<std::size_t>(channel);
  const std::uint16_t* const values = band.values.data() + line * width;
  const std::uint32_t tag = kTags[channel];
  put8(to, tag);
  put8(to, tag);
  for (std::size_t i = 0; i < width; ++i) {
    if (job_.two_bytes) put8(to, values[i] & 0xffU);
    put8(to, static_cast<std::uint32_t>(values[i]) >> 8);
  }
}

void PieStream::read(int n, Bytes& to) {
  CHECK(n >= 0 && n <= lines_left());
  to.reserve(to.size() + static_cast<std::size_t>(n) * line_bytes());
  for (int i = 0; i < n; ++i) {
    const auto [row, channel] = sequence_[static_cast<std::size_t>(next_line_++)];
    append_line(row, channel, to);
  }
}

void append_calibration(const PieSensor& sensor, int n_lines, int n_colours,
                        const std::array<double, 4>& light, double noise, std::uint64_t seed,
                        Bytes& to) {
  const std::size_t line_bytes = 2 + 2 * static_cast<std::size_t>(sensor.n_pixels());
  to.reserve(to.size() + static_cast<std::size_t>(n_lines) * line_bytes);
  for (int line = 0; line < n_lines; ++line) {
    if (noise == 0 && line >= n_colours) {
      // As the line of that colour before.
      const std::size_t from = to.size() - static_cast<std::size_t>(n_colours) * line_bytes;
      for (std::size_t i = 0; i < line_bytes; ++i) to.push_back(to[from + i]);
      continue;
    }
    const int c = line % n_colours;
    const std::uint32_t tag = kTags[c];
    put8(to, tag);
    put8(to, tag);
    for (int pixel = 0; pixel < sensor.n_pixels(); ++pixel) {
      const double signal = light[static_cast<std::size_t>(c)] * sensor.gain(c, pixel);
      const std::uint64_t bits =
          mix64(mix64(seed, static_cast<std::uint64_t>(line)), static_cast<std::uint64_t>(pixel));
      // Uniform noise of the same standard deviation as the image has.
      const double deviate = (static_cast<double>(bits & 0xffff) / 65535 - 0.5) * std::sqrt(12.0);
      const double value =
          signal + sensor.dark(c, pixel) + noise * std::sqrt(std::max(signal, 0.04)) * deviate;
      const auto code =
          static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 1.0) * 65535));
      put8(to, code & 0xff);
      put8(to, code >> 8);
    }
  }
}

}  // namespace reseau::sim::pie
