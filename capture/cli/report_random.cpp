#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "capture/cli/calibrate_random.h"
#include "capture/cli/report_plot.h"

namespace reseau::cli {
namespace {

constexpr double kBandSds = 1.96;

// The spread, its light as grey.
std::string spread_svg(const RandomOfChannel& c) {
  const RandomPsf& psf = c.psf;
  const double reach = psf.step_px * psf.side / 2;
  ReportPlot plot("Spread of a point, " + c.channel + " (root of the light, dark = most)",
                  {-reach, -reach}, {reach, reach}, {1, 1}, 0, "along the sensor [px]",
                  "against the motion [px]");
  const double most = *std::ranges::max_element(psf.psf);
  std::size_t at = 0;
  for (int y = 0; y < psf.side; ++y) {
    for (int x = 0; x < psf.side; ++x) {
      const double v = psf.psf[at++] / most;
      const int grey = static_cast<int>(std::lround(255 * (1 - std::sqrt(std::max(0.0, v)))));
      const double px = (x - 0.5 * (psf.side - 1)) * psf.step_px;
      const double py = (0.5 * (psf.side - 1) - y) * psf.step_px;
      const Vec2 a = plot.area.at(px - psf.step_px / 2, py + psf.step_px / 2);
      const Vec2 b = plot.area.at(px + psf.step_px / 2, py - psf.step_px / 2);
      plot.page.rectangle(a, b.x - a.x, b.y - a.y, fmt::format("#{0:02x}{0:02x}{0:02x}", grey));
    }
  }
  return plot.page.str();
}

std::string transfer_svg(const RandomOfFile& file) {
  ReportPlot plot("Modulation transfer from the random target, 95 % band; dashed: along the motion",
                  {0, 0}, {1, 1.1}, {0.1, 0.1}, 1, "cycles / pixel", "modulation");
  for (const RandomOfChannel& c : file.channels) {
    if (!c.psf.ok()) continue;
    const std::string color = channel_color(c.channel);
    std::vector<Vec2> low, high, along, across;
    for (int i = 0; i <= 50; ++i) {
      const double f = 0.02 * i;
      const RandomPsf::Point x = c.psf.mtf_of_all(f, 0), y = c.psf.mtf_of_all(0, f);
      const auto at = [&](double v) { return plot.area.at(f, std::clamp(v, 0.0, 1.1)); };
      high.push_back(at(x.value + kBandSds * x.sd));
      low.push_back(at(x.value - kBandSds * x.sd));
      along.push_back(at(x.value));
      across.push_back(at(y.value));
    }
    high.insert(high.end(), low.rbegin(), low.rend());
    plot.page.path(high, {color, 0.3, ""}, true, color + "40");
    plot.page.path(along, {color, 1.4, ""});
    plot.page.path(across, {color, 1, "4 3"});
  }
  return plot.page.str();
}

}  // namespace

std::string random_html(const std::vector<RandomOfFile>& files,
                        const std::vector<RandomAgainstEdge>& pairs) {
  std::string out;
  for (const RandomOfFile& file : files) {
    out += "<h2>Random target: " + xml_text(file.path.filename().string()) + "</h2>\n";
    out += fmt::format("<p class=\"small\">Target {}, cells of {} µm, {:.0f} dpi.</p>\n",
                       file.target.seed, file.target.cell_um, file.dpi);
    out +=
        "<table><tr><th>channel</th><th>SFR50 along the sensor</th><th>along the motion</th>"
        "<th>spread known to [%]</th><th>light beyond it [%]</th><th>noise [%]</th><th>turned by "
        "[°]</th><th>placed to "
        "[px]</th></tr>\n";
    std::string plots;
    for (const RandomOfChannel& c : file.channels) {
      const RandomPsf& psf = c.psf;
      out += fmt::format("<tr><td style=\"color:{}\">{}</td>", channel_color(c.channel),
                         xml_text(c.channel));
      if (!psf.ok()) {
        out += fmt::format("<td colspan=\"7\">{}</td></tr>\n", xml_text(sentence(psf.status)));
        continue;
      }
      const RandomPsf::Point x = psf.mtf50(0), y = psf.mtf50(std::acos(0.0));
      out += fmt::format(
          "<td>{:.4f} ± {:.4f}</td><td>{:.4f} ± {:.4f}</td><td>{:.2f}</td><td>{:.2f} ± "
          "{:.2f}</td><td>{:.2f}</td>"
          "<td>{:.2f}</td><td>{:.4f}, {:.4f}</td></tr>\n",
          x.value, x.sd, y.value, y.sd, 100 * psf.relative_sd, 100 * psf.outside,
          100 * psf.outside_sd, 100 * psf.noise, psf.turn_deg, psf.origin_sd_px.x,
          psf.origin_sd_px.y);
      plots += "<figure>" + spread_svg(c) + "</figure>\n";
    }
    out += "</table>\n";
    if (file.measured()) out += "<figure>" + transfer_svg(file) + "</figure>\n" + plots;
  }
  if (pairs.empty()) return out;
  out +=
      "<h2>Random target against edges</h2>\n<table><tr><th>channel</th><th>edge at [°]</th>"
      "<th>SFR50 from the target</th><th>from the edge</th><th>[%]</th></tr>\n";
  for (const RandomAgainstEdge& p : pairs) {
    out += fmt::format(
        "<tr><td style=\"color:{}\">{}</td><td>{:.2f}</td><td>{:.4f} ± {:.4f}</td><td>{:.4f} ± "
        "{:.4f}</td><td>{:+.2f}</td></tr>\n",
        channel_color(p.channel), xml_text(p.channel), p.angle_deg, p.random.value, p.random.sd,
        p.edge.value, p.edge.sd, 100 * (p.random.value / p.edge.value - 1));
  }
  return out + "</table>\n";
}

}  // namespace reseau::cli
