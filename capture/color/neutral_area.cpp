#include "capture/color/neutral_area.h"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "core/base/error.h"

namespace reseau {

std::string NeutralArea::text() const {
  return whole ? "auto" : fmt::format("{},{},{},{}", x, y, width_px, height_px);
}

NeutralArea parse_neutral_area(const std::string& word) {
  if (word == "auto") return {};
  std::array<int, 4> v{};
  const char* at = word.data();
  const char* const end = at + word.size();
  std::size_t n = 0;
  while (n < v.size()) {
    const auto [next, error] = std::from_chars(at, end, v[n]);
    if (error != std::errc()) break;
    ++n;
    at = next;
    if (at == end || *at != ',') break;
    ++at;
  }
  if (n != 4 || at != end || v[0] < 0 || v[1] < 0 || v[2] <= 0 || v[3] <= 0) {
    throw InputError("--neutral " + word +
                     " is not understood; give auto, or an area in pixels as x,y,width,height.");
  }
  return {false, v[0], v[1], v[2], v[3]};
}

void AreaMean::begin(int width_px, int height_px) {
  width_px_ = width_px;
  if (area_.whole) {
    area_ = {false, 0, 0, width_px, height_px};
  } else if (area_.x >= width_px || area_.y >= height_px || area_.width_px > width_px - area_.x ||
             area_.height_px > height_px - area_.y) {
    throw InputError(fmt::format(
        "The neutral area {} does not lie within the picture, which has {} x {} pixels.",
        area_.text(), width_px, height_px));
  }
}

void AreaMean::rows(int first_row, int n_rows, std::span<const float> rgb) {
  for (int y = first_row; y < first_row + n_rows; ++y) {
    if (y < area_.y || y >= area_.y + area_.height_px) continue;
    const std::size_t at =
        (static_cast<std::size_t>(y - first_row) * static_cast<std::size_t>(width_px_) +
         static_cast<std::size_t>(area_.x)) *
        3;
    const auto row = rgb.subspan(at, static_cast<std::size_t>(area_.width_px) * 3);
    for (std::size_t i = 0; i < row.size(); i += 3) {
      if (!std::isfinite(row[i]) || !std::isfinite(row[i + 1]) || !std::isfinite(row[i + 2])) {
        continue;
      }
      for (std::size_t c = 0; c < 3; ++c) sum_[c] += double{row[i + c]};
      ++n_;
    }
  }
}

Vector3 AreaMean::mean() const {
  if (n_ == 0) throw InputError("The neutral area holds no pixel that is a number.");
  const auto n = static_cast<double>(n_);
  return {sum_[0] / n, sum_[1] / n, sum_[2] / n};
}

}  // namespace reseau
