#include "capture/image/tiff_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "capture/store/quoted.h"
#include "core/base/error.h"

namespace reseau {
namespace {

// The longest film scan there is has some 10^5 lines; beyond this only damage is found.
constexpr std::uint32_t kMaxSide = 1'000'000;
constexpr std::uint64_t kSmallestSuspect = std::uint64_t{64} << 20;
// Deflate cannot shrink further than 1032:1; the others come nowhere near this on scans.
constexpr std::uint64_t kMaxCompression = 5000;

int keep_message(TIFF* /*tiff*/, void* user, const char* /*module*/, const char* format,
                 va_list arguments) {
  std::array<char, 300> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  *static_cast<std::string*>(user) = text.data();
  return 1;
}

int drop_message(TIFF* /*tiff*/, void* /*user*/, const char* /*module*/, const char* /*format*/,
                 va_list /*arguments*/) {
  return 1;
}

const char* other_format(const std::array<unsigned char, 16>& b) {
  if (b[0] == 0x89 && b[1] == 'P' && b[2] == 'N' && b[3] == 'G') return "a PNG picture";
  if (b[0] == 0xFF && b[1] == 0xD8) return "a JPEG picture";
  if (b[0] == 0x76 && b[1] == 0x2F && b[2] == 0x31 && b[3] == 0x01) return "an OpenEXR picture";
  if (b[0] == '{') return "a JSON text";
  return nullptr;
}

std::uint64_t number_at(const std::array<unsigned char, 16>& bytes, std::size_t at, std::size_t n,
                        bool big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < n; ++i) {
    value = value << 8 | bytes[at + (big_endian ? i : n - 1 - i)];
  }
  return value;
}

// Throws unless the file begins as a TIFF whose directory lies inside it. Returns its size.
std::uint64_t check_beginning(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) {
      throw InputError("There is no file " + quoted(path) + ".");
    }
    throw std::system_error(errno, std::generic_category(),
                            "The file " + quoted(path) + " cannot be opened");
  }
  if (S_ISDIR(status.st_mode)) {
    throw InputError(quoted(path) + " is a folder; give the TIFF file of a scan.");
  }
  if (!S_ISREG(status.st_mode)) throw InputError(quoted(path) + " is not a regular file.");
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    throw std::system_error(errno, std::generic_category(),
                            "The file " + quoted(path) + " cannot be opened");
  }
  std::array<unsigned char, 16> begin{};
  const ssize_t n = ::pread(fd, begin.data(), begin.size(), 0);
  const int error = errno;
  ::close(fd);
  if (n < 0) {
    throw std::system_error(error, std::generic_category(),
                            "The file " + quoted(path) + " cannot be read");
  }
  if (n == 0) throw InputError("The file " + quoted(path) + " is empty (0 bytes).");

  const bool little = begin[0] == 'I' && begin[1] == 'I';
  const bool big = begin[0] == 'M' && begin[1] == 'M';
  const auto version = number_at(begin, 2, 2, big);
  if ((!little && !big) || (version != 42 && version != 43)) {
    const char* other = other_format(begin);
    throw InputError("The file " + quoted(path) + " is not a TIFF" +
                     (other != nullptr ? std::string(" but ").append(other) : "") +
                     "; scans are read from TIFF files.");
  }
  const auto size = static_cast<std::uint64_t>(status.st_size);
  const auto directory = version == 42 ? number_at(begin, 4, 4, big) : number_at(begin, 8, 8, big);
  if (n < (version == 42 ? 8 : 16) || directory >= size) {
    throw InputError("The file " + quoted(path) + " is cut off after " + std::to_string(size) +
                     " bytes: its directory would come later, so none of its lines can be read.");
  }
  return size;
}

double dots_per_inch(TIFF* tiff, std::uint32_t tag) {
  float value = 0;
  std::uint16_t unit = RESUNIT_INCH;
  if (TIFFGetField(tiff, tag, &value) != 1) return 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
  if (unit != RESUNIT_INCH && unit != RESUNIT_CENTIMETER) return 0;
  const double dpi = static_cast<double>(value) * (unit == RESUNIT_CENTIMETER ? 2.54 : 1.0);
  return std::isfinite(dpi) && dpi > 1 && dpi < 1e6 ? dpi : 0;
}

