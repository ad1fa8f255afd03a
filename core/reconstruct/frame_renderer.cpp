#include "core/reconstruct/frame_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/float4.h"
#include "core/reconstruct/cubic_weights.h"

namespace reseau {
namespace {

// Scan coordinates of the samples of a rectangle of the picture, bilinear between nodes: a bend of
// 6 px over 700 px errs by 0.001 px between nodes that lie 8 px apart.
class SampleGrid {
 public:
  SampleGrid(const PictureFrame& frame, const ScreenMap& map, const PixelBounds& rect)
      : rect_(rect), columns_((rect.width() + kStep) / kStep + 1) {
    const int rows = (rect.height() + kStep) / kStep + 1;
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns_; ++i)
        nodes_.push_back(
            frame.scan_from_picture(map, {rect.x0 + i * kStep - 0.5, rect.y0 + j * kStep - 0.5}));
    }
  }
  // x, y: pixels and parts of pixels from the rectangle's outer corner.
  [[nodiscard]] Vec2 at(double x, double y) const {
    const auto i = static_cast<int>(x / kStep), j = static_cast<int>(y / kStep);
    const Vec2* a = &nodes_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                            static_cast<std::size_t>(i)];
    const Vec2* b = a + columns_;
    const double fx = x / kStep - i, fy = y / kStep - j;
    const Vec2 top = a[0] + fx * (a[1] - a[0]), bottom = b[0] + fx * (b[1] - b[0]);
    return top + fy * (bottom - top);
  }

 private:
  static constexpr int kStep = 8;
  PixelBounds rect_;
  int columns_;
  std::vector<Vec2> nodes_;
};

// Of what lies at most a pixel before the first.
int whole_below(double position) { return static_cast<int>(position + 1) - 1; }

// Of a rectangle of the scan every so many pixels.
struct Window {
  PixelBounds rect;
  int step_px;
  std::vector<float> rgb;

  [[nodiscard]] int columns() const { return (rect.width() + step_px - 1) / step_px; }
  [[nodiscard]] int rows() const { return (rect.height() + step_px - 1) / step_px; }

  // Adds the picture at p.
  void add(Vec2 p, Float4& sum) const {
    const double x_step = (p.x - rect.x0) / step_px, y_step = (p.y - rect.y0) / step_px;
    const int x0 = whole_below(x_step), y0 = whole_below(y_step);
    const auto wx = cubic_weights(static_cast<float>(x_step - x0)),
               wy = cubic_weights(static_cast<float>(y_step - y0));
    const int n_columns = columns(), n_rows = rows();
    const bool inside = x0 >= 1 && x0 + 2 < n_columns;
    for (int b = 0; b < 4; ++b) {
      const int y = std::clamp(y0 + b - 1, 0, n_rows - 1);
      const float* row = rgb.data() + static_cast<std::ptrdiff_t>(y) * n_columns * 3;
      Float4 across{};
      for (int a = 0; a < 4; ++a) {
        const int x = inside ? x0 + a - 1 : std::clamp(x0 + a - 1, 0, n_columns - 1);
        // The fourth is the next pixel's red, or what the buffer ends with.
        across += wx[static_cast<std::size_t>(a)] * load4(row + static_cast<std::ptrdiff_t>(x) * 3);
      }
      sum += wy[static_cast<std::size_t>(b)] * across;
    }
  }
};

// Weights of neighbouring samples of a window that make one row or column of the picture.
struct Taps {
  int first = 0;
  std::vector<float> weights;
};

// Of n rows or columns, each the mean of n_parts places. `place`: in the scan, of a position in the
// picture; places beyond the scan count as 0.
template <typename Place>
std::vector<Taps> taps_along(int n, int n_parts, int n_scan_px, int first_px, int step_px,
                             int n_samples, const Place& place) {
  std::vector<Taps> all(static_cast<std::size_t>(n));
  const float share = 1.0F / static_cast<float>(n_parts);
  for (int i = 0; i < n; ++i) {
    std::vector<float> weights(static_cast<std::size_t>(n_samples));
    int first = n_samples, last = -1;
    for (int part = 0; part < n_parts; ++part) {
      const double p = place(i + (part + 0.5) / n_parts - 0.5);
      if (!(p >= -0.5 && p <= n_scan_px - 0.5)) continue;
      const double at = (p - first_px) / step_px;
      const int whole = whole_below(at);
      const auto w = cubic_weights(static_cast<float>(at - whole));
      for (int k = 0; k < 4; ++k) {
        const int tap = std::clamp(whole + k - 1, 0, n_samples - 1);
        weights[static_cast<std::size_t>(tap)] += share * w[static_cast<std::size_t>(k)];
        first = std::min(first, tap);
        last = std::max(last, tap);
      }
    }
    if (last < first) continue;
    all[static_cast<std::size_t>(i)] = {first,
                                        {weights.begin() + first, weights.begin() + last + 1}};
  }
  return all;
}

