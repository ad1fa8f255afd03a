#include "capture/cli/calibrate_psf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "calibration/psf/field_map.h"
#include "capture/cli/report_plot.h"
#include "capture/session/json_number.h"

namespace reseau::cli {

using Json = nlohmann::ordered_json;

bool fits_psf(const ChannelEdge& edge) {
  const EdgeMeasurement& m = edge.measured;
  return profile_channel(edge.channel) && m.status != EdgeStatus::kRefused && m.bins.size() >= 12 &&
         m.noise > 0 && m.reach_px > 0 && m.reach_px <= 98;
}

namespace {

constexpr std::size_t kMostRegions = 12, kMostOfDirection = 2;

bool runs_along_y(const MeasuredEdge& edge) {
  for (const ChannelEdge& c : edge.channels) {
    if (fits_psf(c)) return std::abs(std::cos(c.measured.line.normal_rad)) > std::sqrt(0.5);
  }
  return false;
}

}  // namespace

PsfEdge psf_edge(const ChannelEdge& c, const MeasuredFile& file) {
  const EdgeMeasurement& m = c.measured;
  PsfEdge one;
  one.channel = static_cast<int>(*profile_channel(c.channel));
  if (file.context.focus_position) one.focus = *file.context.focus_position;
  one.normal = {std::abs(std::cos(m.line.normal_rad)), std::abs(std::sin(m.line.normal_rad))};
  one.reach_px = m.reach_px;
  one.noise = m.noise * std::max(1.0, m.mtf.inflation);
  one.bins = m.bins;
  one.optics = m.optics;
  one.mtf50_cy_per_px = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
  return one;
}

PsfChoice psf_edges(const std::vector<MeasuredFile>& files) {
  PsfChoice out;
  const std::size_t of_file =
      std::max<std::size_t>(1, kMostRegions / std::max<std::size_t>(1, files.size()));
  const std::size_t of_direction = std::min(kMostOfDirection, (of_file + 1) / 2);
  for (const MeasuredFile& file : files) {
    std::array<std::size_t, 2> taken{};
    for (const MeasuredEdge& edge : file.edges) {
      if (!edge.measured()) continue;
      std::size_t& n = taken[runs_along_y(edge) ? 1 : 0];
      if (n >= of_direction) continue;
      bool any = false;
      for (const ChannelEdge& c : edge.channels) {
        if (!fits_psf(c)) continue;
        out.edges.push_back(psf_edge(c, file));
        out.of.push_back(&c);
        any = true;
      }
      n += any ? 1 : 0;
    }
  }
  return out;
}

namespace {

constexpr std::array<std::array<double, 2>, 5> kPlaces{
    {{0, 0}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};
constexpr std::array<const char*, 5> kPlaceNames{"middle", "left, first line", "right, first line",
                                                 "left, last line", "right, last line"};

// Of the curve where it falls to one half, per cycle per pixel.
double slope_at(const MtfCurve& curve, double f) {
  const auto i = static_cast<std::size_t>(f / kMtfStepCyPerPx);
  if (i + 1 >= curve.points.size()) return 0;
  return (curve.points[i + 1].value - curve.points[i].value) / kMtfStepCyPerPx;
}

std::array<std::vector<FieldSample>, kProfileChannels> field_samples(
    const PsfFit& fit, const PsfChoice& choice, const std::vector<MeasuredFile>& files) {
  std::array<std::vector<FieldSample>, kProfileChannels> out;
  // Optics of a channel as they are in this file, at its focus.
  const auto shared_of = [&](const MeasuredFile& file,
                             const std::string& channel) -> const EdgeOptics* {
    for (std::size_t i = 0; i < choice.of.size() && i < fit.optics.size(); ++i) {
      if (choice.of[i]->channel != channel) continue;
      for (const MeasuredEdge& edge : file.edges) {
        for (const ChannelEdge& c : edge.channels) {
          if (&c == choice.of[i]) return &fit.optics[i];
        }
      }
    }
    return nullptr;
  };
  for (const MeasuredFile& file : files) {
    for (const MeasuredEdge& edge : file.edges) {
      for (const ChannelEdge& c : edge.channels) {
        if (!fits_psf(c)) continue;
        const EdgeOptics* shared = shared_of(file, c.channel);
        if (shared == nullptr) continue;
        const EdgeMeasurement& m = c.measured;
        if (!m.mtf.all.mtf50 || file.width_px < 2 || file.height_px < 2) continue;
        const double f = m.mtf.all.mtf50->f_cy_per_px;
        const NormalCosines normal{std::abs(std::cos(m.line.normal_rad)),
                                   std::abs(std::sin(m.line.normal_rad))};
        const auto extra =
            extra_variance(*shared, normal, f, m.mtf.all.mtf50->sd, slope_at(m.mtf.all, f));
        if (!extra) continue;
        out[*profile_channel(c.channel)].push_back(
            {2 * (edge.roi.x + edge.roi.width / 2.0) / file.width_px - 1,
             2 * (edge.roi.y + edge.roi.height / 2.0) / file.height_px - 1, extra->value,
             extra->sd});
      }
    }
  }
  return out;
}

}  // namespace

void put_psf(const PsfFit& fit, const PsfChoice& choice, const std::vector<MeasuredFile>& files,
             Profile& profile) {
  if (!fit.ok) return;
  PsfRecord record;
  const auto n =
      static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(fit.covariance.size()))));
  for (std::size_t i = 0; i < n && i < fit.parameters.size(); ++i) {
    const PsfParameter& p = fit.parameters[i];
    record.names.push_back(p.name);
    record.values.push_back(p.value);
    record.sd.push_back(p.determined ? p.sd : 0);
    record.determined.push_back(p.determined);
  }
  record.covariance = fit.covariance;
  record.chi2_per_freedom = fit.chi2_per_freedom;
  const auto samples = field_samples(fit, choice, files);
  for (std::size_t c = 0; c < samples.size(); ++c) {
    if (samples[c].size() > 1) record.field[c] = fit_field(samples[c]);
  }
  profile.psf_model = std::move(record);
}

