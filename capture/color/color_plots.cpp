#include "capture/color/color_plots.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "capture/color/svg.h"
#include "capture/image/view_encoding.h"
#include "core/color/tables.h"

namespace reseau {
namespace {

constexpr std::array<const char*, 3> kElementNames{"red", "green", "blue"};
constexpr std::array<const char*, 3> kElementColors{"#c62828", "#2e7d32", "#1e4fbf"};
constexpr std::array<const char*, 8> kSetColors{"#000000", "#c62828", "#1e4fbf", "#2e7d32",
                                                "#ef6c00", "#6a1b9a", "#00838f", "#795548"};
// Names stand under the curves in four columns.
std::size_t name_rows(std::size_t n_names) { return (n_names + 3) / 4; }

// Curves of one name have one entry below.
std::vector<TransmittanceCurve> named_curves(const std::vector<TransmittanceCurve>& curves) {
  std::vector<TransmittanceCurve> named;
  for (const TransmittanceCurve& curve : curves) {
    const bool there = std::any_of(named.begin(), named.end(),
                                   [&](const auto& other) { return other.name == curve.name; });
    if (!there) named.push_back(curve);
  }
  return named;
}

// The angle of the first printing to the edge of the film (Hubicka et al. 2025).
constexpr double kPrintingAngle_deg = 23;

void draw_locus(SvgPage& page, const PlotArea& area) {
  const Observer& o = observer_1nm();
  std::vector<Vec2> locus;
  for (int i = 0; i < o.grid.count; ++i) {
    const double nm = o.grid.wavelength_nm(i);
    if (nm < 380 || nm > 700) continue;
    const auto k = static_cast<std::size_t>(i);
    const Chromaticity c = chromaticity_of({o.xbar[k], o.ybar[k], o.zbar[k]});
    locus.push_back(area.at(c[0], c[1]));
    const int whole = static_cast<int>(std::lround(nm));
    if (whole % 20 == 0 && whole >= 460 && whole <= 620) {
      page.dot(locus.back(), 2, "#444444");
      const bool left = whole <= 520;
      page.text(locus.back() + Vec2{left ? -6.0 : 6.0, -3}, std::to_string(whole), 9,
                left ? SvgPage::Anchor::kEnd : SvgPage::Anchor::kStart, "#444444");
    }
  }
  page.path(locus, {"#444444", 1.2, ""}, true);
}

void draw_triangle(SvgPage& page, const PlotArea& area, const DiagramTriangle& triangle,
                   const SvgPage::Stroke& stroke) {
  std::vector<Vec2> corners;
  for (int i = 0; i < 3; ++i) {
    const Chromaticity c = chromaticity_of(column(triangle.xyz, i));
    corners.push_back(area.at(c[0], c[1]));
  }
  page.path(corners, stroke, true);
  for (const Vec2& corner : corners) page.dot(corner, 2.4, stroke.color);
  // A cross for the white: several may lie on each other, and on their triangles' lines.
  const Vec2 white = area.at(triangle.white[0], triangle.white[1]);
  page.line(white - Vec2{4, 0}, white + Vec2{4, 0}, stroke);
  page.line(white - Vec2{0, 4}, white + Vec2{0, 4}, stroke);
}

void draw_diagram(SvgPage& page, Vec2 corner, const std::string& title,
                  const std::vector<DiagramTriangle>& triangles) {
  const PlotArea area(corner + Vec2{50, 50}, 400, 450, {0, 0}, {0.8, 0.9});
  page.text(corner + Vec2{50, 22}, title, 13);
  area.draw_axes(page, {0.1, 0.1}, 1, "x", "y");
  draw_locus(page, area);
  const Matrix3 srgb = xyz_from_rgb(srgb_chromaticities());
  draw_triangle(page, area, {"sRGB", srgb, srgb_chromaticities().xy[3]}, {"#888888", 0.8, "4 3"});
  double y = 0;
  const auto legend = [&](const std::string& name, const SvgPage::Stroke& stroke) {
    const Vec2 at = corner + Vec2{270, 72 + y};
    page.line(at, at + Vec2{22, 0}, stroke);
    page.text(at + Vec2{28, 4}, name, 10);
    y += 15;
  };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const SvgPage::Stroke stroke{kSetColors[i % kSetColors.size()], 1.4, ""};
    draw_triangle(page, area, triangles[i], stroke);
    legend(triangles[i].name, stroke);
  }
  legend("sRGB", {"#888888", 0.8, "4 3"});
}

// Solid between the readings, dashed where it is only continued.
void draw_curve(SvgPage& page, const PlotArea& area, const TransmittanceCurve& curve) {
  const Spectrum& spectrum = curve.transmittance;
  std::array<std::vector<Vec2>, 3> parts;  // before, between, beyond the readings
  for (int i = 0; i < spectrum.grid.count; ++i) {
    const double nm = spectrum.grid.wavelength_nm(i);
    const Vec2 at = area.at(nm, 100 * spectrum.values[static_cast<std::size_t>(i)]);
    if (nm <= curve.read_from_nm) parts[0].push_back(at);
    if (nm >= curve.read_from_nm && nm <= curve.read_to_nm) parts[1].push_back(at);
    if (nm >= curve.read_to_nm) parts[2].push_back(at);
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].size() < 2) continue;
    const bool read = i == 1;
    page.path(parts[i], {curve.color, read ? 1.6 : 0.8, read ? "" : "2 3"});
  }
}

