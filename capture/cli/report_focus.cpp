#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "capture/cli/calibrate_focus.h"
#include "capture/cli/report_plot.h"

namespace reseau::cli {
namespace {

std::string through_focus_svg(const FocusResult& focus) {
  double low = 1e300, high = -1e300;
  for (const FocusOfChannel& channel : focus.channels) {
    for (const FocusPoint& p : channel.points) {
      low = std::min(low, p.position);
      high = std::max(high, p.position);
    }
  }
  if (!(high > low)) return {};
  const double step = round_step(high - low, 8);
  low = step * std::floor(low / step);
  high = step * std::ceil(high / step);
  ReportPlot plot(fmt::format("Through focus, at {:.2f} cycles/pixel", focus.f_cy_per_px), {low, 0},
                  {high, 1}, {step, 0.1}, step < 1 ? 2 : 1, "focus setting [steps]", "modulation");
  for (const FocusOfChannel& channel : focus.channels) {
    const std::string color = channel_color(channel.name);
    for (const FocusPoint& p : channel.points) {
      const auto y = [&](double v) { return std::clamp(v, 0.0, 1.0); };
      plot.page.dot(plot.area.at(p.position, y(p.modulation)), 2, color);
      plot.page.line(plot.area.at(p.position, y(p.modulation - 2 * p.sd)),
                     plot.area.at(p.position, y(p.modulation + 2 * p.sd)), {color, 0.8, ""});
    }
    if (!channel.fit.ok) continue;
    std::vector<Vec2> line;
    constexpr int kPoints = 120;
    for (int i = 0; i <= kPoints; ++i) {
      const double position = low + (high - low) * i / kPoints;
      line.push_back(plot.area.at(position, std::clamp(channel.fit.at(position), 0.0, 1.0)));
    }
    plot.page.path(line, {color, 1.1, ""});
  }
  return plot.page.str();
}

std::string steps_html(const Measured& m) { return fmt::format("{:.2f} ± {:.2f}", m.value, m.sd); }

}  // namespace

std::string focus_html(const FocusResult& focus) {
  std::string out =
      "<h2>Focus</h2>\n<table><tr><th>channel</th><th>best setting [steps]</th><th>from green "
      "[steps]</th><th>depth of field [± steps]</th><th>best modulation</th></tr>\n";
  std::string without;
  for (const FocusOfChannel& channel : focus.channels) {
    if (!channel.fit.ok) {
      without += "<p class=\"small\">" + xml_text(channel.name) + ": " + xml_text(channel.fit.why) +
                 "</p>\n";
      continue;
    }
    out += fmt::format(
        "<tr><td style=\"color:{}\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.4f} ± {:.4f}"
        "</td></tr>\n",
        channel_color(channel.name), xml_text(channel.name), steps_html(channel.fit.best),
        channel.from_green ? steps_html(*channel.from_green) : "–",
        channel.fit.half_depth ? steps_html(*channel.fit.half_depth) : "beyond the settings",
        channel.fit.peak.value, channel.fit.peak.sd);
  }
  out += "</table>\n" + without;
  out += fmt::format(
      "<p class=\"small\">Depth of field: to {:.0f} % of the best modulation at {:.2f} cycles per "
      "pixel. Dots with two standard deviations; lines: ln M as an even polynomial about best "
      "focus.</p>\n<figure>{}</figure>\n",
      100 * kDepthShare, focus.f_cy_per_px, through_focus_svg(focus));
  return out;
}

}  // namespace reseau::cli
