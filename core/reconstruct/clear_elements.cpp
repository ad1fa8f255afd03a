#include "core/reconstruct/clear_elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Dense>

#include "core/base/parallel.h"
#include "core/screen/lattice_search.h"

namespace reseau {
namespace {

constexpr double kMostPixels = 5e5;
constexpr std::size_t kFewestPixels = 200;  // amid each element
constexpr std::uint16_t kFullScale = 65500;
// So much of the light of a pixel must be that of its element.
constexpr double kOwnLight = 0.45;
constexpr double kClearQuantile = 0.999;
constexpr int kRounds = 4;  // the third changes the fourth digit

struct AmidPixel {
  std::array<float, 3> rgb{};
  std::uint8_t element = 0;
  bool clipped = false;
};

double to_nearest(double x) { return x - std::floor(x + 0.5); }

// The element in whose middle a point of the screen lies, or -1.
int amid_element(Vec2 screen, const ScreenPattern& pattern) {
  for (const ElementMiddle& m : pattern.middles()) {
    const Vec2 d = screen - m.middle;
    if (std::abs(to_nearest(d.x)) < m.half.x && std::abs(to_nearest(d.y)) < m.half.y)
      return m.color;
  }
  return -1;
}

std::vector<AmidPixel> pixels_amid(const LineSource& source, const Registration& registration,
                                   const ToneCurves& tone, const ScreenPattern& pattern,
                                   const std::stop_token& stop) {
  const LineFormat& format = source.format();
  constexpr std::array kOrder{Channel::kRed, Channel::kGreen, Channel::kBlue};
  std::array<std::size_t, 3> plane{};
  for (std::size_t c = 0; c < 3; ++c) {
    plane[c] = static_cast<std::size_t>(format.plane_of(kOrder[c]));
  }
  const int n_lines = source.committed();
  const double n_pixels = static_cast<double>(format.width_px) * n_lines;
  const int step = std::max(1, static_cast<int>(std::ceil(std::sqrt(n_pixels / kMostPixels))));
  const int n_rows = (n_lines + step - 1) / step;
  std::vector<std::vector<AmidPixel>> of_row(static_cast<std::size_t>(n_rows));
  parallel_for(n_rows, [&](int row) {
    if (stop.stop_requested()) return;
    const int y = row * step;
    std::vector<std::uint16_t> line(format.samples_per_line());
    source.read(y, 1, line);
    for (int x = 0; x < format.width_px; x += step) {
      const Vec2 at = registration.map.screen_from_scan({double(x), double(y)});
      const int element = amid_element(at, pattern);
      if (element < 0) continue;
      AmidPixel pixel;
      pixel.element = static_cast<std::uint8_t>(element);
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint16_t raw = line[plane[c] * static_cast<std::size_t>(format.width_px) +
                                       static_cast<std::size_t>(x)];
        pixel.clipped |= raw >= kFullScale;
        pixel.rgb[c] = tone.table(static_cast<int>(c))[raw];
      }
      of_row[static_cast<std::size_t>(row)].push_back(pixel);
    }
  });
  std::vector<AmidPixel> pixels;
  for (const auto& row : of_row) pixels.insert(pixels.end(), row.begin(), row.end());
  return pixels;
}

Eigen::Matrix3d columns_of(const Response& response) {
  Eigen::Matrix3d p;
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      p(c, k) = response[static_cast<std::size_t>(k)][static_cast<std::size_t>(c)];
    }
  }
  return p;
}

// Silver behind one element, sorted; what is clipped stands at the end and counts as infinite.
struct Behind {
  std::vector<double> silver;
  std::size_t n_clipped = 0;

  [[nodiscard]] double quantile(double q) const {
    const auto at = static_cast<std::size_t>(q * static_cast<double>(silver.size() - 1));
    return at + n_clipped < silver.size() ? silver[at] : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] double highest_known() const {
    return 1 - static_cast<double>(n_clipped + 1) / static_cast<double>(silver.size());
  }
};

std::array<Behind, 3> silver_behind(const std::vector<AmidPixel>& pixels, const Response& response,
                                    const std::array<double, 3>& weights) {
  const Eigen::Matrix3d light_from_rgb = columns_of(response).inverse();
  std::array<Behind, 3> behind;
  for (const AmidPixel& pixel : pixels) {
    const Eigen::Vector3d rgb(double{pixel.rgb[0]}, double{pixel.rgb[1]}, double{pixel.rgb[2]});
    const Eigen::Vector3d light = light_from_rgb * rgb;
    if (!(light(pixel.element) > kOwnLight * light.cwiseAbs().sum())) continue;
    Behind& to = behind[pixel.element];
    to.n_clipped += pixel.clipped ? 1 : 0;
    to.silver.push_back(pixel.clipped
                            ? std::numeric_limits<double>::infinity()
                            : weights[0] * rgb(0) + weights[1] * rgb(1) + weights[2] * rgb(2));
  }
  for (Behind& each : behind) std::sort(each.silver.begin(), each.silver.end());
  return behind;
}

// What the brightest silver behind each element is now; false when the pixels do not tell.
bool brightest_silver(const std::array<Behind, 3>& behind, std::array<double, 3>& brightest) {
  double q = kClearQuantile;
  for (const Behind& each : behind) {
    if (each.silver.size() < kFewestPixels) return false;
    q = std::min(q, each.highest_known());
  }
  if (!(q > 0.5)) return false;
  // Where a channel clips, the elements are compared a little below, and the others tell how much
  // brighter it gets.
  double above = 0;
  int n = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    brightest[k] = behind[k].quantile(q);
    const double top = behind[k].quantile(kClearQuantile);
    if (!(brightest[k] > 0)) return false;
    if (!std::isfinite(top)) continue;
    above += std::log(top / brightest[k]);
    ++n;
  }
  if (n > 0) {
    for (double& value : brightest) value *= std::exp(above / n);
  }
  return true;
}

void scale_to_brightest_answer(Response& response) {
  double brightest = 0;
  for (const auto& element : response) {
    for (const double value : element) brightest = std::max(brightest, value);
  }
  if (!(brightest > 0)) return;
  for (auto& element : response) {
    for (double& value : element) value /= brightest;
  }
}

}  // namespace

void scale_to_clear(const LineSource& source, const Registration& registration,
                    const ToneCurves& tone, const ScreenPattern& pattern,
                    const std::stop_token& stop, Response& response) {
  scale_to_brightest_answer(response);
  const std::vector<AmidPixel> pixels = pixels_amid(source, registration, tone, pattern, stop);
  Response scaled = response;
  for (int round = 0; round < kRounds; ++round) {
    std::array<double, 3> weights{}, brightest{};
    if (stop.stop_requested() || !silver_weights(scaled, weights) ||
        !brightest_silver(silver_behind(pixels, scaled, weights), brightest)) {
      return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      for (double& value : scaled[k]) value *= brightest[k];
    }
  }
  response = scaled;
}

}  // namespace reseau
