#include "capture/image/picture_writer.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "capture/image/icc.h"
#include "capture/image/png_writer.h"
#include "capture/image/view_encoding.h"
#include "capture/store/master_layout.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr int kViewRows = 64;
constexpr double kWhitePercentile = 0.995;
// A picture that is nearly all black is not lifted into noise.
constexpr double kMaxExposure = 1024;

double automatic_exposure(double luminance) {
  if (!(luminance > 0)) return 1;
  return std::clamp(1 / luminance, 1 / kMaxExposure, kMaxExposure);
}

// The 16-bit view copy: laid out like a master, with the sRGB profile.
class TiffView {
 public:
  TiffView(const std::filesystem::path& path, Existing existing, int width_px, int height_px,
           double dpi, ViewGamut gamut)
      : file_(path, PartFile::Kind::kScratch, existing) {
    LineFormat format;
    format.width_px = width_px;
    format.n_lines = height_px;
    format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
    format.x_dpi = format.y_dpi = dpi;
    MasterTags tags;
    tags.description = gamut == ViewGamut::kClip
                           ? "View copy, sRGB; colours outside sRGB are clipped."
                           : "View copy, sRGB; colours outside sRGB are compressed into it.";
    tags.software = "reseau " RESEAU_VERSION;
    tags.icc = srgb_icc();
    layout_ = plan_master(format, std::move(tags), kClassicTiffLimit);
  }
  void rows(int first_row, std::span<const std::uint16_t> rgb) {
    file_.write_at(layout_.row_offset(first_row), std::as_bytes(rgb));
  }
  void finish() {
    const int n_rows = layout_.format.n_lines;
    file_.write_at(kMasterHeadBytes, encode_master_values(layout_, n_rows));
    file_.write_at(0, encode_master_head(layout_, n_rows));
    file_.publish();
  }

 private:
  PartFile file_;
  MasterLayout layout_;
};

class PngView {
 public:
  PngView(const std::filesystem::path& path, Existing existing, int width_px, int height_px,
          double dpi)
      : file_(path, PartFile::Kind::kScratch, existing),
        png_(file_, width_px, height_px, dpi),
        row_samples_(static_cast<std::size_t>(width_px) * 3) {}
  void rows(std::span<const std::uint8_t> rgb) {
    for (; !rgb.empty(); rgb = rgb.subspan(row_samples_)) png_.row(rgb.first(row_samples_));
  }
  void finish() {
    png_.finish();
    file_.publish();
  }

 private:
  PartFile file_;
  PngWriter png_;
  std::size_t row_samples_;
};

}  // namespace

struct PictureWriter::State {
  explicit State(PictureOptions picture_options)
      : options(std::move(picture_options)), histogram(options.srgb_from_picture) {}

  void write_views() {
    ExrReader reader(options.exr);
    const ViewEncoder encoder(options.srgb_from_picture, result.exposure, options.gamut);
    const auto row_samples = static_cast<std::size_t>(result.width_px) * 3;
    std::vector<float> linear;
    std::vector<std::uint16_t> deep;
    std::vector<std::uint8_t> shallow;
    std::uint64_t n_clipped = 0;
    for (int y = 0; y < result.height_px; y += kViewRows) {
      const int n_rows = std::min(kViewRows, result.height_px - y);
      linear.resize(row_samples * static_cast<std::size_t>(n_rows));
      reader.read(y, n_rows, linear);
      std::uint64_t clipped = 0;
      if (tiff) {
        deep.resize(linear.size());
        clipped = encoder.encode(linear, deep);
        tiff->rows(y, deep);
      }
      if (png) {
        shallow.resize(linear.size());
        clipped = encoder.encode(linear, shallow);
        png->rows(shallow);
      }
      n_clipped += clipped;
    }
    result.clipped_fraction =
        static_cast<double>(n_clipped) /
        (static_cast<double>(result.width_px) * static_cast<double>(result.height_px));
    if (tiff) tiff->finish();
    if (png) png->finish();
  }

  PictureOptions options;
  LuminanceHistogram histogram;
  std::unique_ptr<FloatImageWriter> exr;
  std::unique_ptr<TiffView> tiff;
  std::unique_ptr<PngView> png;
  PictureResult result;
};

PictureWriter::PictureWriter(PictureOptions options)
    : state_(std::make_unique<State>(std::move(options))) {
  const auto& exposure = state_->options.exposure;
  if (exposure && !(*exposure > 0 && std::isfinite(*exposure))) {
    throw InputError("The exposure of the view copies must be a number above 0.");
  }
}

PictureWriter::~PictureWriter() = default;

void PictureWriter::begin(int width_px, int height_px) {
  State& s = *state_;
  CHECK(s.exr == nullptr);
  const Existing existing = s.options.exr_options.existing;
  s.result.width_px = width_px;
  s.result.height_px = height_px;
  s.exr = std::make_unique<FloatImageWriter>(s.options.exr, width_px, height_px,
                                             std::vector<std::string>{"R", "G", "B"},
                                             s.options.exr_options);
  // The names of the view copies are taken now, so that nothing fails after the long work.
  if (!s.options.tiff.empty()) {
    s.tiff = std::make_unique<TiffView>(s.options.tiff, existing, width_px, height_px,
                                        s.options.dpi, s.options.gamut);
  }
  if (!s.options.png.empty()) {
    s.png = std::make_unique<PngView>(s.options.png, existing, width_px, height_px, s.options.dpi);
  }
}

void PictureWriter::rows(int first_row, int n_rows, std::span<const float> rgb) {
  CHECK(state_->exr != nullptr);
  state_->exr->rows(first_row, n_rows, rgb);
  state_->histogram.add(rgb);
}

void PictureWriter::end() {
  State& s = *state_;
  CHECK(s.exr != nullptr);
  s.exr->finish();
  s.result.exr_sha256 = s.exr->sha256();
  s.result.luminance_p995 = s.histogram.percentile(kWhitePercentile);
  s.result.exposure = s.options.exposure.value_or(automatic_exposure(s.result.luminance_p995));
  if (s.tiff || s.png) s.write_views();
}

const PictureResult& PictureWriter::result() const { return state_->result; }

}  // namespace reseau
