#include "capture/session/recolor.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "capture/color/color_record.h"
#include "core/base/parallel.h"
#include "core/color/pixel_matrix.h"
#include "core/color/white_balance.h"

namespace reseau {
namespace {

// Enough rows to keep all cores busy, few enough to stay in the caches: 2 x 4 MB of a frame 5000 px
// wide.
constexpr int kBandRows = 64;

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds) {}
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Multiplies the white balance of a recipe by the factors that make an area of the picture neutral.
void make_neutral(const NeutralArea& area, ExrReader& reader, const Matrix3& process_from_picture,
                  ColorRecipe& recipe) {
  const int width = reader.width_px(), height = reader.height_px();
  AreaMean mean(area);
  mean.begin(width, height);
  std::vector<float> rows;
  for (int y = 0; y < height; y += kBandRows) {
    const int n_rows = std::min(kBandRows, height - y);
    if (!mean.wants(y, n_rows)) continue;
    rows.resize(static_cast<std::size_t>(width) * 3 * static_cast<std::size_t>(n_rows));
    reader.read(y, n_rows, rows);
    mean.rows(y, n_rows, rows);
  }
  const Vector3 factors = neutral_white_balance(multiply(process_from_picture, mean.mean()),
                                                make_color_model(recipe).xyz_from_process);
  for (std::size_t i = 0; i < 3; ++i) recipe.white_balance[i] *= factors[i];
}

}  // namespace

Recolored recolor(const RecolorOptions& options, const std::function<void(double)>& progress,
                  const std::stop_token& stop) {
  Recolored result;
  const auto start = std::chrono::steady_clock::now();
  ExrReader reader(options.source);
  const Matrix3 process_from_picture =
      inverse(output_from_process_of(reader, options.source.string()));
  result.color = options.color;
  if (options.neutral) make_neutral(*options.neutral, reader, process_from_picture, result.color);
  result.output_from_picture =
      multiply(make_color_model(result.color).output_from_process, process_from_picture);

  PictureOptions picture;
  picture.exr = options.exr;
  picture.tiff = options.tiff;
  picture.png = options.png;
  picture.dpi = options.dpi;
  picture.gamut = options.view_gamut;
  picture.srgb_from_picture = srgb_from_output(result.color);
  declare_color(result.color, picture.exr_options);
  PictureWriter writer(picture);

  const int width = reader.width_px(), height = reader.height_px();
  const auto row_samples = static_cast<std::size_t>(width) * 3;
  const auto n_bands = (height + kBandRows - 1) / kBandRows;
  const auto rows_of = [&](int band) { return std::min(kBandRows, height - band * kBandRows); };
  std::array<std::vector<float>, 2> bands;
  const auto read = [&](int band) {
    const Stopwatch reading(result.seconds_reading);
    std::vector<float>& to = bands[static_cast<std::size_t>(band % 2)];
    to.resize(row_samples * static_cast<std::size_t>(rows_of(band)));
    reader.read(band * kBandRows, rows_of(band), to);
  };
  const auto color_and_write = [&](int band) {
    std::vector<float>& rows = bands[static_cast<std::size_t>(band % 2)];
    {
      const Stopwatch coloring(result.seconds_color);
      transform_pixels(rows, result.output_from_picture);
    }
    const Stopwatch writing(result.seconds_writing);
    writer.rows(band * kBandRows, rows_of(band), rows);
  };
  {
    const Stopwatch writing(result.seconds_writing);
    writer.begin(width, height);
  }
  bool stopped = false;
  with_threads(options.n_threads, [&] {
    read(0);
    for (int band = 0; band < n_bands && !stopped; ++band) {
      // One band is read while the one before is coloured and written.
      parallel_for(2, [&](int i) {
        if (i == 1) color_and_write(band);
        if (i == 0 && band + 1 < n_bands) read(band + 1);
      });
      stopped = stop.stop_requested();
      if (progress) progress(static_cast<double>(band + 1) / n_bands);
    }
  });
  if (stopped) return result;
  {
    const Stopwatch writing(result.seconds_writing);
    writer.end();
  }
  result.picture = writer.result();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.written = true;
  return result;
}

}  // namespace reseau