struct Piece {
  std::uint64_t offset, bytes;
};

Piece piece_at(TIFF* tiff, std::uint32_t index) {
  return {TIFFGetStrileOffset(tiff, index), TIFFGetStrileByteCount(tiff, index)};
}

bool inside(const Piece& piece, std::uint64_t file_bytes) {
  return piece.offset <= file_bytes && piece.bytes <= file_bytes - piece.offset;
}

std::uint32_t rows_per_strip(TIFF* tiff, const TiffPage& page) {
  std::uint32_t rows = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
  return std::clamp<std::uint32_t>(rows, 1, static_cast<std::uint32_t>(page.height_px));
}

// Lines before the first strip of a plane that is not all there.
int strip_lines_in_file(TIFF* tiff, const TiffPage& page, std::uint64_t file_bytes,
                        std::uint32_t first_strip) {
  const std::uint32_t rows = rows_per_strip(tiff, page);
  const auto height = static_cast<std::uint32_t>(page.height_px);
  const std::uint64_t row_bytes =
      page.row_bytes() / static_cast<std::uint64_t>(page.planar ? page.samples : 1);
  for (std::uint32_t y = 0, strip = first_strip; y < height;
       y += std::min(rows, height - y), ++strip) {
    Piece piece = piece_at(tiff, strip);
    // Some writers give a byte count for whole strips only; the lines are what counts.
    if (!page.compressed) piece.bytes = std::min(rows, height - y) * row_bytes;
    if (piece.offset == 0) return static_cast<int>(y);
    if (inside(piece, file_bytes)) continue;
    if (page.compressed || piece.offset >= file_bytes || row_bytes == 0) return static_cast<int>(y);
    return static_cast<int>(y + (file_bytes - piece.offset) / row_bytes);
  }
  return page.height_px;
}

int tile_lines_in_file(TIFF* tiff, const TiffPage& page, std::uint64_t file_bytes) {
  std::uint32_t tile_height = 0;
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tile_height);
  const std::uint32_t n_tiles = TIFFNumberOfTiles(tiff);
  int lines = page.height_px;
  const auto height = static_cast<std::uint32_t>(page.height_px);
  const std::uint32_t down = tile_height == 0 ? 1 : (height + tile_height - 1) / tile_height;
  const std::uint32_t planes = page.planar ? static_cast<std::uint32_t>(page.samples) : 1;
  const std::uint32_t across = std::max(1U, n_tiles / std::max(1U, down * planes));
  for (std::uint32_t tile = 0; tile < n_tiles; ++tile) {
    if (inside(piece_at(tiff, tile), file_bytes) && piece_at(tiff, tile).offset != 0) continue;
    const std::uint32_t row = tile / across % down;
    lines = std::min(lines, static_cast<int>(row * tile_height));
  }
  return lines;
}

std::optional<std::uint64_t> plain_offset(TIFF* tiff, const TiffPage& page) {
  if (page.compressed || page.tiled || (page.planar && page.samples > 1) || page.bits != 16 ||
      TIFFIsByteSwapped(tiff) != 0) {
    return std::nullopt;
  }
  const std::uint32_t rows = rows_per_strip(tiff, page);
  const std::uint64_t first = piece_at(tiff, 0).offset;
  std::uint32_t strip = 0;
  for (std::uint64_t y = 0; y < static_cast<std::uint64_t>(page.height_px); y += rows, ++strip) {
    if (piece_at(tiff, strip).offset != first + y * page.row_bytes()) return std::nullopt;
  }
  return first;
}

