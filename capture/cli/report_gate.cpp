#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "capture/cli/calibrate_gate.h"
#include "capture/cli/report_plot.h"

namespace reseau::cli {
namespace {

std::string noise_svg(const GateResult& gate) {
  double top = 0;
  for (const GateChannel& channel : gate.channels) {
    for (const GateLevel& level : channel.levels) top = std::max(top, std::sqrt(level.variance));
  }
  if (!(top > 0)) return {};
  const double step = round_step(100 * top, 6);
  const double high = step * std::ceil(100 * top / step);
  ReportPlot plot("Noise against level; lines: read and shot noise", {0, 0}, {1, high}, {0.1, step},
                  step < 0.1 ? 2 : 1, "level of full scale", "noise [% of full scale]");
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    const GateChannel& channel = gate.channels[c];
    const std::string color = channel_color(kProfileChannelNames[c]);
    for (const GateLevel& level : channel.levels) {
      if (level.clipped) continue;
      plot.page.dot(plot.area.at(level.level, 100 * std::sqrt(level.variance)), 2, color);
    }
    if (!channel.noise) continue;
    const double dark = channel.dark ? channel.dark->value : 0;
    std::vector<Vec2> line;
    for (int i = 0; i <= 50; ++i) {
      const double light = i / 50.0;
      const double variance =
          channel.noise->read + channel.noise->shot * std::max(0.0, light - dark);
      line.push_back(plot.area.at(light, std::min(high, 100 * std::sqrt(variance))));
    }
    plot.page.path(line, {color, 1, ""});
  }
  return plot.page.str();
}

std::string flat_svg(const GateResult& gate) {
  double low = 1, high = 1;
  std::size_t width = 0;
  for (const GateChannel& channel : gate.channels) {
    for (const double gain : channel.flat_gain) {
      low = std::min(low, 1 / gain);
      high = std::max(high, 1 / gain);
    }
    width = std::max(width, channel.flat_gain.size());
  }
  if (width < 2) return {};
  const double step = round_step(std::max(high - low, 1e-4), 5);
  low = step * std::floor(low / step);
  high = step * std::ceil(high / step);
  const double x_step = round_step(static_cast<double>(width), 6);
  ReportPlot plot("Flat field: light along the sensor", {0, low},
                  {x_step * std::ceil(static_cast<double>(width) / x_step), high}, {x_step, step},
                  step < 0.01 ? 4 : 2, "pixel", "light, mean 1");
  const std::size_t skip = std::max<std::size_t>(1, width / 400);
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    const std::vector<double>& gains = gate.channels[c].flat_gain;
    std::vector<Vec2> line;
    for (std::size_t i = 0; i < gains.size(); i += skip) {
      line.push_back(plot.area.at(static_cast<double>(i), 1 / gains[i]));
    }
    plot.page.path(line, {channel_color(kProfileChannelNames[c]), 0.7, ""});
  }
  return plot.page.str();
}

std::string response_svg(const GateResult& gate) {
  double most = 0, top = 0;
  for (const GateChannel& channel : gate.channels) {
    for (const GateLevel& level : channel.levels) {
      if (level.exposure_us) most = std::max(most, *level.exposure_us);
      top = std::max(top, level.level);
    }
  }
  if (!(most > 0)) return {};
  const double step = round_step(most, 6);
  ReportPlot plot("Level against exposure", {0, 0}, {step * std::ceil(most / step), 1}, {step, 0.1},
                  1, "exposure [µs]", "level of full scale");
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    for (const GateLevel& level : gate.channels[c].levels) {
      if (!level.exposure_us) continue;
      plot.page.dot(plot.area.at(*level.exposure_us, std::min(1.0, level.level)), 2,
                    channel_color(kProfileChannelNames[c]));
    }
  }
  return plot.page.str();
}

std::string estimate_html(const std::optional<Measured>& m, double scale, int digits) {
  return m ? fmt::format("{:.{}f} ± {:.{}f}", scale * m->value, digits, scale * m->sd, digits)
           : std::string("unknown");
}
std::string percent_html(const std::optional<double>& v, int digits) {
  return v ? fmt::format("{:.{}f}", 100 * *v, digits) : std::string("unknown");
}

}  // namespace

std::string gate_html(const GateResult& gate) {
  std::string out =
      "<h2>Open frame</h2>\n<p class=\"small\">Levels in % of full scale. Names as in ISO 19264-1 "
      "and the FADGI guidelines: tone response (level against exposure), noise, illumination "
      "non-uniformity (shading). No conformance is claimed.</p>\n"
      "<table><tr><th>channel</th><th>dark level [%]</th><th>noise in the dark [%]</th><th>at half "
      "scale [%]</th><th>illumination non-uniformity [%]</th><th>pixels [% rms]</th><th>lamp [% "
      "rms]</th><th>departure from a straight tone response [%]</th></tr>\n";
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    const GateChannel& channel = gate.channels[c];
    if (channel.levels.empty()) continue;
    const auto noise_at = [&](double light) -> std::optional<double> {
      if (!channel.noise) return std::nullopt;
      return std::sqrt(channel.noise->read + light * channel.noise->shot);
    };
    out += fmt::format(
        "<tr><td style=\"color:{}\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td></tr>\n",
        channel_color(kProfileChannelNames[c]), kProfileChannelNames[c],
        estimate_html(channel.dark, 100, 4), percent_html(noise_at(0), 4),
        percent_html(noise_at(0.5), 4), percent_html(channel.shading, 2),
        percent_html(channel.pixel_rms, 3), percent_html(channel.lamp_rms, 4),
        estimate_html(channel.nonlinearity, 100, 4));
  }
  out += "</table>\n<table><tr><th>light that shows in</th>";
  for (const char* name : kProfileChannelNames) out += fmt::format("<th>from {} [%]</th>", name);
  out += "<th>gains of the sensor's lines</th></tr>\n";
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    const GateChannel& channel = gate.channels[c];
    if (channel.levels.empty()) continue;
    out += fmt::format("<tr><td>{}</td>", kProfileChannelNames[c]);
    for (std::size_t k = 0; k < channel.leakage.size(); ++k) {
      out += "<td>" + (k == c ? std::string("–") : estimate_html(channel.leakage[k], 100, 4)) +
             "</td>";
    }
    out += "<td>";
    for (const Measured& gain : channel.line_gains) out += estimate_html(gain, 1, 5) + " ";
    out += "</td></tr>\n";
  }
  out += "</table>\n";
  for (const std::string& remark : gate.remarks) {
    out += "<p class=\"small\">" + xml_text(remark) + "</p>\n";
  }
  for (const std::string& svg : {noise_svg(gate), flat_svg(gate), response_svg(gate)}) {
    if (!svg.empty()) out += "<figure>" + svg + "</figure>\n";
  }
  return out;
}

}  // namespace reseau::cli
