#include "drivers/coolscan/ccd_curves.h"

#include <algorithm>
#include <cmath>

namespace reseau::coolscan {

std::optional<CurvePage> parse_curve_page(ByteView page) {
  if (page.size() < 11) return std::nullopt;
  const CurvePage curves{u8_at(page, 9), u8_at(page, 10)};
  if (curves.n_types < 1 || curves.n_points < 2) return std::nullopt;
  return curves;
}

std::optional<CcdCurves> CcdCurves::parse(ByteView data, const CurvePage& page, int sensor_lines) {
  constexpr std::size_t kHead = 6;
  const auto n = static_cast<std::size_t>(sensor_lines * page.n_types) *
                 static_cast<std::size_t>(page.n_points);
  if (sensor_lines < 1 || data.size() < kHead + 2 * n) return std::nullopt;
  CcdCurves curves(page.n_types, page.n_points);
  for (std::size_t i = 0; i < n; ++i) {
    curves.points_.push_back(static_cast<std::uint16_t>(load_be(data, kHead + 2 * i, 2)));
    const bool first_of_curve = i % static_cast<std::size_t>(page.n_points) == 0;
    if (!first_of_curve && curves.points_[i] <= curves.points_[i - 1]) return std::nullopt;
  }
  return curves;
}

std::vector<std::uint16_t> CcdCurves::table(int sensor_line, int type) const {
  if (sensor_line == 0) return {};
  if (type < 0 || type >= n_types_) type = 0;
  const std::uint16_t* const to = curve(0, type);
  const std::uint16_t* const from = curve(sensor_line, type);
  std::vector<std::uint16_t> table(65536);
  int k = 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const auto value = static_cast<double>(i);
    double answer = value;
    while (k < n_points_ && from[k] < i) ++k;
    if (k == n_points_) {
      answer = value * to[k - 1] / from[k - 1];
    } else if (k > 0) {
      const double t = (value - from[k - 1]) / (from[k] - from[k - 1]);
      answer = to[k - 1] + t * (to[k] - to[k - 1]);
    }
    table[i] = static_cast<std::uint16_t>(std::clamp(std::lround(answer), 0L, 65535L));
  }
  return table;
}

}  // namespace reseau::coolscan
