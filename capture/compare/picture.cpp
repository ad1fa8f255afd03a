#include "capture/compare/picture.h"

#include <array>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "capture/compare/picture_files.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

std::array<unsigned char, 8> first_bytes(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw InputError(fmt::format("'{}' is a folder; give a picture.", path.string()));
  }
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) {
    if (errno == ENOENT || errno == ENOTDIR) {
      throw InputError(fmt::format("There is no file '{}'.", path.string()));
    }
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("The file '{}' cannot be opened", path.string()));
  }
  std::array<unsigned char, 8> bytes{};
  const ssize_t n = ::read(fd, bytes.data(), bytes.size());
  ::close(fd);
  if (n <= 0) throw InputError(fmt::format("The file '{}' is empty.", path.string()));
  return bytes;
}

enum class Format { kExr, kTiff, kPng };

Format format_of(const std::filesystem::path& path) {
  const auto b = first_bytes(path);
  if (b[0] == 0x76 && b[1] == 0x2F && b[2] == 0x31 && b[3] == 0x01) return Format::kExr;
  if ((b[0] == 'I' && b[1] == 'I') || (b[0] == 'M' && b[1] == 'M')) return Format::kTiff;
  if (b[0] == 0x89 && b[1] == 'P' && b[2] == 'N' && b[3] == 'G') return Format::kPng;
  throw InputError(fmt::format(
      "The file '{}' is no picture that can be compared; give an OpenEXR, TIFF or PNG file.",
      path.string()));
}

}  // namespace

PictureHeader read_picture_header(const std::filesystem::path& path) {
  switch (format_of(path)) {
    case Format::kExr:
      return read_exr_picture_header(path);
    case Format::kTiff:
      return read_tiff_picture_header(path);
    case Format::kPng:
      return read_png_picture_header(path);
  }
  CHECK(false);
}

std::unique_ptr<Picture> open_picture(const PictureHeader& header, const PictureChoice& choice) {
  if (header.format == "OpenEXR") return open_exr_picture(header, choice);
  if (header.format == "TIFF") return open_tiff_picture(header, choice);
  return open_png_picture(header, choice);
}

void Picture::read_map(int /*first_row*/, int /*n_rows*/, std::span<float> /*out*/) {
  CHECK(header_.has_map);
}

}  // namespace reseau::compare
