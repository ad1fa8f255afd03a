#include "capture/compare/error_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "capture/image/png_writer.h"
#include "capture/store/part_file.h"
#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::compare {
namespace {

using Color = std::array<std::uint8_t, 3>;

// Dark blue over green to light yellow: even steps of lightness, also in print and without colour
// vision.
Color color_of(double share) {
  constexpr std::array<std::array<double, 3>, 6> kStops{{{20, 16, 60},
                                                         {45, 62, 120},
                                                         {30, 118, 128},
                                                         {70, 168, 100},
                                                         {180, 205, 80},
                                                         {255, 245, 190}}};
  if (!std::isfinite(share)) return {128, 128, 128};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double t = at - static_cast<double>(low);
  Color color{};
  for (std::size_t k = 0; k < 3; ++k) {
    color[k] = static_cast<std::uint8_t>(
        std::lround(kStops[low][k] + t * (kStops[low + 1][k] - kStops[low][k])));
  }
  return color;
}

// 1, 2 or 5 times a power of ten, at most `value`.
double round_length(double value) {
  const double ten = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {5.0, 2.0}) {
    if (step * ten <= value) return step * ten;
  }
  return ten;
}

double full_scale_of(const ErrorRaster& raster, double asked) {
  if (asked > 0) return asked;
  std::vector<float> values;
  for (const float v : raster.mean_delta_e) {
    if (std::isfinite(v)) values.push_back(v);
  }
  if (values.empty()) return 1;
  const auto rank = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  const double v = double{values[static_cast<std::size_t>(rank)]};
  // A scale of rounding errors would show structure where there is none.
  return std::max(v, 0.01);
}

// Squares of the raster put together until none of the sides has more than `most`.
ErrorRaster coarser(const ErrorRaster& raster, int most) {
  const int factor = (std::max(raster.width, raster.height) + most - 1) / most;
  if (factor <= 1) return raster;
  ErrorRaster result;
  result.cell_px = raster.cell_px * factor;
  result.width = (raster.width + factor - 1) / factor;
  result.height = (raster.height + factor - 1) / factor;
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      double sum = 0;
      int n = 0;
      for (int j = y * factor; j < std::min(raster.height, (y + 1) * factor); ++j) {
        for (int i = x * factor; i < std::min(raster.width, (x + 1) * factor); ++i) {
          const float v = raster.at(i, j);
          if (!std::isfinite(v)) continue;
          sum += double{v};
          ++n;
        }
      }
      result.mean_delta_e.push_back(n > 0 ? static_cast<float>(sum / n) : NAN);
    }
  }
  return result;
}

std::string hex(const Color& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]); }

// Runs of one colour as one rectangle.
void add_squares(std::string& svg, const ErrorRaster& raster, double full, double px, double left,
                 double top) {
  const double side = raster.cell_px * px;
  for (int y = 0; y < raster.height; ++y) {
    for (int x = 0; x < raster.width;) {
      const auto at = [&](int i) { return hex(color_of(double{raster.at(i, y)} / full)); };
      const std::string color = at(x);
      int end = x + 1;
      while (end < raster.width && at(end) == color) ++end;
      svg += fmt::format(
          "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n",
          left + x * side, top + y * side, (end - x) * side + 0.05, side + 0.05, color);
      x = end;
    }
  }
}

void add_arrows(std::string& svg, const Comparison& c, double px, double left, double top) {
  const MapError& r = *c.registration;
  double longest = 0;
  for (const FieldCell& cell : r.field)
    longest = std::max(longest, std::hypot(cell.dx_px, cell.dy_px));
  if (!(longest > 0)) return;
  const double room = 0.8 * px * c.area.width_px / std::max(1, r.field_columns);
  const double magnify = room / longest;
  for (const FieldCell& cell : r.field) {
    if (cell.n == 0) continue;
    const double x = left + (cell.x_px + 0.5) * px, y = top + (cell.y_px + 0.5) * px;
    svg += fmt::format(
        "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"1.5\" fill=\"#ffffff\"/><line x1=\"{:.2f}\" "
        "y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" stroke=\"#ffffff\"/>\n",
        x, y, x, y, x + magnify * cell.dx_px, y + magnify * cell.dy_px);
  }
  svg += fmt::format(
      "<text x=\"{:.0f}\" y=\"{:.0f}\">arrows: registration error, longest {:.3f} px</text>\n",
      left, top - 8, longest);
}

