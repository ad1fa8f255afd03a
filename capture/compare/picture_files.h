// One opener per file format; see picture.h for what they promise.
#pragma once

#include <memory>

#include "capture/compare/picture.h"

namespace reseau::compare {

[[nodiscard]] PictureHeader read_exr_picture_header(const std::filesystem::path& path);
[[nodiscard]] PictureHeader read_tiff_picture_header(const std::filesystem::path& path);
[[nodiscard]] PictureHeader read_png_picture_header(const std::filesystem::path& path);

[[nodiscard]] std::unique_ptr<Picture> open_exr_picture(const PictureHeader& header,
                                                        const PictureChoice& choice);
[[nodiscard]] std::unique_ptr<Picture> open_tiff_picture(const PictureHeader& header,
                                                         const PictureChoice& choice);
[[nodiscard]] std::unique_ptr<Picture> open_png_picture(const PictureHeader& header,
                                                        const PictureChoice& choice);

}  // namespace reseau::compare
