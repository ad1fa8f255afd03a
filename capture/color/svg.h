// Drawings as SVG text. Same input, same text. Pure.
#pragma once

#include <span>
#include <string>

#include "core/geometry/vec2.h"

namespace reseau {

// Escapes &, <, > and quotes, and drops what XML cannot hold.
[[nodiscard]] std::string xml_text(const std::string& text);

class SvgPage {
 public:
  SvgPage(double width, double height);

  struct Stroke {
    std::string color = "#000000";
    double width = 1;
    std::string dashes;  // "4 3"; empty = solid
  };
  void line(Vec2 from, Vec2 to, const Stroke& stroke);
  void path(std::span<const Vec2> points, const Stroke& stroke, bool closed = false,
            const std::string& fill = "none");
  void rectangle(Vec2 corner, double width, double height, const std::string& fill);
  void dot(Vec2 at, double radius, const std::string& fill);
  enum class Anchor { kStart, kMiddle, kEnd };
  void text(Vec2 at, const std::string& words, double size, Anchor anchor = Anchor::kStart,
            const std::string& color = "#000000");
  // Everything until end_group() is turned by degrees about a point, and cut to nothing else.
  void begin_turned(double degrees, Vec2 about);
  void end_group();

  // The whole document.
  [[nodiscard]] std::string str() const;

 private:
  double width_, height_;
  std::string body_;
};

// A pair of axes: data to page.
class PlotArea {
 public:
  // `lowest`, `highest`: data at the lower left and the upper right corner.
  PlotArea(Vec2 corner, double width, double height, Vec2 lowest, Vec2 highest)
      : corner_(corner), width_(width), height_(height), lowest_(lowest), highest_(highest) {}
  [[nodiscard]] Vec2 at(double x, double y) const {
    return {corner_.x + (x - lowest_.x) / (highest_.x - lowest_.x) * width_,
            corner_.y + height_ - (y - lowest_.y) / (highest_.y - lowest_.y) * height_};
  }
  // Frame, grid and numbers at every step.
  void draw_axes(SvgPage& page, Vec2 step, int decimals, const std::string& x_name,
                 const std::string& y_name) const;

 private:
  Vec2 corner_;
  double width_, height_;
  Vec2 lowest_, highest_;
};

}  // namespace reseau
