#include "capture/session/recolor.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include "capture/color/color_record.h"
#include "core/base/parallel.h"
#include "core/color/pixel_matrix.h"

namespace reseau {
namespace {

// Enough rows to keep all cores busy, few enough to stay small: 24 MB of a frame 5000 px wide.
constexpr int kBandRows = 400;

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

}  // namespace

Recolored recolor(const RecolorOptions& options, const std::function<void(double)>& progress,
                  const std::stop_token& stop) {
  Recolored result;
  const ColorModel model = make_color_model(options.color);
  ExrReader reader(options.source);
  result.output_from_picture = multiply(
      model.output_from_process, inverse(output_from_process_of(reader, options.source.string())));

  PictureOptions picture;
  picture.exr = options.exr;
  picture.tiff = options.tiff;
  picture.png = options.png;
  picture.dpi = options.dpi;
  picture.gamut = options.view_gamut;
  picture.srgb_from_picture = srgb_from_output(options.color);
  declare_color(options.color, picture.exr_options);
  PictureWriter writer(picture);

  const int width = reader.width_px(), height = reader.height_px();
  const auto row_samples = static_cast<std::size_t>(width) * 3;
  std::vector<float> band;
  {
    const Stopwatch writing(result.seconds_writing);
    writer.begin(width, height);
  }
  for (int y = 0; y < height; y += kBandRows) {
    if (stop.stop_requested()) return result;
    const int n_rows = std::min(kBandRows, height - y);
    band.resize(row_samples * static_cast<std::size_t>(n_rows));
    {
      const Stopwatch reading(result.seconds_reading);
      reader.read(y, n_rows, band);
    }
    {
      const Stopwatch coloring(result.seconds_color);
      with_threads(options.n_threads, [&] { transform_pixels(band, result.output_from_picture); });
    }
    const Stopwatch writing(result.seconds_writing);
    writer.rows(y, n_rows, band);
    if (progress) progress(static_cast<double>(y + n_rows) / height);
  }
  {
    const Stopwatch writing(result.seconds_writing);
    writer.end();
  }
  result.picture = writer.result();
  result.written = true;
  return result;
}

}  // namespace reseau
