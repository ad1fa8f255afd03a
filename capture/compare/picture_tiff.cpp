#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <tiffio.h>

#include "capture/compare/color_decode.h"
#include "capture/compare/picture_files.h"
#include "capture/image/tiff_file.h"
#include "capture/image/tiff_pixels.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

constexpr std::uint32_t kIccTag = 34675;

void require_usable(const TiffFile& file) {
  const TiffPage& page = file.page();
  const std::string reason = unsupported_reason(page);
  if (!reason.empty()) {
    throw InputError(
        fmt::format("The picture '{}' cannot be compared: {}.", file.path().string(), reason));
  }
  if (page.lines_in_file < page.height_px) {
    throw InputError(
        fmt::format("The picture '{}' is cut off: {} of {} lines are there. Give a whole file.",
                    file.path().string(), page.lines_in_file, page.height_px));
  }
}

class TiffPicture final : public Picture {
 public:
  TiffPicture(PictureHeader header, const PictureChoice& choice)
      : Picture(std::move(header)), file_(header_.path) {
    require_usable(file_);
    const TiffPage& page = file_.page();
    by_lines_ = !page.planar && !page.tiled && page.photometric != PHOTOMETRIC_YCBCR;
    if (by_lines_) {
      line_.resize(std::max<std::size_t>(
          static_cast<std::size_t>(TIFFScanlineSize64(file_.handle())), page.row_bytes()));
    } else {
      decode_all();
    }
    if (page.samples > 3) {
      notes_.emplace_back("Samples beyond red, green and blue (infrared or alpha) are left out.");
    }
    choose_decode(choice);
  }

  void read(int first_row, int n_rows, std::span<float> out) override {
    const auto width = static_cast<std::size_t>(header_.width_px);
    CHECK(out.size() == 3 * width * static_cast<std::size_t>(n_rows));
    for (int y = 0; y < n_rows; ++y) {
      const auto row = out.subspan(3 * width * static_cast<std::size_t>(y), 3 * width);
      if (by_lines_) {
        read_line(first_row + y, row);
      } else {
        copy_line(first_row + y, row);
      }
    }
  }
  void to_xyz(std::span<const float> samples, std::span<float> xyz) const override {
    decode_->to_xyz(samples, xyz);
  }

 private:
  [[nodiscard]] std::size_t channel(std::size_t k) const {
    return file_.page().samples >= 3 ? k : 0;
  }

  void decode_all() {
    TiffPixels pixels = decode_page(file_);
    if (pixels.n_lines < file_.page().height_px) {
      throw InputError(fmt::format("The picture '{}' is damaged: only {} of {} lines can be read.",
                                   header_.path.string(), pixels.n_lines, file_.page().height_px));
    }
    if (pixels.n_clamped > 0) {
      notes_.push_back(fmt::format("{} samples outside 0..1 were clipped.", pixels.n_clamped));
    }
    samples_ = std::move(pixels.samples);
  }

  void copy_line(int y, std::span<float> out) const {
    const auto width = static_cast<std::size_t>(header_.width_px);
    const auto n = static_cast<std::size_t>(file_.page().samples);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint16_t* from =
          samples_.data() + (static_cast<std::size_t>(y) * n + channel(k)) * width;
      for (std::size_t x = 0; x < width; ++x)
        out[3 * x + k] = static_cast<float>(from[x]) / 65535.0F;
    }
  }

  // A compressed strip can only be read forwards, from its first line.
  void fetch_line(int y) {
    int from = y;
    if (file_.page().compressed && y != next_line_) {
      std::uint32_t rows = 0;
      TIFFGetFieldDefaulted(file_.handle(), TIFFTAG_ROWSPERSTRIP, &rows);
      const auto height = static_cast<std::uint32_t>(header_.height_px);
      const int strip = static_cast<int>(std::clamp<std::uint32_t>(rows, 1, height));
      from = y / strip * strip;
      if (next_line_ > from && next_line_ < y) from = next_line_;
    }
    for (int i = from; i <= y; ++i) {
      if (TIFFReadScanline(file_.handle(), line_.data(), static_cast<std::uint32_t>(i), 0) != 1) {
        throw InputError(fmt::format("The picture '{}' is damaged at line {} ({}).",
                                     header_.path.string(), i, file_.last_complaint()));
      }
    }
    next_line_ = y + 1;
  }

  void read_line(int y, std::span<float> out) {
    fetch_line(y);
    const TiffPage& page = file_.page();
    const auto n = static_cast<std::size_t>(page.samples);
    const auto at = [&](std::size_t i) -> float {
      if (page.bits == 8) return static_cast<float>(line_[i]) / 255.0F;
      if (page.bits == 16) {
        std::uint16_t v = 0;
        std::memcpy(&v, line_.data() + 2 * i, 2);
        return static_cast<float>(v) / 65535.0F;
      }
      float v = 0;
      std::memcpy(&v, line_.data() + 4 * i, 4);
      return v;
    };
    for (std::size_t x = 0; x < out.size() / 3; ++x) {
      for (std::size_t k = 0; k < 3; ++k) out[3 * x + k] = at(x * n + channel(k));
    }
  }

  void choose_decode(const PictureChoice& choice) {
    own_white_ = white_of(Illuminant::kD65);
    if (choice.xyz_from_samples) {
      encoding_ = "given";
      decode_ = linear_decode(*choice.xyz_from_samples);
      return;
    }
    const std::vector<std::byte> icc = file_.blob(kIccTag);
    if (!icc.empty()) {
      std::string why;
      decode_ = icc_decode(icc, why);
      if (decode_) {
        encoding_ = "ICC profile";
        return;
      }
      notes_.push_back(why);
    }
    const bool linear = choice.untagged_is_linear || file_.page().is_float;
    encoding_ = linear ? "linear sRGB assumed" : "sRGB assumed";
    notes_.push_back(fmt::format("It has no colour profile; {} is assumed.",
                                 linear ? "linear light with the primaries of sRGB" : "sRGB"));
    decode_ =
        linear ? linear_decode(xyz_from_linear_srgb()) : srgb_curve_decode(xyz_from_linear_srgb());
  }

  TiffFile file_;
  bool by_lines_ = true;
  int next_line_ = 0;
  std::vector<std::uint8_t> line_;
  std::vector<std::uint16_t> samples_;
  std::unique_ptr<ColorDecode> decode_;
};

}  // namespace

PictureHeader read_tiff_picture_header(const std::filesystem::path& path) {
  const TiffFile file(path);
  require_usable(file);
  PictureHeader header;
  header.path = path;
  header.format = "TIFF";
  header.width_px = file.page().width_px;
  header.height_px = file.page().height_px;
  header.has_color = true;
  return header;
}

std::unique_ptr<Picture> open_tiff_picture(const PictureHeader& header,
                                           const PictureChoice& choice) {
  return std::make_unique<TiffPicture>(header, choice);
}

}  // namespace reseau::compare
