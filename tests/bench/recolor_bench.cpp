// Other primaries for a reconstruction of 24 megapixels (5669 x 4234). For figures:
// build/bin/recolor_bench on an idle machine; the pixels are random, their values cost nothing.
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "capture/color/color_record.h"
#include "capture/image/exr_file.h"
#include "capture/session/recolor.h"
#include "core/color/pixel_matrix.h"
#include "tests/support/temp_dir.h"

namespace reseau {
namespace {

constexpr int kWidth = 5669, kHeight = 4234;

// The test of the suite runs every benchmark once, and need not do it at full size.
int height_of(const benchmark::State& state) { return static_cast<int>(state.range(0)); }

std::vector<float> random_rows(int n_rows) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> intensity(0, 1);
  std::vector<float> rows(static_cast<std::size_t>(kWidth) * 3 * static_cast<std::size_t>(n_rows));
  for (float& v : rows) v = intensity(random);
  return rows;
}

void write_source(const std::filesystem::path& path, int height) {
  ExrOptions options;
  declare_color(ColorRecipe{}, options);
  constexpr int kRows = 73;
  const std::vector<float> rows = random_rows(kRows);
  FloatImageWriter writer(path, kWidth, height, {"R", "G", "B"}, options);
  for (int y = 0; y < height; y += kRows) {
    const int n = std::min(kRows, height - y);
    writer.rows(
        y, n,
        std::span(rows).first(static_cast<std::size_t>(kWidth) * 3 * static_cast<std::size_t>(n)));
  }
  writer.finish();
}

void colour_stage_in_memory(benchmark::State& state) {
  std::vector<float> picture = random_rows(height_of(state));
  const Matrix3 matrix = make_color_model(ColorRecipe{}).output_from_process;
  for (auto _ : state) {
    transform_pixels(picture, matrix);
    benchmark::DoNotOptimize(picture.data());
  }
}
BENCHMARK(colour_stage_in_memory)->Arg(kHeight)->Unit(benchmark::kMillisecond)->UseRealTime();

// From file to file; the counters say what of it is reading, colours and writing.
void recolor_a_file(benchmark::State& state) {
  const test::TempDir dir;
  RecolorOptions options;
  options.source = dir / "source.exr";
  write_source(options.source, height_of(state));
  options.color.primaries = find_primary_set("neblette-1952");
  double reading = 0, colors = 0, writing = 0;
  for (auto _ : state) {
    options.exr = dir / "out.exr";
    const Recolored done = recolor(options, {}, {});
    reading += done.seconds_reading;
    colors += done.seconds_color;
    writing += done.seconds_writing;
    state.PauseTiming();
    std::filesystem::remove(options.exr);
    state.ResumeTiming();
  }
  const auto each = benchmark::Counter::kAvgIterations;
  state.counters["reading_s"] = benchmark::Counter(reading, each);
  state.counters["colour_s"] = benchmark::Counter(colors, each);
  state.counters["writing_s"] = benchmark::Counter(writing, each);
}
BENCHMARK(recolor_a_file)->Arg(kHeight)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace reseau
