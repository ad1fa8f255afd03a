// Plots of the calibration's report.
#pragma once

#include <string>

#include "capture/color/svg.h"

namespace reseau::cli {

// A page with a title and axes.
struct ReportPlot {
  SvgPage page;
  PlotArea area;
  ReportPlot(const std::string& title, Vec2 lowest, Vec2 highest, Vec2 step, int decimals,
             const std::string& x_name, const std::string& y_name);
};

// Of a channel's lines and words.
[[nodiscard]] std::string channel_color(const std::string& channel);

// 1, 2 or 5 times a power of ten, so that about `n` steps cover `span`.
[[nodiscard]] double round_step(double span, int n);

}  // namespace reseau::cli
