#include "capture/cli/calibrate_field.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "calibration/profile/profile.h"
#include "calibration/psf/psf_field.h"
#include "capture/cli/calibrate_psf.h"
#include "capture/cli/report_plot.h"
#include "capture/color/svg.h"
#include "capture/session/json_number.h"
#include "core/geometry/vec2.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;

// Of all channels: more make the fit long and the surfaces little better.
constexpr std::size_t kMostProfiles = 160, kMostFocusShots = 5;
constexpr std::array<double, 5> kFieldSteps{-1, -0.5, 0, 0.5, 1};
constexpr std::array<Vec2, 5> kFieldCorners{Vec2{0, 0}, Vec2{-1, -1}, Vec2{1, -1}, Vec2{-1, 1},
                                            Vec2{1, 1}};
constexpr std::array<const char*, 5> kFieldCornerNames{
    "middle", "left, first line", "right, first line", "left, last line", "right, last line"};
constexpr NormalCosines kAlongX{1, 0}, kAlongY{0, 1};

Vec2 place_in_frame(const MeasuredFile& file, const PixelRect& roi) {
  return {2 * (roi.x + roi.width / 2.0) / std::max(1, file.width_px) - 1,
          2 * (roi.y + roi.height / 2.0) / std::max(1, file.height_px) - 1};
}

struct PlacedEdges {
  std::vector<PsfEdge> edges;
  std::vector<Vec2> places;

  void add(const MeasuredFile& file, const MeasuredEdge& edge, Vec2 at) {
    for (const ChannelEdge& c : edge.channels) {
      if (!fits_psf(c)) continue;
      edges.push_back(psf_edge(c, file));
      places.push_back(at);
    }
  }
};

std::string field_value_at(const PsfFieldRecord& field, const PsfFieldRecord::Surface& surface,
                           Vec2 at) {
  const auto m = field.at(surface.name, at.x, at.y);
  if (!m) return "";
  return surface.determined ? fmt::format("{:+.4f} ± {:.4f}", m->value, m->sd)
                            : fmt::format("{:+.4f}, not determined", m->value);
}

}  // namespace

std::optional<PsfFieldRecord> field_of(const std::vector<MeasuredFile>& files,
                                       const std::vector<FocusShot>& focus, const PsfFit& shared,
                                       const std::function<bool()>& stop) {
  if (files.empty() || !shared.ok) return std::nullopt;
  PlacedEdges all;
  // Edges come best first; every file gives as many of them.
  const std::size_t of_file =
      std::max<std::size_t>(1, kMostProfiles / (kProfileChannels * files.size()));
  for (const MeasuredFile& file : files) {
    std::size_t n = 0;
    for (const MeasuredEdge& edge : file.edges) {
      if (!edge.measured() || n++ >= of_file) continue;
      all.add(file, edge, place_in_frame(file, edge.roi));
    }
  }
  const MeasuredFile& first = files.front();
  const std::size_t shots = std::min(kMostFocusShots, focus.size());
  for (std::size_t i = 0; i < shots && !first.edges.empty(); ++i) {
    const FocusShot& shot = focus[shots > 1 ? i * (focus.size() - 1) / (shots - 1) : 0];
    MeasuredFile at_setting;
    at_setting.context.focus_position = shot.position;
    if (shot.edge.measured()) {
      all.add(at_setting, shot.edge, place_in_frame(first, first.edges.front().roi));
    }
  }
  auto out = fit_psf_field(all.edges, all.places, shared, stop);
  if (out) out->frame_px = {first.width_px, first.height_px};
  return out;
}

Json psf_field_to_json(const PsfFieldRecord& field) {
  Json out = Json::object();
  out["known"] = field.known;
  out["frame_px"] = field.frame_px;
  out["edges"] = field.edges;
  out["coefficients"] = field.coefficients.size();
  out["rank"] = field.rank;
  put_number(out, "scatter", field.scatter);
  Json parameters = Json::object();
  for (const PsfFieldRecord::Surface& surface : field.surfaces) {
    Json grid = Json::array();
    for (const double y : kFieldSteps) {
      for (const double x : kFieldSteps) {
        const auto m = field.at(surface.name, x, y);
        Json one = {{"x", x}, {"y", y}};
        put_number(one, "value", m->value);
        if (surface.determined) {
          put_number(one, "sd", m->sd);
        } else {
          put_missing(one, "sd", "the edges do not determine it");
        }
        grid.push_back(one);
      }
    }
    parameters[surface.name] = {
        {"order", surface.order}, {"determined", surface.determined}, {"grid", grid}};
  }
  out["parameters"] = parameters;
  Json mtf50 = Json::object();
  for (int c = 0; c < kProfileChannels; ++c) {
    Json grid = Json::array();
    for (const double y : kFieldSteps) {
      for (const double x : kFieldSteps) {
        const auto along_x = field_mtf50(field, c, kAlongX, x, y);
        const auto along_y = field_mtf50(field, c, kAlongY, x, y);
        if (!along_x || !along_y) continue;
        grid.push_back({{"x", x},
                        {"y", y},
                        {"mtf50_x", number_or_null(along_x->value)},
                        {"mtf50_x_sd", number_or_null(along_x->sd)},
                        {"mtf50_y", number_or_null(along_y->value)},
                        {"mtf50_y_sd", number_or_null(along_y->sd)}});
      }
    }
    if (!grid.empty()) mtf50[kProfileChannelNames[static_cast<std::size_t>(c)]] = grid;
  }
  out["mtf50"] = mtf50;
  if (field.has_focus) put_number(out, "mtf50_at_focus", field.focus);
  Json pairs = Json::array();
  for (const auto& pair : field.correlated) {
    pairs.push_back({{"a", pair.a}, {"b", pair.b}, {"r", number_or_null(pair.r)}});
  }
  out["correlated"] = pairs;
  out["remarks"] = field.remarks;
  return out;
}