Json field_to_json(const PsfRecord& record) {
  Json out = Json::object();
  for (std::size_t c = 0; c < record.field.size(); ++c) {
    const auto& field = record.field[c];
    if (!field) continue;
    Json places = Json::object();
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      const Measured at = field->at(kPlaces[i][0], kPlaces[i][1]);
      places[kPlaceNames[i]] = {{"extra_variance_px2", number_or_null(at.value)},
                                {"sd", number_or_null(at.sd)}};
    }
    out[kProfileChannelNames[c]] = {
        {"order", field->order}, {"edges", field->places.size()}, {"places", places}};
  }
  return out;
}

std::string field_html(const PsfRecord& record) {
  std::string out, plots;
  for (std::size_t c = 0; c < record.field.size(); ++c) {
    const auto& field = record.field[c];
    if (!field) continue;
    out +=
        fmt::format("<tr><td style=\"color:{0}\">{1}</td><td>{2}</td>",
                    channel_color(kProfileChannelNames[c]), kProfileChannelNames[c], field->order);
    for (const auto& place : kPlaces) {
      const Measured at = field->at(place[0], place[1]);
      out += fmt::format("<td>{:+.4f} ± {:.4f}</td>", at.value, at.sd);
    }
    out += "</tr>\n";
    if (c != 1) continue;
    ReportPlot plot("Field map, green: Gaussian variance on top of the model [px²]", {-1, -1},
                    {1, 1}, {0.5, 0.5}, 1, "along the sensor", "against the motion");
    for (const auto& place : field->places) {
      const Vec2 at = plot.area.at(place[0], -place[1]);
      plot.page.dot(at, 2, channel_color("green"));
      plot.page.text({at.x, at.y - 4}, fmt::format("{:+.3f}", place[2]), 8,
                     SvgPage::Anchor::kMiddle);
    }
    plots = "<figure>" + plot.page.str() + "</figure>\n";
  }
  if (out.empty()) return out;
  std::string head = "<h2>Over the frame</h2>\n<table><tr><th>channel</th><th>order</th>";
  for (const char* name : kPlaceNames) head += fmt::format("<th>{}</th>", name);
  return head + "</tr>\n" + out +
         "</table>\n<p class=\"small\">Gaussian variance on top of the shared optics [px²], a "
         "polynomial surface through the edges.</p>\n" +
         plots;
}

Json psf_to_json(const PsfFit& fit) {
  Json out = Json::object();
  out["ok"] = fit.ok;
  if (!fit.ok) {
    out["why"] = fit.why;
    return out;
  }
  Json parameters = Json::object();
  for (const PsfParameter& p : fit.parameters) {
    Json one = Json::object();
    put_number(one, "value", p.value);
    if (p.determined) {
      put_number(one, "sd", p.sd);
    } else {
      put_missing(one, "sd", "the edges do not determine it");
    }
    one["determined"] = p.determined;
    parameters[p.name] = one;
  }
  out["parameters"] = parameters;
  out["rank"] = fit.rank;
  Json pairs = Json::array();
  for (const PsfCorrelation& c : fit.correlated) {
    pairs.push_back({{"a", c.a}, {"b", c.b}, {"r", number_or_null(c.r)}});
  }
  out["correlated"] = pairs;
  out["remarks"] = fit.remarks;
  put_number(out, "chi2_per_freedom", fit.chi2_per_freedom);
  Json misfit = Json::array();
  for (const double rms : fit.misfit) misfit.push_back(number_or_null(rms));
  out["misfit_rms"] = misfit;
  return out;
}

std::string describe(const PsfFit& fit) {
  if (!fit.ok) return "Optics: " + fit.why;
  std::string text = "Optics that all edges share\n";
  for (const PsfParameter& p : fit.parameters) {
    if (p.determined) {
      text += fmt::format("  {:<30} {:10.4f} ± {:.4f}\n", p.name, p.value, p.sd);
    } else {
      text += fmt::format("  {:<30} {:10.4f} not determined\n", p.name, p.value);
    }
  }
  text += fmt::format("  the model misses the edges by {:.2f} times their noise\n",
                      std::sqrt(fit.chi2_per_freedom));
  for (const PsfCorrelation& c : fit.correlated) {
    text += fmt::format("  {} and {} trade for each other ({:+.3f})\n", c.a, c.b, c.r);
  }
  for (const std::string& remark : fit.remarks) text += "  " + remark + "\n";
  text.pop_back();
  return text;
}

}  // namespace reseau::cli