void draw_curves(SvgPage& page, Vec2 corner, const std::string& title,
                 const std::vector<TransmittanceCurve>& curves) {
  const PlotArea area(corner + Vec2{55, 50}, 480, 450, {380, 0}, {780, 100});
  page.text(corner + Vec2{55, 22}, title, 13);
  area.draw_axes(page, {40, 10}, 0, "wavelength [nm]", "transmittance [%]");
  for (const TransmittanceCurve& curve : curves) draw_curve(page, area, curve);
  const std::vector<TransmittanceCurve> named = named_curves(curves);
  const std::size_t n_rows = name_rows(named.size());
  for (std::size_t i = 0; i < named.size(); ++i) {
    const TransmittanceCurve& curve = named[i];
    const std::size_t row = i % n_rows, name_column = i / n_rows;
    const Vec2 at = corner + Vec2{20 + 137 * static_cast<double>(name_column),
                                  548 + 14 * static_cast<double>(row)};
    page.line(at, at + Vec2{16, 0}, {curve.color, 1.6, ""});
    page.text(at + Vec2{20, 3}, curve.name, 8);
  }
}

struct ReseauLengths {
  double red_um = 0, green_um = 0, period_across_um = 0, period_along_um = 0;
};

ReseauLengths reseau_lengths() {
  const auto rows = dufaycolor_geometry();
  const GeometryRow &red = rows[0], &green = rows[1], &blue = rows[2];
  return {red.across_lines_um, green.along_lines_um, red.across_lines_um + green.across_lines_um,
          green.along_lines_um + blue.along_lines_um};
}

