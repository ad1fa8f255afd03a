#include "tests/support/synthetic_scan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace reseau::test {
namespace {

constexpr int kSub = 5;  // subsamples per pixel and axis

void blur_rows(std::vector<float>& image, int width, int height, const std::vector<float>& kernel) {
  const int reach = static_cast<int>(kernel.size()) / 2;
  std::vector<float> line(static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    float* row = &image[static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
    std::copy_n(row, width, line.begin());
    for (int x = 0; x < width; ++x) {
      float sum = 0;
      for (int k = -reach; k <= reach; ++k) {
        sum += kernel[static_cast<std::size_t>(k + reach)] *
               line[static_cast<std::size_t>(std::clamp(x + k, 0, width - 1))];
      }
      row[x] = sum;
    }
  }
}

std::vector<float> transpose(const std::vector<float>& image, int width, int height) {
  std::vector<float> out(image.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      out[static_cast<std::size_t>(x) * static_cast<std::size_t>(height) +
          static_cast<std::size_t>(y)] =
          image[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)];
    }
  }
  return out;
}

std::vector<float> gaussian(double sigma) {
  const int reach = std::max(1, static_cast<int>(std::ceil(4 * sigma)));
  std::vector<float> kernel;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double value =
        sigma > 0 ? std::exp(-0.5 * k * k / (sigma * sigma)) : (k == 0 ? 1.0 : 0.0);
    kernel.push_back(static_cast<float>(value));
    sum += value;
  }
  for (float& value : kernel) value = static_cast<float>(value / sum);
  return kernel;
}

}  // namespace

std::array<double, 2> SyntheticScan::screen_from_scan(double x, double y) const {
  if (mirrored) x = width_px - 1 - x;
  if (displacement_px) {
    const auto d = displacement_px(x, y);
    x += d[0];
    y += d[1];
  }
  const double radians = std::numbers::pi / 180;
  // Directions of the lines: red along a; the other printing at axes_deg to it.
  const double a = (90 - angle_deg) * radians;
  const double b = a - axes_deg * radians;
  // p = u * period_u * (cos a, sin a) + v * period_v' * (cos b, sin b); the period across is
  // measured at right angles to the red lines.
  const double along = period_u_px, across = period_v_px / std::sin(axes_deg * radians);
  const double m00 = along * std::cos(a), m01 = across * std::cos(b);
  const double m10 = along * std::sin(a), m11 = across * std::sin(b);
  const double det = m00 * m11 - m01 * m10;
  return {(m11 * x - m01 * y) / det + phase_u, (-m10 * x + m00 * y) / det + phase_v};
}

std::array<std::array<double, 3>, 3> SyntheticScan::response() const {
  std::array<std::array<double, 3>, 3> p{
      {{1.0, 0.13, 0.13}, {0.06, 0.81, 0.37}, {0.06, 0.17, 0.62}}};
  for (std::size_t c = 0; c < 3; ++c) {
    const double grey = (p[0][c] + p[1][c] + p[2][c]) / 3;
    for (auto& element : p) element[c] += fade * (grey - element[c]);
  }
  return p;
}

MemoryLineSource SyntheticScan::render() const {
  const int border = 8;
  const int w = (width_px + 2 * border) * kSub, h = (height_px + 2 * border) * kSub;
  const auto size = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  std::vector<float> plane[4];
  for (auto& p : plane) p.resize(size);
  const auto p_of = response();
  const double red_half = 21.0 / 49.9 / 2, green_half = 22.7 / 49.6 / 2;
  for (int j = 0; j < h; ++j) {
    for (int i = 0; i < w; ++i) {
      const double x = (i + 0.5) / kSub - 0.5 - border, y = (j + 0.5) / kSub - 0.5 - border;
      const auto s = screen_from_scan(x, y);
      const double u = s[0] - std::round(s[0]), v = s[1] - std::floor(s[1]);
      const std::size_t k = std::abs(v - 0.5) < red_half ? 0 : (std::abs(u) < green_half ? 1 : 2);
      const double t = scene ? scene(x, y)[k] : 0.6;
      const std::size_t at =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(w) + static_cast<std::size_t>(i);
      for (std::size_t c = 0; c < 3; ++c) plane[c][at] = static_cast<float>(t * p_of[k][c]);
      plane[3][at] = static_cast<float>(t);
    }
  }
  LineFormat format;
  format.width_px = width_px;
  format.n_lines = height_px;
  format.channels = {Channel::kRed, Channel::kGreen, Channel::kBlue};
  if (infrared) format.channels.push_back(Channel::kInfrared);
  format.x_dpi = format.y_dpi = 4000;
  const std::size_t n_channels = format.channels.size();
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(width_px) *
                                     static_cast<std::size_t>(height_px) * n_channels);
  for (std::size_t c = 0; c < n_channels; ++c) {
    std::mt19937_64 random(seed * 4 + c);
    std::normal_distribution<double> normal(0, noise);
    const auto kernel = gaussian((c == 3 ? ir_blur_px : blur_px) * kSub);
    blur_rows(plane[c], w, h, kernel);
    auto t = transpose(plane[c], w, h);
    blur_rows(t, h, w, kernel);
    plane[c] = transpose(t, h, w);
    for (int y = 0; y < height_px; ++y) {
      for (int x = 0; x < width_px; ++x) {
        double sum = 0;
        for (int b = 0; b < kSub; ++b) {
          for (int a = 0; a < kSub; ++a) {
            sum += plane[c][static_cast<std::size_t>((y + border) * kSub + b) *
                                static_cast<std::size_t>(w) +
                            static_cast<std::size_t>((x + border) * kSub + a)];
          }
        }
        const double value = exposure * sum / (kSub * kSub) + normal(random);
        samples[(static_cast<std::size_t>(y) * n_channels + c) *
                    static_cast<std::size_t>(width_px) +
                static_cast<std::size_t>(x)] =
            static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 1.0) * 65535));
      }
    }
  }
  return {format, std::move(samples)};
}

}  // namespace reseau::test
