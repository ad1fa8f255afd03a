#include "capture/image/png_memory.h"

#include <cstddef>
#include <system_error>

#include <png.h>

#include "core/base/check.h"

namespace reseau {

std::string encode_png(int width_px, int height_px, std::span<const std::uint8_t> rgb) {
  CHECK(width_px > 0 && height_px > 0);
  CHECK(rgb.size() == static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_px);
  image.height = static_cast<png_uint_32>(height_px);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0) {
    throw std::system_error(std::make_error_code(std::errc::io_error),
                            std::string("A PNG picture cannot be made: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace reseau