std::string describe(const PsfFieldRecord& field) {
  std::string text = fmt::format(
      "Optics over the frame, {} edge profiles: middle; corners left and right of the first line, "
      "of the last\n",
      field.edges);
  for (const PsfFieldRecord::Surface& surface : field.surfaces) {
    text += fmt::format("  {:<30}", surface.name);
    for (std::size_t i = 0; i < (surface.order > 0 ? kFieldCorners.size() : 1); ++i) {
      text += "  " + field_value_at(field, surface, kFieldCorners[i]);
    }
    text += surface.order > 0 ? "\n" : "  everywhere\n";
  }
  for (int c = 0; c < kProfileChannels; ++c) {
    std::string line;
    for (const Vec2 at : kFieldCorners) {
      const auto m = field_mtf50(field, c, kAlongX, at.x, at.y);
      if (m) line += fmt::format("  {:.4f} ± {:.4f}", m->value, m->sd);
    }
    if (!line.empty()) {
      text += fmt::format("  {:<30}{}\n",
                          std::string(kProfileChannelNames[static_cast<std::size_t>(c)]) +
                              ".mtf50 along the sensor",
                          line);
    }
  }
  for (const auto& pair : field.correlated) {
    text += fmt::format("  {} and {} trade for each other ({:+.3f})\n", pair.a, pair.b, pair.r);
  }
  for (const std::string& remark : field.remarks) text += "  " + remark + "\n";
  text.pop_back();
  return text;
}

std::string psf_field_html(const PsfFieldRecord& field) {
  std::string out = "<h2>Optics over the frame</h2>\n<table><tr><th>parameter</th><th>order</th>";
  for (const char* name : kFieldCornerNames) out += fmt::format("<th>{}</th>", name);
  out += "</tr>\n";
  for (const PsfFieldRecord::Surface& surface : field.surfaces) {
    out += fmt::format("<tr><td>{}</td><td>{}</td>", surface.name, surface.order);
    for (const Vec2 at : kFieldCorners) {
      out += fmt::format("<td>{}</td>", field_value_at(field, surface, at));
    }
    out += "</tr>\n";
  }
  out += "</table>\n";
  for (const auto& pair : field.correlated) {
    out += fmt::format("<p class=\"small\">{} and {} trade for each other: {:+.3f}.</p>\n", pair.a,
                       pair.b, pair.r);
  }
  for (const std::string& remark : field.remarks) {
    out += "<p class=\"small\">" + xml_text(remark) + "</p>\n";
  }
  for (int c = 0; c < kProfileChannels && field.known; ++c) {
    const std::string name = kProfileChannelNames[static_cast<std::size_t>(c)];
    if (!field_mtf50(field, c, kAlongX, 0, 0)) continue;
    ReportPlot plot(fmt::format("Field map, {}: MTF50 along the sensor [cycles/px], ± below", name),
                    {-1.2, -1.2}, {1.2, 1.2}, {0.4, 0.4}, 1, "along the sensor",
                    "against the motion");
    for (const double y : kFieldSteps) {
      for (const double x : kFieldSteps) {
        const auto m = field_mtf50(field, c, kAlongX, x, y);
        if (!m) continue;
        const Vec2 at = plot.area.at(x, -y);
        plot.page.dot(at, 2, channel_color(name));
        plot.page.text({at.x, at.y - 4}, fmt::format("{:.4f}", m->value), 8,
                       SvgPage::Anchor::kMiddle);
        plot.page.text({at.x, at.y + 10}, fmt::format("± {:.4f}", m->sd), 7,
                       SvgPage::Anchor::kMiddle);
      }
    }
    out += "<figure>" + plot.page.str() + "</figure>\n";
  }
  return out;
}

}  // namespace reseau::cli
