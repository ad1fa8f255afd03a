#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>
#include <png.h>

#include "capture/compare/color_decode.h"
#include "capture/compare/picture_files.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

constexpr png_uint_32 kMaxSide = 1'000'000;
// Deflate cannot shrink further than 1032:1.
constexpr std::uintmax_t kMaxCompression = 1100;

// A PNG read whole, as 16-bit RGBA. libpng is C: it must not be left by an exception, so failures
// jump to the setjmp of call().
class PngFile {
 public:
  explicit PngFile(const std::filesystem::path& path) : path_(path) {
    file_ = std::fopen(path.c_str(), "rbe");
    if (file_ == nullptr) throw InputError(fmt::format("There is no file '{}'.", path.string()));
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    CHECK(png_ != nullptr);
    info_ = png_create_info_struct(png_);
    CHECK(info_ != nullptr);
    try {
      call([this] {
        png_init_io(png_, file_);
        png_set_user_limits(png_, kMaxSide, kMaxSide);
        png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, 0);
        png_read_info(png_, info_);
      });
    } catch (...) {
      close();
      throw;
    }
  }
  ~PngFile() { close(); }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  [[nodiscard]] int width_px() const { return static_cast<int>(png_get_image_width(png_, info_)); }
  [[nodiscard]] int height_px() const {
    return static_cast<int>(png_get_image_height(png_, info_));
  }
  [[nodiscard]] bool has_alpha() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_ALPHA) != 0 ||
           png_get_valid(png_, info_, PNG_INFO_tRNS) != 0;
  }
  [[nodiscard]] std::vector<std::byte> icc() {
    png_charp name = nullptr;
    png_bytep data = nullptr;
    png_uint_32 size = 0;
    int compression = 0;
    if (png_get_iCCP(png_, info_, &name, &compression, &data, &size) == 0) return {};
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    return {bytes, bytes + size};
  }
  [[nodiscard]] bool is_srgb() {
    int intent = 0;
    return png_get_sRGB(png_, info_, &intent) != 0;
  }
  // Encoding exponent, 0 when the file does not say.
  [[nodiscard]] double gamma() {
    double value = 0;
    return png_get_gAMA(png_, info_, &value) != 0 ? value : 0;
  }
  [[nodiscard]] std::optional<Chromaticities> chromaticities() {
    std::array<double, 8> v{};
    if (png_get_cHRM(png_, info_, v.data(), &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7]) == 0) {
      return std::nullopt;
    }
    return Chromaticities{{{{v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}, {v[0], v[1]}}}};
  }

  // [row][pixel][4], host byte order.
  [[nodiscard]] std::vector<std::uint16_t> pixels() {
    const auto width = static_cast<std::size_t>(width_px());
    const auto height = static_cast<std::size_t>(height_px());
    if (width * height / kMaxCompression > std::filesystem::file_size(path_)) {
      throw InputError(
          fmt::format("The file '{}' claims {} × {} pixels, which cannot be; it is "
                      "damaged.",
                      path_.string(), width, height));
    }
    std::vector<std::uint16_t> samples(width * height * 4);
    std::vector<png_bytep> rows(height);
    for (std::size_t y = 0; y < height; ++y) {
      rows[y] = reinterpret_cast<png_bytep>(samples.data() + y * width * 4);
    }
    call([&] {
      png_set_expand_16(png_);
      png_set_gray_to_rgb(png_);
      png_set_add_alpha(png_, 0xFFFF, PNG_FILLER_AFTER);
      if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
      png_read_update_info(png_, info_);
      if (png_get_rowbytes(png_, info_) != width * 8) png_error(png_, "unexpected row size");
      png_read_image(png_, rows.data());
    });
    return samples;
  }

 private:
  [[noreturn]] static void on_error(png_structp png, png_const_charp text) {
    auto* file = static_cast<PngFile*>(png_get_error_ptr(png));
    std::snprintf(file->message_.data(), file->message_.size(), "%s", text);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp /*png*/, png_const_charp /*text*/) {}

  // `action` must own nothing: a jump would not destroy it.
  template <typename Action>
  void call(const Action& action) {
    if (setjmp(png_jmpbuf(png_)) == 0) {
      action();
      return;
    }
    throw InputError(fmt::format("The PNG picture '{}' is cut off or damaged ({}).", path_.string(),
                                 message_.data()));
  }
  void close() {
    png_destroy_read_struct(&png_, &info_, nullptr);
    if (file_ != nullptr) std::fclose(file_);
    file_ = nullptr;
  }

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::array<char, 200> message_{};
};

