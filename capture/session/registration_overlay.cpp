#include "capture/session/registration_overlay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "capture/image/png_writer.h"
#include "capture/store/part_file.h"
#include "core/screen/screen_description.h"

namespace reseau {
namespace {

constexpr int kGap = 10;                                 // between windows [output px]
constexpr double kDotRadius = 0.1, kRingRadius = 0.135;  // [periods]

struct Dot {
  Vec2 middle;  // [periods]
  int color;
};

std::vector<Dot> dots_of(const ScreenDescription& screen) {
  std::vector<Dot> dots;
  for (std::size_t color = 0; color < 3; ++color)
    dots.push_back({screen.middles[color], static_cast<int>(color)});
  // Of lines, and of what lies between two sites, a period holds the like twice.
  for (const ScreenShape& shape : screen.shapes) {
    if (shape.across) dots.push_back({shape.center + Vec2{0.5, 0}, shape.color});
  }
  if (screen.shapes.size() == 2 && !screen.shapes[1].across)
    dots.push_back({{screen.middles[2].y, screen.middles[2].x}, 2});
  return dots;
}

// Linear R, G, B of a window of the scan.
struct OverlayWindow {
  int x0, y0, side_x, side_y;
  std::vector<float> rgb;
  std::array<float, 3> gain{1, 1, 1};
};

OverlayWindow read_window(const LineSource& source, const ToneCurves& tone, int x0, int y0,
                          int side_x, int side_y) {
  const LineFormat& format = source.format();
  OverlayWindow window{x0, y0, side_x, side_y, {}, {}};
  std::vector<std::uint16_t> line(format.samples_per_line());
  std::array<std::vector<float>, 3> all;
  for (int y = y0; y < y0 + side_y; ++y) {
    source.read(y, 1, line);
    for (int x = x0; x < x0 + side_x; ++x) {
      for (int c = 0; c < 3; ++c) {
        // A scan of one channel shows that.
        const auto plane = static_cast<std::size_t>(
            std::max(0, format.plane_of(std::array{Channel::kRed, Channel::kGreen,
                                                   Channel::kBlue}[static_cast<std::size_t>(c)])));
        const std::uint16_t sample =
            line[plane * static_cast<std::size_t>(format.width_px) + static_cast<std::size_t>(x)];
        const float value = tone.table(c)[sample];
        window.rgb.push_back(value);
        all[static_cast<std::size_t>(c)].push_back(value);
      }
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const auto high = all[c].begin() + static_cast<std::ptrdiff_t>(all[c].size() * 97 / 100);
    std::nth_element(all[c].begin(), high, all[c].end());
    window.gain[c] = 1 / std::max(*high, 1e-6F);
  }
  return window;
}

std::array<std::uint8_t, 3> overlay_pixel(const OverlayWindow& window, const ScreenMap& map,
                                          const std::vector<Dot>& dots, Vec2 at) {
  const Vec2 s = map.screen_from_scan(at);
  for (const Dot& dot : dots) {
    Vec2 d = s - dot.middle;
    d = {d.x - std::round(d.x), d.y - std::round(d.y)};
    if (norm(d) < kDotRadius) {
      std::array<std::uint8_t, 3> color{0, 0, 0};
      color[static_cast<std::size_t>(dot.color)] = 255;
      if (dot.color == 2) color[1] = 96;  // a pure blue is too dark to be seen
      return color;
    }
    if (norm(d) < kRingRadius) return {255, 255, 255};
  }
  const int x = std::clamp(static_cast<int>(std::lround(at.x)) - window.x0, 0, window.side_x - 1);
  const int y = std::clamp(static_cast<int>(std::lround(at.y)) - window.y0, 0, window.side_y - 1);
  const float* rgb =
      &window.rgb[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(window.side_x) +
                       static_cast<std::size_t>(x))];
  std::array<std::uint8_t, 3> out{};
  for (std::size_t c = 0; c < 3; ++c) {
    const float value = std::clamp(rgb[c] * window.gain[c], 0.0F, 1.0F);
    out[c] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::pow(static_cast<double>(value), 0.6)));
  }
  return out;
}

}  // namespace

void write_overlay(const LineSource& source, const ToneCurves& tone,
                   const Registration& registration, const std::filesystem::path& path) {
  const LineFormat& format = source.format();
  const double period = registration.lines_alone
                            ? registration.period_px[1]
                            : std::max(registration.period_px[0], registration.period_px[1]);
  const int wanted = std::clamp(static_cast<int>(std::lround(11 * period)), 48, 400);
  const bool whole = format.width_px < 3 * wanted || format.n_lines < 3 * wanted;
  const int n = whole ? 1 : 3;
  const int side_x = whole ? std::min(format.width_px, 12 * wanted) : wanted;
  const int side_y = whole ? std::min(format.n_lines, 12 * wanted) : wanted;
  const int most = whole ? 1600 : 420;
  const int scale = std::max(2, most / std::max(side_x, side_y));
  const int step_x = side_x * scale + kGap, step_y = side_y * scale + kGap;
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  PngWriter png(file, n * step_x + kGap, n * step_y + kGap, 0);
  const std::vector<Dot> dots = dots_of(describe_screen(screen_kind(registration.screen)));
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(n * step_x + kGap));
  const auto blank = [&](int rows) {
    std::ranges::fill(row, std::uint8_t{128});
    for (int i = 0; i < rows; ++i) png.row(row);
  };
  blank(kGap);
  for (int j = 0; j < n; ++j) {
    std::vector<OverlayWindow> windows;
    for (int i = 0; i < n; ++i) {
      const int x0 = (format.width_px - side_x) * (2 * i + 1) / (2 * n);
      const int y0 = (format.n_lines - side_y) * (2 * j + 1) / (2 * n);
      windows.push_back(read_window(source, tone, x0, y0, side_x, side_y));
    }
    for (int y = 0; y < side_y * scale; ++y) {
      std::ranges::fill(row, std::uint8_t{128});
      for (int i = 0; i < n; ++i) {
        const OverlayWindow& window = windows[static_cast<std::size_t>(i)];
        for (int x = 0; x < side_x * scale; ++x) {
          const Vec2 at{window.x0 + (x + 0.5) / scale - 0.5, window.y0 + (y + 0.5) / scale - 0.5};
          const auto pixel = overlay_pixel(window, registration.map, dots, at);
          std::ranges::copy(pixel,
                            row.begin() + 3 * static_cast<std::ptrdiff_t>(kGap + i * step_x + x));
        }
      }
      png.row(row);
    }
    blank(kGap);
  }
  png.finish();
  file.publish();
}

}  // namespace reseau
