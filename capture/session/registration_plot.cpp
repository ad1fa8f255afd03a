#include "capture/session/registration_plot.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "capture/color/svg.h"

namespace reseau {
namespace {

constexpr double kPage = 760, kMargin = 60, kCurveHeight = 200;

struct Arrow {
  Vec2 at, off_px;
};

// 1, 2 or 5 times a power of ten, at least `least`.
double round_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(least, 1e-12))));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least) return factor * power;
  }
  return 10 * power;
}

// Where the smooth part of the map lies against the plane that fits it best [px].
std::vector<Arrow> film_arrows(const ScreenMap& map, const LineFormat& format) {
  constexpr int kAcross = 20;
  const double step = std::max(format.width_px, format.n_lines) / static_cast<double>(kAcross);
  std::vector<Arrow> arrows;
  const Mat2 to_px = map.linear().inverse();
  Vec2 mean;
  for (double y = step / 2; y < format.n_lines; y += step) {
    for (double x = step / 2; x < format.width_px; x += step) {
      const Vec2 p{x, y};
      const Vec2 off = to_px * (map.smooth_screen_from_scan(p) - (map.linear() * p + map.offset()));
      arrows.push_back({p, off});
      mean = mean + off;
    }
  }
  for (Arrow& arrow : arrows)
    arrow.off_px = arrow.off_px - (1.0 / static_cast<double>(arrows.size())) * mean;
  return arrows;
}

void draw_film(SvgPage& page, const Registration& registration, const LineFormat& format,
               double scale) {
  const std::vector<Arrow> arrows = film_arrows(registration.map, format);
  double most = 0, square = 0;
  for (const Arrow& arrow : arrows) {
    most = std::max(most, norm(arrow.off_px));
    square += dot(arrow.off_px, arrow.off_px);
  }
  const double rms =
      std::sqrt(square / static_cast<double>(std::max<std::size_t>(arrows.size(), 1)));
  const Vec2 corner{kMargin, 70};
  page.rectangle(corner, scale * format.width_px, scale * format.n_lines, "#f4f4f0");
  const double step = std::max(format.width_px, format.n_lines) / 20.0;
  const double times = most > 1e-6 ? step / most : 1;
  for (const Arrow& arrow : arrows) {
    const Vec2 from = corner + scale * arrow.at;
    page.dot(from, 1.2, "#555555");
    if (most > 1e-6) page.line(from, from + (scale * times) * arrow.off_px, {"#b03020", 1.2, ""});
  }
  page.text({kMargin, 62},
            most > 1e-6
                ? fmt::format("Film against a plane lattice: {:.3f} px rms, {:.3f} px at most; "
                              "drawn {:.0f} times as long",
                              rms, most, times)
                : std::string("Film against a plane lattice: nothing, the map is affine"),
            13);
}

void draw_stage(SvgPage& page, const LineError& line, const LineFormat& format, double top) {
  if (line.none()) {
    page.text({kMargin, top + 20}, "Error of the stage: none was found", 13);
    return;
  }
  const bool columns = line.axis == LineError::Axis::kColumns;
  const double extent = columns ? format.width_px : format.n_lines;
  std::vector<Vec2> values;
  double most = 1e-3, square = 0;
  const int n = 600;
  for (int i = 0; i <= n; ++i) {
    values.push_back(line.at_position(extent * i / n));
    most = std::max({most, std::abs(values.back().x), std::abs(values.back().y)});
    square += dot(values.back(), values.back());
  }
  const double step = round_step(most / 2.5), range = step * std::ceil(most / step);
  const PlotArea area({kMargin, top + 30}, kPage - 2 * kMargin, kCurveHeight, {0, -range},
                      {extent, range});
  area.draw_axes(page, {round_step(extent / 8), step}, step < 0.1 ? 2 : 1,
                 columns ? "column [px]" : "line [px]", "off [px]");
  for (const bool along_x : {true, false}) {
    std::vector<Vec2> points;
    for (int i = 0; i <= n; ++i) {
      const Vec2 value = values[static_cast<std::size_t>(i)];
      points.push_back(area.at(extent * i / n, along_x ? value.x : value.y));
    }
    page.path(points, {along_x ? "#b03020" : "#2050a0", 1.5, ""});
  }
  page.text({kMargin, top + 8},
            fmt::format("Error of the stage, d({}): {:.3f} px rms; along x red, along y blue",
                        columns ? "column" : "line", std::sqrt(square / (n + 1))),
            13);
}

}  // namespace

std::string registration_plot(const Registration& registration, const LineFormat& format) {
  const double scale = std::min((kPage - 2 * kMargin) / format.width_px, 900.0 / format.n_lines);
  const double below = 70 + scale * format.n_lines + 20;
  SvgPage page(kPage, below + kCurveHeight + 90);
  page.rectangle({0, 0}, kPage, below + kCurveHeight + 90, "#ffffff");
  const std::string periods =
      registration.lines_alone
          ? fmt::format("{:.3f}", registration.period_px[1])
          : fmt::format("{:.3f} x {:.3f}", registration.period_px[0], registration.period_px[1]);
  page.text({kMargin, 30},
            fmt::format("{}, {} px, {:.2f} degrees, {:.3f} px rms left", registration.screen,
                        periods, registration.angle_deg, registration.residual_px),
            15);
  draw_film(page, registration, format, scale);
  draw_stage(page, registration.map.line_error(), format, below);
  return page.str();
}

}  // namespace reseau