std::string svg_of(const Comparison& c, double asked) {
  constexpr double kLeft = 20, kTop = 46, kPlot = 720;
  const ErrorRaster raster = coarser(c.raster, 120);
  const double full = full_scale_of(c.raster, asked);
  const double px = kPlot / std::max(c.area.width_px, c.area.height_px);
  const double width = px * c.area.width_px, height = px * c.area.height_px;
  const double page_w = std::max(width, 420.0) + 2 * kLeft, page_h = kTop + height + 84;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n<title>Colour difference, "
      "CIEDE2000</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      page_w, page_h);
  svg += fmt::format(
      "<text x=\"{:.0f}\" y=\"18\" font-size=\"14\">ΔE2000: mean {:.3f}, 95 % {:.3f}, max {:.3f} "
      "(worst 1 % left out: mean {:.3f})</text>\n",
      kLeft, c.color->all.mean, c.color->all.p95, c.color->all.max,
      c.color->without_worst_percent.mean);
  svg += fmt::format(
      "<clipPath id=\"area\"><rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" "
      "height=\"{:.2f}\"/></clipPath>\n<g clip-path=\"url(#area)\" "
      "shape-rendering=\"crispEdges\">\n",
      kLeft, kTop, width, height);
  add_squares(svg, raster, full, px, kLeft, kTop);
  svg += "</g>\n";
  if (c.registration) add_arrows(svg, c, px, kLeft, kTop);
  const double bar_y = kTop + height + 14;
  constexpr int kSteps = 60;
  constexpr double kBar = 240;
  for (int i = 0; i < kSteps; ++i) {
    svg += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"14\" fill=\"{}\"/>\n",
        kLeft + kBar * i / kSteps, bar_y, kBar / kSteps + 0.1, hex(color_of((i + 0.5) / kSteps)));
  }
  for (int i = 0; i <= 4; ++i) {
    svg += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{:.3g}</text>\n",
                       kLeft + kBar * i / 4, bar_y + 28, full * i / 4);
  }
  svg += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\">ΔE2000, mean of squares of {} px</text>\n",
                     kLeft, bar_y + 46, raster.cell_px);
  const double length = round_length(std::max(1.0, c.area.width_px / 4.0));
  const double bar_x = kLeft + kBar + 40;
  svg += fmt::format(
      "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"4\"/>\n<text "
      "x=\"{:.2f}\" y=\"{:.2f}\">{:g} px</text>\n</svg>\n",
      bar_x, bar_y + 5, length * px, bar_x, bar_y + 28, length);
  return svg;
}

// Digits and a few letters, five columns of seven bits from the top, for scales in pictures.
struct Glyph {
  char letter;
  std::array<std::uint8_t, 5> columns;
};
constexpr std::array<Glyph, 17> kGlyphs{{{'0', {0x3E, 0x51, 0x49, 0x45, 0x3E}},
                                         {'1', {0x00, 0x42, 0x7F, 0x40, 0x00}},
                                         {'2', {0x42, 0x61, 0x51, 0x49, 0x46}},
                                         {'3', {0x22, 0x41, 0x49, 0x49, 0x36}},
                                         {'4', {0x18, 0x14, 0x12, 0x7F, 0x10}},
                                         {'5', {0x27, 0x45, 0x45, 0x45, 0x39}},
                                         {'6', {0x3C, 0x4A, 0x49, 0x49, 0x30}},
                                         {'7', {0x01, 0x71, 0x09, 0x05, 0x03}},
                                         {'8', {0x36, 0x49, 0x49, 0x49, 0x36}},
                                         {'9', {0x06, 0x49, 0x49, 0x29, 0x1E}},
                                         {'.', {0x00, 0x60, 0x60, 0x00, 0x00}},
                                         {'p', {0x7C, 0x14, 0x14, 0x14, 0x08}},
                                         {'x', {0x44, 0x28, 0x10, 0x28, 0x44}},
                                         {'d', {0x38, 0x44, 0x44, 0x44, 0x7F}},
                                         {'E', {0x7F, 0x49, 0x49, 0x49, 0x41}},
                                         {'-', {0x08, 0x08, 0x08, 0x08, 0x08}},
                                         {'e', {0x38, 0x54, 0x54, 0x54, 0x18}}}};

