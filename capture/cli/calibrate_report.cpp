#include "capture/cli/calibrate_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "capture/cli/calibrate_field.h"
#include "capture/cli/calibrate_psf.h"
#include "capture/cli/report_plot.h"
#include "capture/color/svg.h"

namespace reseau::cli {
namespace {

constexpr double kHalfSampling = 0.5;  // cycles per pixel
constexpr double kBand = 1.96;         // standard deviations on each side
constexpr const char* kStyle =
    "body{font:15px/1.45 sans-serif;max-width:960px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:.6em 0}"
    "td,th{border-bottom:1px solid #ccc;padding:.25em .7em;text-align:right}"
    "td:first-child,th:first-child{text-align:left}"
    "figure{display:inline-block;margin:.4em}"
    ".small{color:#555;font-size:13px}";

std::vector<const ChannelEdge*> with_figures(const MeasuredEdge& edge) {
  std::vector<const ChannelEdge*> out;
  for (const ChannelEdge& c : edge.channels) {
    if (c.measured.status != EdgeStatus::kRefused && !c.measured.mtf.all.points.empty()) {
      out.push_back(&c);
    }
  }
  return out;
}

double between(double x, double low, double high) { return std::clamp(x, low, high); }

std::string mtf_svg(const std::vector<const ChannelEdge*>& channels) {
  constexpr double kLow = -0.1, kHigh = 1.2;
  ReportPlot plot("Modulation transfer, 95 % band; dashed: within the window", {0, kLow},
                  {1, kHigh}, {0.1, 0.1}, 1, "cycles / pixel", "modulation");
  for (const ChannelEdge* c : channels) {
    const std::string color = channel_color(c->channel);
    std::vector<Vec2> band, line, window;
    for (const MtfPoint& p : c->measured.mtf.all.points) {
      band.push_back(plot.area.at(p.f_cy_per_px, between(p.value + kBand * p.sd, kLow, kHigh)));
      line.push_back(plot.area.at(p.f_cy_per_px, between(p.value, kLow, kHigh)));
    }
    for (std::size_t i = c->measured.mtf.all.points.size(); i-- > 0;) {
      const MtfPoint& p = c->measured.mtf.all.points[i];
      band.push_back(plot.area.at(p.f_cy_per_px, between(p.value - kBand * p.sd, kLow, kHigh)));
    }
    for (const MtfPoint& p : c->measured.mtf.window.points) {
      window.push_back(plot.area.at(p.f_cy_per_px, between(p.value, kLow, kHigh)));
    }
    plot.page.path(band, {color, 0.3, ""}, true, color + "40");
    plot.page.path(line, {color, 1.4, ""});
    plot.page.path(window, {color, 0.8, "4 3"});
  }
  return plot.page.str();
}

// Half the width of what is worth showing of an edge.
double shown_px(const std::vector<const ChannelEdge*>& channels) {
  double widest = 2;
  for (const ChannelEdge* c : channels) {
    if (c->measured.mtf.all.mtf50) {
      widest = std::max(widest, 1.2 / c->measured.mtf.all.mtf50->f_cy_per_px);
    }
  }
  return std::min(4 * std::ceil(widest / 4), 28.0);
}

std::string esf_svg(const std::vector<const ChannelEdge*>& channels) {
  const double reach = shown_px(channels);
  ReportPlot plot("Edge spread; dots: pixels, gathered", {-reach, -0.2}, {reach, 1.2},
                  {reach / 4, 0.2}, 1, "px", "light");
  for (const ChannelEdge* c : channels) {
    std::vector<Vec2> line;
    for (const ProfilePlotPoint& p : c->measured.profile) {
      if (std::abs(p.d_px) > reach) continue;
      line.push_back(plot.area.at(p.d_px, between(p.esf, -0.2, 1.2)));
      if (p.n > 0) {
        plot.page.dot(plot.area.at(p.d_px, between(p.measured, -0.2, 1.2)), 1,
                      channel_color(c->channel));
      }
    }
    plot.page.path(line, {channel_color(c->channel), 1, ""});
  }
  return plot.page.str();
}

std::string lsf_svg(const std::vector<const ChannelEdge*>& channels) {
  const double reach = shown_px(channels);
  double top = 0.1;
  for (const ChannelEdge* c : channels) {
    for (const ProfilePlotPoint& p : c->measured.profile) top = std::max(top, p.lsf);
  }
  top = 0.1 * std::ceil(10 * top + 0.2);
  ReportPlot plot("Line spread", {-reach, -0.1}, {reach, top}, {reach / 4, 0.1}, 1, "px",
                  "light / px");
  for (const ChannelEdge* c : channels) {
    std::vector<Vec2> line;
    for (const ProfilePlotPoint& p : c->measured.profile) {
      if (std::abs(p.d_px) <= reach) {
        line.push_back(plot.area.at(p.d_px, between(p.lsf, -0.1, top)));
      }
    }
    plot.page.path(line, {channel_color(c->channel), 1.3, ""});
  }
  return plot.page.str();
}

struct ResidualCurve {
  std::string channel;
  const std::vector<PsfFit::Residual>* points;
};

std::string residual_svg(const std::vector<ResidualCurve>& curves, double reach) {
  double most = 0.4;  // per cent of the contrast
  for (const ResidualCurve& c : curves) {
    for (const PsfFit::Residual& p : *c.points) {
      if (std::abs(p.d_px) <= reach) most = std::max(most, 100 * std::abs(p.value));
    }
  }
  most = std::min(20.0, 0.4 * std::ceil(most / 0.4));
  ReportPlot plot("What the shared optics leave over", {-reach, -most}, {reach, most},
                  {reach / 4, most / 4}, 1, "px", "% of the contrast");
  for (const ResidualCurve& c : curves) {
    std::vector<Vec2> line;
    for (const PsfFit::Residual& p : *c.points) {
      if (std::abs(p.d_px) <= reach) {
        line.push_back(plot.area.at(p.d_px, between(100 * p.value, -most, most)));
      }
    }
    plot.page.path(line, {channel_color(c.channel), 0.9, ""});
  }
  return plot.page.str();
}

std::string crossing(const std::optional<MtfCrossing>& at) {
  return at ? fmt::format("{:.4f} ± {:.4f}", at->f_cy_per_px, at->sd) : std::string("not reached");
}

std::string lines_per_mm(const std::optional<MtfCrossing>& at, double dpi) {
  if (!at || !(dpi > 0)) return "unknown";
  return fmt::format("{:.1f}", at->f_cy_per_px * dpi / 25.4);
}

const EdgeMeasurement* green_of(const std::vector<const ChannelEdge*>& channels) {
  for (const ChannelEdge* c : channels) {
    if (c->channel == "green") return &c->measured;
  }
  return nullptr;
}

// Of the edge in one channel against green, along the normal of the edge [px].
double shift_px(const EdgeMeasurement& m, const EdgeMeasurement& green) {
  const double nx = std::cos(green.line.normal_rad), ny = std::sin(green.line.normal_rad);
  return nx * (m.line.middle.x - green.line.middle.x) +
         ny * (m.line.middle.y - green.line.middle.y) + m.line.offset_px - green.line.offset_px;
}

std::string edge_html(const MeasuredEdge& edge, double dpi,
                      const std::vector<ResidualCurve>& residuals) {
  std::string out = fmt::format("<h3>Region {},{}, {} × {} px</h3>\n", edge.roi.x, edge.roi.y,
                                edge.roi.width, edge.roi.height);
  const auto channels = with_figures(edge);
  for (const ChannelEdge& c : edge.channels) {
    if (c.measured.status != EdgeStatus::kRefused) continue;
    out += "<p>" + xml_text(c.channel) + ": no figure.";
    for (const EdgeReason reason : c.measured.reasons) out += " " + xml_text(sentence(reason));
    out += "</p>\n";
  }
  if (channels.empty()) return out;
  const EdgeMeasurement* green = green_of(channels);
  out +=
      "<table><tr><th>channel</th><th>SFR50 (MTF50) [cy/px]</th><th>lp/mm</th><th>SFR10 "
      "[cy/px]</th>"
      "<th>lp/mm</th><th>sampling efficiency</th><th>SFR at ½ Nyquist</th>"
      "<th>within the window: SFR50</th><th>misregistration to green [px]</th><th>angle</th>"
      "<th>noise</th></tr>\n";
  for (const ChannelEdge* c : channels) {
    const EdgeMeasurement& m = c->measured;
    const MtfCurve& all = m.mtf.all;
    const std::string efficiency =
        all.mtf10
            ? fmt::format("{:.0f} %", 100 * std::min(1.0, all.mtf10->f_cy_per_px / kHalfSampling))
            : std::string("100 %");
    const auto quarter = static_cast<std::size_t>(std::lround(kHalfSampling / 2 / kMtfStepCyPerPx));
    out += fmt::format(
        "<tr><td style=\"color:{}\">{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{}</td><td>{}</td><td>{:.2f}°</td><td>{:.2f} %</td></tr>\n",
        channel_color(c->channel), xml_text(c->channel), crossing(all.mtf50),
        lines_per_mm(all.mtf50, dpi), crossing(all.mtf10), lines_per_mm(all.mtf10, dpi), efficiency,
        quarter < all.points.size() ? fmt::format("{:.3f}", all.points[quarter].value)
                                    : std::string("unknown"),
        crossing(m.mtf.window.mtf50),
        green != nullptr && &m != green ? fmt::format("{:+.3f}", shift_px(m, *green))
                                        : std::string("–"),
        m.angle_deg, 100 * m.noise);
  }
  out += "</table>\n";
  for (const ChannelEdge* c : channels) {
    if (c->measured.reasons.empty()) continue;
    out += "<p class=\"small\">" + xml_text(c->channel) + ":";
    for (const EdgeReason reason : c->measured.reasons) out += " " + xml_text(sentence(reason));
    out += "</p>\n";
  }
  for (const std::string& svg : {mtf_svg(channels), esf_svg(channels), lsf_svg(channels)}) {
    out += "<figure>" + svg + "</figure>\n";
  }
  if (!residuals.empty()) {
    out += "<figure>" + residual_svg(residuals, shown_px(channels)) + "</figure>\n";
  }
  return out;
}

std::string psf_html(const PsfFit& fit) {
  std::string out = "<h2>Optics that all edges share</h2>\n";
  if (!fit.ok) return out + "<p>" + xml_text(fit.why) + "</p>\n";
  out += "<table><tr><th>parameter</th><th>value</th><th>standard deviation</th></tr>\n";
  for (const PsfParameter& p : fit.parameters) {
    out += fmt::format("<tr><td>{}</td><td>{:.4f}</td><td>{}</td></tr>\n", xml_text(p.name),
                       p.value, p.determined ? fmt::format("{:.4f}", p.sd) : "not determined");
  }
  out += "</table>\n";
  out += fmt::format("<p>The model misses the edges by {:.2f} times their noise.</p>\n",
                     std::sqrt(fit.chi2_per_freedom));
  for (const PsfCorrelation& c : fit.correlated) {
    out +=
        fmt::format("<p class=\"small\">{} and {} trade for each other: correlation {:+.3f}.</p>\n",
                    xml_text(c.a), xml_text(c.b), c.r);
  }
  for (const std::string& remark : fit.remarks) {
    out += "<p class=\"small\">" + xml_text(remark) + "</p>\n";
  }
  return out;
}

std::string unit_html(const Profile& profile) {
  std::string out = "<table>";
  const auto row = [&](const char* name, const std::string& value) {
    if (!value.empty()) {
      out += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, xml_text(value));
    }
  };
  row("Scanner", profile.make + (profile.make.empty() ? "" : " ") + profile.model);
  row("Serial number", profile.serial);
  row("Firmware", profile.firmware);
  row("Holder", profile.holder);
  if (profile.resolution_dpi > 0)
    row("Resolution", fmt::format("{:.0f} dpi", profile.resolution_dpi));
  if (profile.focus_position) row("Focus", std::to_string(*profile.focus_position));
  return out + "</table>\n";
}

}  // namespace

