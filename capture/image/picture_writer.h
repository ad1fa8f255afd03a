#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "capture/image/exr_file.h"
#include "capture/image/view_encoding.h"
#include "core/reconstruct/row_sink.h"

namespace reseau {

struct PictureOptions {
  std::filesystem::path exr;   // always written
  ExrOptions exr_options;      // `existing` holds for the view copies as well
  std::filesystem::path tiff;  // 16-bit view copy, sRGB with profile; empty = none
  std::filesystem::path png;   // 8-bit view copy, sRGB; empty = none
  double dpi = 0;              // of the view copies; 0 = unknown
  // Multiplies the view copies; absent = chosen so that the 99.5th percentile of luminance becomes
  // white.
  std::optional<double> exposure;
  ViewGamut gamut = ViewGamut::kClip;  // of the view copies
  // Row-major, linear sRGB from the picture's own space, for the view copies.
  std::array<double, 9> srgb_from_picture{1, 0, 0, 0, 1, 0, 0, 0, 1};
};

struct PictureResult {
  std::string exr_sha256;
  int width_px = 0, height_px = 0;
  double exposure = 1;        // of the view copies
  double luminance_p995 = 0;  // of the picture, linear
  // Pixels of the view copies that lay outside sRGB or above white and were clipped or compressed.
  double clipped_fraction = 0;
};

// Writes a reconstruction as it comes, row by row: the EXR at once; the view copies at end(), from
// the EXR, because their exposure depends on the whole picture. Nothing is held in memory but a few
// rows. Files get their names at end(); a writer destroyed before leaves none. Thread-bound.
class PictureWriter final : public RgbRowSink {
 public:
  explicit PictureWriter(PictureOptions options);
  ~PictureWriter() override;
  PictureWriter(const PictureWriter&) = delete;
  PictureWriter& operator=(const PictureWriter&) = delete;

  // Throw InputError (name taken) or std::system_error (disk).
  void begin(int width_px, int height_px) override;
  void rows(int first_row, int n_rows, std::span<const float> rgb) override;
  void end() override;

  // Valid after end().
  [[nodiscard]] const PictureResult& result() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace reseau