// Across first, then down.
void resample(const Window& window, const std::vector<Taps>& columns, const std::vector<Taps>& rows,
              float* out, std::ptrdiff_t row_stride) {
  const std::size_t width = columns.size();
  std::vector<Float4> across(width * static_cast<std::size_t>(window.rows()));
  for (std::size_t y = 0; y < static_cast<std::size_t>(window.rows()); ++y) {
    const float* row = window.rgb.data() + y * static_cast<std::size_t>(window.columns()) * 3;
    for (std::size_t x = 0; x < width; ++x) {
      const float* from = row + static_cast<std::ptrdiff_t>(columns[x].first) * 3;
      Float4 sum{};
      for (const float weight : columns[x].weights) {
        sum += weight * load4(from);
        from += 3;
      }
      across[y * width + x] = sum;
    }
  }
  std::vector<Float4> line(width);
  for (const Taps& row : rows) {
    std::ranges::fill(line, Float4{});
    const Float4* from = across.data() + static_cast<std::size_t>(row.first) * width;
    for (const float weight : row.weights) {
      for (std::size_t x = 0; x < width; ++x) line[x] += weight * from[x];
      from += width;
    }
    for (std::size_t x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) out[3 * x + static_cast<std::size_t>(c)] = line[x][c];
    }
    out += row_stride;
  }
}

}  // namespace

// Two samples for each pixel of the picture, and one for each third of a period or more.
int FrameRenderer::step_for(const PictureFrame& frame, const ScreenMap& map) {
  const Mat2 m = map.linear().inverse();
  const double period_px = std::min(std::hypot(m.a, m.c), std::hypot(m.b, m.d));
  return std::max(1, static_cast<int>(std::min(0.5 / frame.scale(), period_px / 3) + 1e-9));
}

PixelBounds FrameRenderer::scan_rect(const PixelBounds& picture) const {
  const PixelBounds rect = frame_.scan_rect(map_, picture);
  return {std::clamp(rect.x0, 0, scan_width_px_), std::clamp(rect.y0, 0, scan_height_px_),
          std::clamp(rect.x1, 0, scan_width_px_), std::clamp(rect.y1, 0, scan_height_px_)};
}

FrameRenderer::Work FrameRenderer::render(const SilverRows& silver, const PixelBounds& rect,
                                          float* out, std::ptrdiff_t row_stride) const {
  Work work;
  Window window{scan_rect(rect), step_px_, {}};
  // On the same pixels whatever the tile.
  window.rect.x0 -= window.rect.x0 % step_px_;
  window.rect.y0 -= window.rect.y0 % step_px_;
  const bool empty = window.rect.width() < 1 || window.rect.height() < 1;
  if (!empty) {
    const auto stride = static_cast<std::ptrdiff_t>(window.columns()) * 3;
    window.rgb.resize(static_cast<std::size_t>(stride * window.rows()) + 1);
    work.pixels = static_cast<std::size_t>(window.rect.width()) *
                  static_cast<std::size_t>(window.rect.height());
    work.blank_pixels = renderer_.render(silver, window.rect, window.rgb.data(), stride, step_px_);
  }
  // The picture has no detail finer than a pixel of the scan.
  const int n = std::max(1, static_cast<int>(std::ceil(1 / (frame_.scale() * step_px_) - 1e-9)));
  if (frame_.is_straight() && !empty) {
    const auto x_of = [&](double x) { return frame_.scan_from_picture(map_, {rect.x0 + x, 0}).x; };
    const auto y_of = [&](double y) { return frame_.scan_from_picture(map_, {0, rect.y0 + y}).y; };
    resample(window,
             taps_along(rect.width(), n, scan_width_px_, window.rect.x0, step_px_, window.columns(),
                        x_of),
             taps_along(rect.height(), n, scan_height_px_, window.rect.y0, step_px_, window.rows(),
                        y_of),
             out, row_stride);
    return work;
  }
  const SampleGrid grid(frame_, map_, rect);
  const float share = 1.0F / static_cast<float>(n * n);
  for (int y = 0; y < rect.height(); ++y) {
    float* to = out + y * row_stride;
    for (int x = 0; x < rect.width(); ++x, to += 3) {
      Float4 sum{};
      for (int k = 0; k < n * n && !empty; ++k) {
        const int part_x = k % n, part_y = k / n;
        const Vec2 p = grid.at(x + (part_x + 0.5) / n, y + (part_y + 0.5) / n);
        const bool inside = p.x >= -0.5 && p.y >= -0.5 && p.x <= scan_width_px_ - 0.5 &&
                            p.y <= scan_height_px_ - 0.5;
        if (inside) window.add(p, sum);
      }
      for (int c = 0; c < 3; ++c) to[c] = share * sum[c];
    }
  }
  return work;
}

}  // namespace reseau
