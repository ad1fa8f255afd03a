#include "capture/color/svg.h"

#include <cmath>

#include <fmt/format.h>

namespace reseau {
namespace {

std::string stroke_attributes(const SvgPage::Stroke& stroke) {
  std::string text = fmt::format(R"( stroke="{}" stroke-width="{}")", stroke.color, stroke.width);
  if (!stroke.dashes.empty()) text += fmt::format(R"( stroke-dasharray="{}")", stroke.dashes);
  return text;
}

}  // namespace

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) out += c;
        break;
    }
  }
  return out;
}

SvgPage::SvgPage(double width, double height) : width_(width), height_(height) {
  rectangle({0, 0}, width, height, "#ffffff");
}

void SvgPage::line(Vec2 from, Vec2 to, const Stroke& stroke) {
  body_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\"{}/>\n",
                       from.x, from.y, to.x, to.y, stroke_attributes(stroke));
}

void SvgPage::path(std::span<const Vec2> points, const Stroke& stroke, bool closed,
                   const std::string& fill) {
  std::string d;
  for (const Vec2& p : points)
    d += fmt::format("{}{:.2f} {:.2f}", d.empty() ? "M" : " L", p.x, p.y);
  if (closed) d += " Z";
  body_ += fmt::format("<path d=\"{}\" fill=\"{}\"{}/>\n", d, fill, stroke_attributes(stroke));
}

void SvgPage::rectangle(Vec2 corner, double width, double height, const std::string& fill) {
  body_ += fmt::format(
      "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"/>\n",
      corner.x, corner.y, width, height, fill);
}

void SvgPage::dot(Vec2 at, double radius, const std::string& fill) {
  body_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" fill=\"{}\"/>\n", at.x,
                       at.y, radius, fill);
}

void SvgPage::text(Vec2 at, const std::string& words, double size, Anchor anchor,
                   const std::string& color) {
  const char* const side = anchor == Anchor::kStart    ? "start"
                           : anchor == Anchor::kMiddle ? "middle"
                                                       : "end";
  body_ += fmt::format(
      "<text x=\"{:.2f}\" y=\"{:.2f}\" font-family=\"sans-serif\" font-size=\"{}\" "
      "text-anchor=\"{}\" fill=\"{}\">{}</text>\n",
      at.x, at.y, size, side, color, xml_text(words));
}

void SvgPage::begin_turned(double degrees, Vec2 about) {
  body_ +=
      fmt::format("<g transform=\"rotate({:.3f} {:.2f} {:.2f})\">\n", degrees, about.x, about.y);
}

void SvgPage::end_group() { body_ += "</g>\n"; }

std::string SvgPage::str() const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
             "viewBox=\"0 0 {0} {1}\">\n",
             width_, height_) +
         body_ + "</svg>\n";
}

void PlotArea::draw_axes(SvgPage& page, Vec2 step, int decimals, const std::string& x_name,
                         const std::string& y_name) const {
  const SvgPage::Stroke grid{"#dddddd", 0.6, ""}, frame{"#444444", 1, ""};
  const auto number = [decimals](double v) { return fmt::format("{:.{}f}", v, decimals); };
  const int nx = static_cast<int>(std::lround((highest_.x - lowest_.x) / step.x));
  const int ny = static_cast<int>(std::lround((highest_.y - lowest_.y) / step.y));
  for (int i = 0; i <= nx; ++i) {
    const double x = lowest_.x + i * step.x;
    page.line(at(x, lowest_.y), at(x, highest_.y), grid);
    page.text(at(x, lowest_.y) + Vec2{0, 14}, number(x), 10, SvgPage::Anchor::kMiddle);
  }
  for (int i = 0; i <= ny; ++i) {
    const double y = lowest_.y + i * step.y;
    page.line(at(lowest_.x, y), at(highest_.x, y), grid);
    page.text(at(lowest_.x, y) + Vec2{-5, 3.5}, number(y), 10, SvgPage::Anchor::kEnd);
  }
  const Vec2 corners[] = {at(lowest_.x, lowest_.y), at(highest_.x, lowest_.y),
                          at(highest_.x, highest_.y), at(lowest_.x, highest_.y)};
  page.path(corners, frame, true);
  page.text(at((lowest_.x + highest_.x) / 2, lowest_.y) + Vec2{0, 30}, x_name, 11,
            SvgPage::Anchor::kMiddle);
  page.text(at(lowest_.x, highest_.y) + Vec2{0, -7}, y_name, 11);
}

}  // namespace reseau
