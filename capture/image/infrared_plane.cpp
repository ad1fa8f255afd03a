#include "capture/image/infrared_plane.h"

#include <algorithm>

#include "capture/image/tiff_pixels.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr int kMaxPages = 32;

bool fits(const TiffPage& page, int width_px, int height_px) {
  return page.samples == 1 && page.width_px == width_px && page.height_px == height_px &&
         unsupported_reason(page).empty();
}

InfraredPlane decode_plane(TiffFile& file) {
  TiffPixels pixels = decode_page(file);
  return {std::move(pixels.samples), pixels.n_lines};
}

std::string size_text(int width_px, int height_px) {
  return std::to_string(width_px).append(" x ").append(std::to_string(height_px));
}

}  // namespace

std::filesystem::path find_infrared_sidecar(const std::filesystem::path& scan) {
  for (const char* role : {"_IR", "-IR", "_ir", "-ir"}) {
    for (const std::string& extension :
         {scan.extension().string(), std::string(".tif"), std::string(".tiff"), std::string(".TIF"),
          std::string(".TIFF")}) {
      auto candidate = scan.parent_path() / scan.stem();
      candidate += role;
      candidate += extension;
      std::error_code ignored;
      if (std::filesystem::is_regular_file(candidate, ignored)) return candidate;
    }
  }
  return {};
}

std::optional<InfraredPlane> read_infrared_page(TiffFile& file, std::vector<std::string>& notes) {
  const int width_px = file.page().width_px;
  const int height_px = file.page().height_px;
  int n_passed_over = 0;
  for (int i = 1; i < kMaxPages && file.next_page(); ++i) {
    if (fits(file.page(), width_px, height_px)) return decode_plane(file);
    if (!file.page().reduced) ++n_passed_over;
  }
  if (n_passed_over > 0) {
    notes.push_back("The file has " + std::to_string(n_passed_over) +
                    " further page(s) that are not infrared of the same size; they are not used.");
  }
  return std::nullopt;
}

InfraredPlane read_infrared_file(const std::filesystem::path& path, int width_px, int height_px) {
  TiffFile file(path);
  const TiffPage& page = file.page();
  std::string why = unsupported_reason(page);
  if (why.empty() && page.samples != 1) {
    why = "it has " + std::to_string(page.samples) + " channels instead of one";
  }
  if (why.empty() && !fits(page, width_px, height_px)) {
    why = "it has " + size_text(page.width_px, page.height_px) + " pixels and the scan " +
          size_text(width_px, height_px);
  }
  if (!why.empty()) {
    throw InputError("The infrared file '" + path.string() + "' cannot be used: " + why + ".");
  }
  InfraredPlane plane = decode_plane(file);
  if (plane.n_lines < height_px) {
    throw InputError("The infrared file '" + path.string() + "' is cut off or damaged: only " +
                     std::to_string(plane.n_lines) + " of " + std::to_string(height_px) +
                     " lines can be read.");
  }
  return plane;
}

std::vector<std::uint16_t> with_plane(const std::vector<std::uint16_t>& samples,
                                      std::size_t channels, std::size_t width,
                                      const InfraredPlane& plane, int n_lines) {
  CHECK(n_lines <= plane.n_lines &&
        samples.size() >= static_cast<std::size_t>(n_lines) * channels * width);
  std::vector<std::uint16_t> out(static_cast<std::size_t>(n_lines) * (channels + 1) * width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(n_lines); ++y) {
    auto* line = out.data() + y * (channels + 1) * width;
    std::copy_n(samples.data() + y * channels * width, channels * width, line);
    std::copy_n(plane.samples.data() + y * width, width, line + channels * width);
  }
  return out;
}

}  // namespace reseau