std::string css(const Matrix3& element_srgb, int element) {
  const Vector3 rgb = column(element_srgb, element);
  const auto byte = [](double v) {
    return std::lround(255 * srgb_encode(std::clamp(v, 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(rgb[0]), byte(rgb[1]), byte(rgb[2]));
}

// 0 red, 1 green, 2 blue at a place [um] across and along the red lines.
int element_at(const ReseauLengths& l, double across_um, double along_um) {
  const double u = across_um - std::floor(across_um / l.period_across_um) * l.period_across_um;
  if (u < l.red_um) return 0;
  const double v = along_um - std::floor(along_um / l.period_along_um) * l.period_along_um;
  return v < l.green_um ? 1 : 2;
}

}  // namespace

std::string chromaticity_svg(const std::string& title,
                             const std::vector<DiagramTriangle>& triangles) {
  SvgPage page(490, 560);
  draw_diagram(page, {0, 0}, title, triangles);
  return page.str();
}

std::string transmittance_svg(const std::string& title,
                              const std::vector<TransmittanceCurve>& curves) {
  SvgPage page(570, 556 + 14 * static_cast<double>(name_rows(named_curves(curves).size())));
  draw_curves(page, {0, 0}, title, curves);
  return page.str();
}

std::vector<TransmittanceCurve> element_curves(const PrimarySet& set, const DyeState& dyes) {
  std::vector<TransmittanceCurve> curves;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<ChartPoint>& read = set.charts->points[i];
    curves.push_back({kElementNames[i], kElementColors[i],
                      element_transmittance(set, i, {380, 1, 401}, dyes),
                      read.front().wavelength_nm, read.back().wavelength_nm});
  }
  return curves;
}

std::string primary_set_svg(const ColorRecipe& recipe) {
  const std::string name = recipe.primaries.name;
  const Viewing& viewing = recipe.viewing;
  const std::vector<DiagramTriangle> triangles{
      {name, element_xyz(recipe.primaries, viewing),
       chromaticity_of(white_of(viewing.light, viewing.step))}};
  const std::string title = name + " under " + viewing.light.name;
  if (!recipe.primaries.charts) return chromaticity_svg(title, triangles);
  SvgPage page(1060, 556 + 14 * static_cast<double>(name_rows(3)));
  draw_diagram(page, {0, 0}, title, triangles);
  draw_curves(page, {490, 0}, name, element_curves(recipe.primaries, viewing.dyes));
  return page.str();
}

Matrix3 element_srgb(const ColorRecipe& recipe) {
  ColorRecipe srgb = recipe;
  srgb.space = OutputSpace::kSrgbLinear;
  // Of the full elements: what the balance makes of them, without their areas.
  const Matrix3 weighted = make_color_model(srgb).output_from_process;
  const Vector3& a = recipe.areas.share;
  const Matrix3 elements = scale_columns(weighted, {1 / a[0], 1 / a[1], 1 / a[2]});
  double brightest = 0;
  for (int i = 0; i < 3; ++i) brightest = std::max(brightest, srgb_luminance(column(elements, i)));
  // The lightest element, usually green, is shown as light as sRGB shows its green.
  const double exposure = srgb_luminance({0, 1, 0}) / brightest;
  std::array<Vector3, 3> shown{};
  for (int i = 0; i < 3; ++i) {
    Vector3 rgb = column(elements, i);
    for (double& v : rgb) v *= exposure;
    shown[static_cast<std::size_t>(i)] = compress_into_gamut(rgb);
  }
  return from_columns(shown[0], shown[1], shown[2]);
}

std::string reseau_svg(const std::string& title, const Matrix3& element_srgb, int periods) {
  const ReseauLengths l = reseau_lengths();
  constexpr double kScale = 1.6;  // page units per um
  const double side = periods * l.period_across_um * kScale;
  SvgPage page(side, side + 30);
  page.text({8, 20}, title, 13);
  const Vec2 middle{side / 2, 30 + side / 2};
  page.begin_turned(kPrintingAngle_deg, middle);
  const int reach = static_cast<int>(std::ceil(0.75 * periods)) + 1;
  for (int i = -reach; i < reach; ++i) {
    const double x = middle.x + i * l.period_across_um * kScale;
    page.rectangle({x, middle.y - side}, l.red_um * kScale, 2 * side, css(element_srgb, 0));
    for (int j = -reach; j < reach; ++j) {
      const double y = middle.y + j * l.period_along_um * kScale;
      const double square = (l.period_across_um - l.red_um) * kScale;
      page.rectangle({x + l.red_um * kScale, y}, square, l.green_um * kScale, css(element_srgb, 1));
      page.rectangle({x + l.red_um * kScale, y + l.green_um * kScale}, square,
                     (l.period_along_um - l.green_um) * kScale, css(element_srgb, 2));
    }
  }
  page.end_group();
  page.rectangle({0, 0}, side, 30, "#ffffff");
  page.text({8, 20}, title, 13);
  return page.str();
}

std::vector<unsigned char> reseau_pixels(const Matrix3& element_srgb, int periods, int side_px) {
  const ReseauLengths l = reseau_lengths();
  constexpr int kPoints = 4;
  const double um_per_px = periods * l.period_across_um / side_px;
  const double turn = kPrintingAngle_deg * std::numbers::pi / 180;
  const double c = std::cos(turn), s = std::sin(turn);
  std::vector<unsigned char> pixels;
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      Vector3 count{};
      for (int p = 0; p < kPoints * kPoints; ++p) {
        const int i = p % kPoints, j = p / kPoints;
        const double px = (x + (i + 0.5) / kPoints - side_px / 2.0) * um_per_px;
        const double py = (y + (j + 0.5) / kPoints - side_px / 2.0) * um_per_px;
        count[static_cast<std::size_t>(element_at(l, c * px + s * py, -s * px + c * py))] +=
            1.0 / (kPoints * kPoints);
      }
      for (const double v : multiply(element_srgb, count)) {
        pixels.push_back(
            static_cast<unsigned char>(std::lround(255 * srgb_encode(std::clamp(v, 0.0, 1.0)))));
      }
    }
  }
  return pixels;
}

}  // namespace reseau
