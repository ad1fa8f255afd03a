// Infrared that comes apart from the colours: a second page of the scan or a file beside it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/tiff_file.h"

namespace reseau {

struct InfraredPlane {
  std::vector<std::uint16_t> samples;  // [line][pixel]
  int n_lines = 0;
};

// NAME_IR.tif, NAME-IR.tif, NAME_ir.tif, NAME-ir.tif (also .tiff, .TIF, .TIFF) beside NAME.tif;
// empty when there is none.
[[nodiscard]] std::filesystem::path find_infrared_sidecar(const std::filesystem::path& scan);

// The first later page of `file` with one sample and the size of the first; moves `file` there.
// Other pages are passed over, with a note when they are no thumbnails.
[[nodiscard]] std::optional<InfraredPlane> read_infrared_page(TiffFile& file,
                                                              std::vector<std::string>& notes);

// Throws InputError when the file is no grey TIFF of this size.
[[nodiscard]] InfraredPlane read_infrared_file(const std::filesystem::path& path, int width_px,
                                               int height_px);

// Inserts the plane behind the others: [line][n][pixel] to [line][n + 1][pixel], for the lines that
// both have. `width` in pixels.
[[nodiscard]] std::vector<std::uint16_t> with_plane(const std::vector<std::uint16_t>& samples,
                                                    std::size_t channels, std::size_t width,
                                                    const InfraredPlane& plane, int n_lines);

}  // namespace reseau