std::string calibration_html(const CalibrationReport& report) {
  std::string out = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<title>Sharpness of a scanner</title><style>{}</style></head><body>\n"
      "<h1>Sharpness, measured from slanted edges</h1>\n"
      "<p class=\"small\">{}. Modulation transfer is that of all light along the normal of the "
      "edge, "
      "pixel aperture included; the window is what methods with a window see. ± is one standard "
      "deviation. Names as in ISO 12233, ISO 16067-2 and the FADGI guidelines: SFR50 and SFR10 are "
      "the frequencies where the spatial frequency response falls to 50 and 10 %; sampling "
      "efficiency is SFR10 over half the sampling frequency. No conformance is claimed.</p>\n",
      kStyle, xml_text(report.made_at_utc));
  if (report.profile != nullptr) out += unit_html(*report.profile);
  if (report.psf != nullptr) out += psf_html(*report.psf);
  if (report.profile != nullptr && report.profile->psf_model) {
    out += field_html(*report.profile->psf_model);
    if (report.profile->psf_model->surfaces) {
      out += psf_field_html(*report.profile->psf_model->surfaces);
    }
  }
  if (report.focus != nullptr) out += focus_html(*report.focus);
  if (report.gate != nullptr) out += gate_html(*report.gate);
  if (report.random != nullptr) out += random_html(*report.random, *report.random_pairs);
  const bool fitted = report.psf != nullptr && report.psf_edges != nullptr && report.psf->ok;
  for (const MeasuredFile& file : report.files) {
    out += "<h2>" + xml_text(file.path.filename().string()) + "</h2>\n";
    out += fmt::format("<p class=\"small\">{} × {} px{}{}</p>\n", file.width_px, file.height_px,
                       file.dpi > 0 ? fmt::format(", {:.0f} dpi", file.dpi) : std::string(),
                       file.context.focus_position
                           ? fmt::format(", focus {}", *file.context.focus_position)
                           : std::string());
    for (const MeasuredEdge& edge : file.edges) {
      std::vector<ResidualCurve> residuals;
      for (const ChannelEdge& c : edge.channels) {
        if (!fitted) break;
        const auto& of = report.psf_edges->of;
        const auto at = std::ranges::find(of, &c);
        const auto i = static_cast<std::size_t>(at - of.begin());
        if (at != of.end() && i < report.psf->residuals.size()) {
          residuals.push_back({c.channel, &report.psf->residuals[i]});
        }
      }
      out += edge_html(edge, file.dpi, residuals);
    }
  }
  return out + "</body></html>\n";
}

}  // namespace reseau::cli