class Canvas {
 public:
  Canvas(int width, int height)
      : width_(width),
        height_(height),
        rgb_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255) {}
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  void fill(int x, int y, int width, int height, const Color& color) {
    for (int j = std::max(0, y); j < std::min(height_, y + height); ++j) {
      for (int i = std::max(0, x); i < std::min(width_, x + width); ++i) {
        std::copy(color.begin(), color.end(),
                  rgb_.begin() + 3 * (static_cast<std::ptrdiff_t>(j) * width_ + i));
      }
    }
  }
  void text(int x, int y, std::string_view words) {
    constexpr Color kBlack{0, 0, 0};
    for (const char letter : words) {
      const auto found = std::find_if(kGlyphs.begin(), kGlyphs.end(),
                                      [letter](const Glyph& g) { return g.letter == letter; });
      if (found != kGlyphs.end()) {
        for (int i = 0; i < 5; ++i) {
          for (int j = 0; j < 7; ++j) {
            if ((found->columns[static_cast<std::size_t>(i)] >> j & 1) != 0) {
              fill(x + 2 * i, y + 2 * j, 2, 2, kBlack);
            }
          }
        }
      }
      x += 12;
    }
  }
  [[nodiscard]] std::span<const std::uint8_t> row(int y) const {
    const auto n = 3 * static_cast<std::size_t>(width_);
    return std::span(rgb_).subspan(n * static_cast<std::size_t>(y), n);
  }

 private:
  int width_, height_;
  std::vector<std::uint8_t> rgb_;
};

Canvas canvas_of(const Comparison& c, double asked) {
  constexpr int kLeastWidth = 480, kFoot = 64, kBar = 200;
  const ErrorRaster& raster = c.raster;
  const double full = full_scale_of(raster, asked);
  const int zoom = std::max(1, kLeastWidth / std::max(raster.width, raster.height));
  Canvas canvas(std::max(kLeastWidth, raster.width * zoom), raster.height * zoom + kFoot);
  for (int y = 0; y < raster.height; ++y) {
    for (int x = 0; x < raster.width; ++x) {
      canvas.fill(x * zoom, y * zoom, zoom, zoom, color_of(double{raster.at(x, y)} / full));
    }
  }
  const int top = raster.height * zoom + 8;
  for (int i = 0; i < kBar; ++i) canvas.fill(8 + i, top, 1, 16, color_of((i + 0.5) / kBar));
  canvas.text(8, top + 26, "0");
  canvas.text(8 + kBar - 24, top + 26, fmt::format("{:.3g} dE", full));
  const double length = round_length(std::max(1.0, c.area.width_px / 4.0));
  const int drawn = static_cast<int>(std::lround(length * zoom / raster.cell_px));
  canvas.fill(kBar + 100, top + 6, std::max(1, drawn), 4, {0, 0, 0});
  canvas.text(kBar + 100, top + 26, fmt::format("{:g} px", length));
  return canvas;
}

bool ends_in(const std::filesystem::path& path, std::string_view ending) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char ch) { return static_cast<char>(std::tolower(ch)); });
  return extension == ending;
}

}  // namespace

void check_error_map_name(const std::filesystem::path& path) {
  if (!ends_in(path, ".svg") && !ends_in(path, ".png")) {
    throw InputError(fmt::format("The error map '{}' must end in .svg or .png.", path.string()));
  }
}

void write_error_map(const Comparison& comparison, double full_scale,
                     const std::filesystem::path& path) {
  CHECK(comparison.color.has_value());
  check_error_map_name(path);
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  if (ends_in(path, ".svg")) {
    const std::string svg = svg_of(comparison, full_scale);
    file.write_at(0, std::as_bytes(std::span(svg.data(), svg.size())));
  } else {
    const Canvas canvas = canvas_of(comparison, full_scale);
    PngWriter png(file, canvas.width(), canvas.height(), 0);
    for (int y = 0; y < canvas.height(); ++y) png.row(canvas.row(y));
    png.finish();
  }
  file.publish();
}

}  // namespace reseau::compare
