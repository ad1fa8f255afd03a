// Cost of the colour path: the matrix is made once per picture, the difference once per pixel.
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "core/color/delta_e.h"
#include "core/color/element_color.h"

namespace reseau {
namespace {

void make_model(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        make_color_model("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kSrgbLinear));
  }
}
BENCHMARK(make_model)->Unit(benchmark::kMicrosecond);

std::vector<Xyz> random_colors(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> intensity(0, 1);
  const Matrix3 xyz = make_color_model("cornwell-clyne-1951", Balance::kNeutral, OutputSpace::kXyz)
                          .xyz_from_process;
  std::vector<Xyz> colors(4096);
  for (Xyz& color : colors) {
    color = multiply(xyz, Vector3{intensity(random), intensity(random), intensity(random)});
  }
  return colors;
}

void difference_of_two_pictures(benchmark::State& state) {
  const auto first = random_colors(1), second = random_colors(2);
  const Xyz white = white_of(Illuminant::kD65);
  for (auto _ : state) {
    double sum = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      sum += delta_e_2000(lab_from_xyz(first[i], white), lab_from_xyz(second[i], white));
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(first.size()));
}
BENCHMARK(difference_of_two_pictures)->Unit(benchmark::kMicrosecond);

void encode_srgb(benchmark::State& state) {
  double v = 0.01;
  for (auto _ : state) {
    benchmark::DoNotOptimize(v);
    benchmark::DoNotOptimize(srgb_encode(v));
  }
}
BENCHMARK(encode_srgb);

}  // namespace
}  // namespace reseau
