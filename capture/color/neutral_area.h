// What of a picture should look neutral, and what it is on average.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/color/matrix3.h"
#include "core/reconstruct/row_sink.h"

namespace reseau {

// The whole picture (a grey world), or a rectangle of it.
struct NeutralArea {
  bool whole = true;
  int x = 0, y = 0, width_px = 0, height_px = 0;

  [[nodiscard]] std::string text() const;  // "auto" or "x,y,w,h"
};
// "auto" or "x,y,w,h" in pixels; InputError otherwise.
[[nodiscard]] NeutralArea parse_neutral_area(const std::string& word);

// Sums the pixels of an area as rows come; not finite ones are left out. Thread-bound.
class AreaMean final : public RgbRowSink {
 public:
  explicit AreaMean(const NeutralArea& area) : area_(area) {}
  // InputError when the area does not lie within the picture.
  void begin(int width_px, int height_px) override;
  // Whether any of these rows counts: the others need not be given.
  [[nodiscard]] bool wants(int first_row, int n_rows) const {
    return first_row < area_.y + area_.height_px && first_row + n_rows > area_.y;
  }
  void rows(int first_row, int n_rows, std::span<const float> rgb) override;
  void end() override {}
  // InputError when there was no pixel.
  [[nodiscard]] Vector3 mean() const;

 private:
  NeutralArea area_;
  int width_px_ = 0;
  Vector3 sum_{};
  std::uint64_t n_ = 0;
};

}  // namespace reseau
