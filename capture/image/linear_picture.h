// Channels of any picture in linear light, as floats, region by region: for measuring.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/scan_reader.h"

namespace reseau {

struct PixelRect {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelRect&) const = default;
};

class LinearPicture {
 public:
  // TIFF as read_scan takes it, grey too; TIFF of 32-bit floats unclamped; EXR (R G B IR Y, or
  // whatever channels it has). `gamma` overrides an embedded profile. Throws as read_scan and
  // ExrReader do.
  explicit LinearPicture(const std::filesystem::path& path, const ReadScanOptions& options = {});
  ~LinearPicture();
  LinearPicture(const LinearPicture&) = delete;
  LinearPicture& operator=(const LinearPicture&) = delete;

  [[nodiscard]] int width_px() const;
  [[nodiscard]] int height_px() const;
  // "red", "green", "blue", "infrared", "grey", or the name in the file.
  [[nodiscard]] const std::vector<std::string>& channels() const;
  // Ends of the scale in linear light; infinite for floats.
  [[nodiscard]] double lowest() const;
  [[nodiscard]] double highest() const;
  // Step of the samples where it is widest; 0 for floats.
  [[nodiscard]] double quantum() const;
  // What the file says of the scanner; resolution 0 = unknown.
  [[nodiscard]] const CaptureContext& context() const;
  [[nodiscard]] double dpi() const;
  [[nodiscard]] const std::vector<std::string>& notes() const;

  // [row][pixel] of one channel. `rect` must lie within the picture.
  [[nodiscard]] std::vector<float> plane(std::size_t channel, const PixelRect& rect) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reseau
