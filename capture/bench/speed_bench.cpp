#include "capture/bench/speed_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "capture/bench/cpu_time.h"
#include "capture/bench/memory_use.h"
#include "core/reconstruct/reconstruct.h"
#include "core/reconstruct/row_sink.h"
#include "drivers/sim/simulate.h"

namespace reseau {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTilePx = 1000;
// 13 periods of 100/13 px of 6.35 um; atan(5/12).
constexpr const char* kTileFilm =
    "ls5000?width_px=1000&height_px=1000&border_px=0&rebate_px=0&scene=natural&axes=90"
    "&period_um=48.84615384615385&angle=22.61986494804043&blur_px=0.7&noise=0.002";
constexpr double kBytesPerPixelIn = 8, kBytesPerPixelOut = 12;

// Takes rows and keeps none.
class NoPicture final : public RgbRowSink {
 public:
  void begin(int /*width_px*/, int /*height_px*/) override {}
  void rows(int /*first_row*/, int /*n_rows*/, std::span<const float> /*rgb*/) override {}
  void end() override {}
};

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

}  // namespace

MemoryLineSource tiled_film(double megapixels, bool half_black) {
  const sim::SimulatedScan tile = sim::simulate_frame(sim::parse_sim_spec(kTileFilm));
  LineFormat format = tile.format;
  format.width_px = static_cast<int>(std::lround(std::sqrt(megapixels * 1e6 / 1.5)));
  format.n_lines = static_cast<int>(std::lround(megapixels * 1e6 / format.width_px));
  const auto width = static_cast<std::size_t>(format.width_px);
  const std::size_t n_planes = format.channels.size();
  const std::size_t dark = half_black ? width / 2 : 0;
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(format.n_lines) * n_planes * width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(format.n_lines); ++y) {
    for (std::size_t plane = 0; plane < n_planes; ++plane) {
      const std::uint16_t* from =
          tile.samples.data() + (y % kTilePx * n_planes + plane) * std::size_t{kTilePx};
      std::uint16_t* to = samples.data() + (y * n_planes + plane) * width;
      for (std::size_t x = 0; x < width; x += kTilePx)
        std::copy_n(from, std::min<std::size_t>(kTilePx, width - x), to + x);
      // As deep as a Dufaycolor gets, with what the scan has of noise there.
      for (std::size_t x = 0; x < dark; ++x) to[x] = static_cast<std::uint16_t>(to[x] % 64 + 100);
    }
  }
  return {std::move(format), std::move(samples)};
}

SpeedRun run_speed_case(const MemoryLineSource& source, const SpeedCase& test, int repeat) {
  SpeedRun result;
  result.register_wall_s = result.reconstruct_wall_s = 1e30;
  RegisterOptions register_options;
  register_options.n_threads = test.n_threads;
  register_options.tone = test.tone;
  ReconstructOptions options;
  options.quality = test.quality;
  options.n_threads = test.n_threads;
  options.exact = test.exact;
  options.tone = test.tone;
  const double pixels =
      static_cast<double>(source.format().width_px) * static_cast<double>(source.format().n_lines);
  result.least_bytes = pixels * (2 * kBytesPerPixelIn + kBytesPerPixelOut);
  std::vector<double> register_cpu, reconstruct_cpu;
  for (int i = 0; i < repeat; ++i) {
    reset_peak_memory();
    const std::size_t before = memory_in_use();
    const double cpu_start = cpu_seconds();
    auto start = Clock::now();
    const Registration registration = register_screen(source, register_options, {}, {});
    result.register_wall_s = std::min(result.register_wall_s, since(start));
    if (!registration.found) {
      result.reason = registration.reason;
      return result;
    }
    const double cpu_registered = cpu_seconds();
    NoPicture nothing;
    start = Clock::now();
    static_cast<void>(reconstruct(source, registration, options, nothing, {}, {}));
    result.reconstruct_wall_s = std::min(result.reconstruct_wall_s, since(start));
    register_cpu.push_back(cpu_registered - cpu_start);
    reconstruct_cpu.push_back(cpu_seconds() - cpu_registered);
    result.extra_bytes = std::max(result.extra_bytes, peak_memory() - before);
  }
  result.found = true;
  result.register_cpu_s = median(register_cpu);
  result.reconstruct_cpu_s = median(reconstruct_cpu);
  return result;
}

}  // namespace reseau