class PngPicture final : public Picture {
 public:
  PngPicture(PictureHeader header, const PictureChoice& choice) : Picture(std::move(header)) {
    PngFile file(header_.path);
    choose_decode(file, choice);
    if (file.has_alpha()) {
      notes_.emplace_back("Pixels with alpha 0 are left out; others count as they are stored.");
    }
    samples_ = file.pixels();
  }

  void read(int first_row, int n_rows, std::span<float> out) override {
    const auto width = static_cast<std::size_t>(header_.width_px);
    const std::size_t first = static_cast<std::size_t>(first_row) * width;
    const std::size_t n = width * static_cast<std::size_t>(n_rows);
    CHECK(out.size() == 3 * n && (first + n) * 4 <= samples_.size());
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint16_t* const from = &samples_[(first + i) * 4];
      for (std::size_t k = 0; k < 3; ++k) {
        out[3 * i + k] = from[3] == 0 ? NAN : static_cast<float>(from[k]) / 65535.0F;
      }
    }
  }
  void to_xyz(std::span<const float> samples, std::span<float> xyz) const override {
    decode_->to_xyz(samples, xyz);
  }

 private:
  void choose_decode(PngFile& file, const PictureChoice& choice) {
    own_white_ = white_of(Illuminant::kD65);
    if (choice.xyz_from_samples) {
      encoding_ = "given";
      decode_ = linear_decode(*choice.xyz_from_samples);
      return;
    }
    const std::vector<std::byte> icc = file.icc();
    if (!icc.empty()) {
      std::string why;
      decode_ = icc_decode(icc, why);
      if (decode_) {
        encoding_ = "ICC profile";
        return;
      }
      notes_.push_back(why);
    }
    const double gamma = file.gamma();
    if (!file.is_srgb() && gamma > 0 && std::abs(gamma - 0.45455) > 1e-3) {
      const auto declared = file.chromaticities();
      encoding_ = fmt::format("gamma {:.4g}", 1 / gamma);
      decode_ =
          gamma_decode(1 / gamma, declared ? xyz_from_rgb(*declared) : xyz_from_linear_srgb());
      return;
    }
    const bool tagged = file.is_srgb() || gamma > 0;
    if (!tagged && choice.untagged_is_linear) {
      encoding_ = "linear sRGB assumed";
      decode_ = linear_decode(xyz_from_linear_srgb());
      return;
    }
    encoding_ = tagged ? "sRGB" : "sRGB assumed";
    if (!tagged) notes_.emplace_back("It has no colour profile; sRGB is assumed.");
    decode_ = srgb_curve_decode(xyz_from_linear_srgb());
  }

  std::vector<std::uint16_t> samples_;
  std::unique_ptr<ColorDecode> decode_;
};

}  // namespace

PictureHeader read_png_picture_header(const std::filesystem::path& path) {
  const PngFile file(path);
  PictureHeader header;
  header.path = path;
  header.format = "PNG";
  header.width_px = file.width_px();
  header.height_px = file.height_px();
  header.has_color = true;
  return header;
}

std::unique_ptr<Picture> open_png_picture(const PictureHeader& header,
                                          const PictureChoice& choice) {
  return std::make_unique<PngPicture>(header, choice);
}

}  // namespace reseau::compare