TiffPage read_page(TIFF* tiff, const std::filesystem::path& path, std::uint64_t file_bytes) {
  std::uint32_t width = 0, height = 0, subfile = 0;
  std::uint16_t samples = 1, bits = 1, format = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG;
  std::uint16_t photometric = 0xFFFF, orientation = ORIENTATION_TOPLEFT;
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &subfile);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);

  const std::string claim = "The file " + quoted(path) + " claims " + std::to_string(width) +
                            " x " + std::to_string(height) + " pixels";
  if (width == 0 || height == 0 || samples == 0) throw InputError(claim + ": it holds no picture.");
  if (width > kMaxSide || height > kMaxSide) {
    throw InputError(claim + ", more than any scan has; it is damaged.");
  }
  TiffPage page;
  page.width_px = static_cast<int>(width);
  page.height_px = static_cast<int>(height);
  page.samples = samples;
  page.bits = bits;
  page.is_float = format == SAMPLEFORMAT_IEEEFP;
  page.is_unsigned = format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID;
  page.planar = planar == PLANARCONFIG_SEPARATE;
  page.tiled = TIFFIsTiled(tiff) != 0;
  page.compressed = compression != COMPRESSION_NONE;
  page.reduced = (subfile & FILETYPE_REDUCEDIMAGE) != 0;
  page.photometric = photometric;
  page.orientation = orientation;
  page.x_dpi = dots_per_inch(tiff, TIFFTAG_XRESOLUTION);
  page.y_dpi = dots_per_inch(tiff, TIFFTAG_YRESOLUTION);

  const std::uint64_t claimed_bytes = page.row_bytes() * height;
  if (page.compressed && claimed_bytes > kSmallestSuspect &&
      claimed_bytes / kMaxCompression > file_bytes) {
    throw InputError(claim + " in " + std::to_string(file_bytes) +
                     " bytes, which cannot be; it is damaged.");
  }
  if (page.tiled) {
    page.lines_in_file = tile_lines_in_file(tiff, page, file_bytes);
  } else {
    page.lines_in_file = page.height_px;
    const std::uint32_t per_plane =
        (height + rows_per_strip(tiff, page) - 1) / rows_per_strip(tiff, page);
    for (std::uint32_t plane = 0; plane < (page.planar ? samples : 1U); ++plane) {
      page.lines_in_file = std::min(page.lines_in_file,
                                    strip_lines_in_file(tiff, page, file_bytes, plane * per_plane));
    }
  }
  // Pieces that overlap would let a small file claim any amount of memory.
  if (!page.compressed &&
      static_cast<std::uint64_t>(page.lines_in_file) * page.row_bytes() > file_bytes) {
    throw InputError(claim + " in " + std::to_string(file_bytes) +
                     " bytes, which cannot be; it is damaged.");
  }
  page.plain_offset = plain_offset(tiff, page);
  return page;
}

}  // namespace

TiffFile::TiffFile(const std::filesystem::path& path)
    : path_(path), file_bytes_(check_beginning(path)), complaint_(std::make_unique<std::string>()) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(std::max<std::uint64_t>(
                                                         std::uint64_t{256} << 20, file_bytes_)));
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_message, complaint_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), drop_message, nullptr);
  // "m": without a memory map, which would end the program when the file is shortened meanwhile.
  tiff_ = TIFFOpenExt(path_.c_str(), "rm", options.get());
  if (tiff_ == nullptr) {
    throw InputError("The TIFF file " + quoted(path_) + " is damaged (" + *complaint_ + ").");
  }
  try {
    page_ = read_page(tiff_, path_, file_bytes_);
  } catch (...) {
    TIFFClose(tiff_);
    throw;
  }
}

TiffFile::~TiffFile() { TIFFClose(tiff_); }

bool TiffFile::next_page() {
  if (TIFFReadDirectory(tiff_) != 1) return false;
  try {
    page_ = read_page(tiff_, path_, file_bytes_);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

std::string TiffFile::text(std::uint32_t tag) const {
  const char* value = nullptr;
  return TIFFGetField(tiff_, tag, &value) == 1 && value != nullptr ? value : "";
}

std::vector<std::byte> TiffFile::blob(std::uint32_t tag) const {
  std::uint32_t size = 0;
  const void* data = nullptr;
  if (TIFFGetField(tiff_, tag, &size, &data) != 1 || data == nullptr) return {};
  const auto* bytes = static_cast<const std::byte*>(data);
  return {bytes, bytes + size};
}

}  // namespace reseau
