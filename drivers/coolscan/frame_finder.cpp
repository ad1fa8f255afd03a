#include "drivers/coolscan/frame_finder.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace reseau::coolscan {
namespace {

// Left out at each side: perforations, mask.
constexpr double kSideShare = 0.12;
constexpr double kReachShare = 0.10;
// A gap is a line whose detail is below this share of that around it.
constexpr double kGapShare = 0.12;

// Unevenness across the film of every line, in logarithms so that dark and bright films look alike.
std::vector<double> detail_of(const Overview& overview) {
  const auto width = static_cast<std::size_t>(overview.width_px);
  const auto side = static_cast<std::size_t>(kSideShare * overview.width_px);
  std::vector<double> detail;
  for (int line = 0; line < overview.n_lines; ++line) {
    double total = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto row =
          overview.samples.subspan((static_cast<std::size_t>(line) * 3 + c) * width, width)
              .subspan(side, width - 2 * side);
      double sum = 0, squares = 0;
      for (const std::uint16_t sample : row) {
        constexpr double kFloor = 256;  // noise of the darkest film
        const double level = std::log(sample + kFloor);
        sum += level;
        squares += level * level;
      }
      const auto n = static_cast<double>(row.size());
      total += std::sqrt(std::max(squares / n - sum / n * (sum / n), 0.0));
    }
    detail.push_back(total);
  }
  return detail;
}

double median_around(const std::vector<double>& values, int from, int to) {
  const int n = static_cast<int>(values.size());
  from = std::clamp(from, 0, n);
  to = std::clamp(to, from, n);
  std::vector<double> part(values.begin() + from, values.begin() + to);
  if (part.empty()) return 0;
  std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2),
                   part.end());
  return part[part.size() / 2];
}

// Middle of the gap nearest to a line within reach, or a negative number. Detail at most `limit`.
double gap_near(const std::vector<double>& detail, double expected, double reach, double limit) {
  const int n = static_cast<int>(detail.size());
  const int from = std::max(0, static_cast<int>(expected - reach));
  const int to = std::min(n - 1, static_cast<int>(expected + reach));
  int best = -1;
  for (int line = from; line <= to; ++line) {
    if (detail[static_cast<std::size_t>(line)] > limit) continue;
    if (best < 0 || std::abs(line - expected) < std::abs(best - expected)) best = line;
  }
  if (best < 0) return -1;
  int first = best, last = best;
  while (first > 0 && detail[static_cast<std::size_t>(first) - 1] <= limit) --first;
  while (last + 1 < n && detail[static_cast<std::size_t>(last) + 1] <= limit) ++last;
  // Film before the first frame or behind the last one is even, too: only its near end counts.
  const double length = last - first + 1;
  if (length > 2 * reach) return first <= from ? last : first;
  return (first + last) / 2.0;
}

}  // namespace

std::vector<FoundFrame> find_frames(const Overview& overview, double frame_lines, int n_frames) {
  CHECK(overview.samples.size() == static_cast<std::size_t>(overview.n_lines) * 3 *
                                       static_cast<std::size_t>(overview.width_px));
  std::vector<FoundFrame> frames;
  if (overview.width_px < 8 || overview.n_lines < 2 || !(frame_lines >= 4) || n_frames < 1) {
    return frames;
  }
  const std::vector<double> detail = detail_of(overview);
  constexpr double kNoContrast = 1e-3;
  if (*std::max_element(detail.begin(), detail.end()) < kNoContrast) return frames;
  const double reach = kReachShare * frame_lines;
  // A frame begins where the one before it ended, so that a strip whose wind differs from the
  // raster is followed.
  double expected = 0;
  for (int k = 0; k < n_frames; ++k) {
    const double around =
        median_around(detail, static_cast<int>(expected), static_cast<int>(expected + frame_lines));
    const double gap = gap_near(detail, expected, reach, kGapShare * around);
    FoundFrame frame{expected, false};
    if (gap >= 0 && around > 0) frame = {gap, true};
    if (frame.top_line >= overview.n_lines) break;
    frames.push_back(frame);
    expected = frame.top_line + frame_lines;
  }
  return frames;
}

}  // namespace reseau::coolscan
