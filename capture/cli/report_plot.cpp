#include "capture/cli/report_plot.h"

#include <cmath>

namespace reseau::cli {
namespace {

constexpr double kPlotWidth = 430, kPlotHeight = 300;

}  // namespace

ReportPlot::ReportPlot(const std::string& title, Vec2 lowest, Vec2 highest, Vec2 step, int decimals,
                       const std::string& x_name, const std::string& y_name)
    : page(kPlotWidth, kPlotHeight),
      area({58, 42}, kPlotWidth - 76, kPlotHeight - 94, lowest, highest) {
  page.text({kPlotWidth / 2, 14}, title, 13, SvgPage::Anchor::kMiddle);
  area.draw_axes(page, step, decimals, x_name, y_name);
}

std::string channel_color(const std::string& channel) {
  if (channel == "red") return "#c0392b";
  if (channel == "green") return "#2a8f43";
  if (channel == "blue") return "#2f5fc4";
  if (channel == "infrared") return "#7a4a9e";
  return "#333333";
}

double round_step(double span, int n) {
  const double rough = span / n, power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) return factor * power;
  }
  return 10 * power;
}

}  // namespace reseau::cli
