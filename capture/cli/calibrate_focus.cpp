#include "capture/cli/calibrate_focus.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "capture/cli/calibrate_psf.h"
#include "capture/session/json_number.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;

bool has_figures(const ChannelEdge& c) {
  return c.measured.status != EdgeStatus::kRefused && c.measured.mtf.all.mtf50.has_value();
}

// The frequency at which the sharpest green falls to one half, where focus shows best.
double frequency_to_follow(const std::vector<FocusShot>& shots) {
  double green = 0, any = 0;
  for (const FocusShot& shot : shots) {
    for (const ChannelEdge& c : shot.edge.channels) {
      if (!has_figures(c)) continue;
      const double f = c.measured.mtf.all.mtf50->f_cy_per_px;
      any = std::max(any, f);
      if (c.channel == "green") green = std::max(green, f);
    }
  }
  const double f = green > 0 ? green : any;
  return f > 0 ? std::clamp(std::round(f / kMtfStepCyPerPx) * kMtfStepCyPerPx, 0.05, 0.4) : 0;
}

std::string steps_text(const Measured& m) { return fmt::format("{:.2f} ± {:.2f}", m.value, m.sd); }

}  // namespace

std::vector<FocusShot> focus_shots(const std::vector<MeasuredFile>& files) {
  std::set<int> settings;
  const MeasuredFile* first = nullptr;
  for (const MeasuredFile& file : files) {
    if (!file.context.focus_position || file.edges.empty() || !file.edges.front().measured()) {
      continue;
    }
    settings.insert(*file.context.focus_position);
    if (first == nullptr) first = &file;
  }
  std::vector<FocusShot> out;
  constexpr std::size_t kLeastSettings = 3;
  if (settings.size() < kLeastSettings) return out;
  const PixelRect& at = first->edges.front().roi;
  for (const MeasuredFile& file : files) {
    if (!file.context.focus_position) continue;
    const MeasuredEdge* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const MeasuredEdge& edge : file.edges) {
      const double apart = std::hypot(edge.roi.x - at.x, edge.roi.y - at.y);
      if (!edge.measured() || apart >= least) continue;
      least = apart;
      nearest = &edge;
    }
    if (nearest != nullptr && least <= std::max(at.width, at.height)) {
      out.push_back({*file.context.focus_position, *nearest});
    }
  }
  std::ranges::stable_sort(
      out, [](const FocusShot& a, const FocusShot& b) { return a.position < b.position; });
  return out;
}

std::optional<FocusResult> find_focus(const std::vector<FocusShot>& shots) {
  FocusResult out;
  out.f_cy_per_px = frequency_to_follow(shots);
  if (!(out.f_cy_per_px > 0)) return std::nullopt;
  const auto at = static_cast<std::size_t>(std::lround(out.f_cy_per_px / kMtfStepCyPerPx));
  for (const FocusShot& shot : shots) {
    for (const ChannelEdge& c : shot.edge.channels) {
      if (!profile_channel(c.channel)) continue;
      auto one = std::ranges::find(out.channels, c.channel, &FocusOfChannel::name);
      if (one == out.channels.end()) {
        out.channels.push_back({c.channel, {}, {}, {}});
        one = out.channels.end() - 1;
      }
      if (!has_figures(c) || at >= c.measured.mtf.all.points.size()) continue;
      const MtfPoint& point = c.measured.mtf.all.points[at];
      one->points.push_back({static_cast<double>(shot.position), point.value, point.sd});
    }
  }
  const FocusOfChannel* green = nullptr;
  for (FocusOfChannel& channel : out.channels) {
    channel.fit = fit_focus(channel.points);
    if (channel.name == "green" && channel.fit.ok) green = &channel;
  }
  for (FocusOfChannel& channel : out.channels) {
    if (green == nullptr || &channel == green || !channel.fit.ok) continue;
    channel.from_green = Measured{channel.fit.best.value - green->fit.best.value,
                                  std::hypot(channel.fit.best.sd, green->fit.best.sd)};
  }
  return out;
}

void add_psf_edges(const std::vector<FocusShot>& shots, std::vector<PsfEdge>& to) {
  // Few settings tell it, from one end to the other.
  constexpr std::size_t kMost = 5;
  const std::size_t n = std::min(kMost, shots.size());
  for (std::size_t i = 0; i < n; ++i) {
    const FocusShot& shot = shots[n > 1 ? i * (shots.size() - 1) / (n - 1) : 0];
    MeasuredFile file;
    file.context.focus_position = shot.position;
    file.edges.push_back(shot.edge);
    for (PsfEdge& edge : psf_edges({file}).edges) to.push_back(std::move(edge));
  }
}

void put_focus(const FocusResult& focus, Profile& profile) {
  for (const FocusOfChannel& channel : focus.channels) {
    const auto at = profile_channel(channel.name);
    if (!at || !channel.fit.ok) continue;
    FocusRecord record;
    record.f_cy_per_px = focus.f_cy_per_px;
    record.best_steps = channel.fit.best;
    record.from_green_steps = channel.from_green;
    record.half_depth_steps = channel.fit.half_depth;
    record.depth_share = kDepthShare;
    for (const FocusPoint& p : channel.points) {
      record.curve.push_back({p.position, p.modulation, p.sd});
    }
    profile.focus[*at] = record;
  }
}

Json focus_to_json(const FocusResult& focus) {
  Json out = Json::object();
  put_number(out, "frequency_cy_per_px", focus.f_cy_per_px);
  out["depth_share"] = kDepthShare;
  Json channels = Json::object();
  for (const FocusOfChannel& channel : focus.channels) {
    Json one = Json::object();
    one["ok"] = channel.fit.ok;
    if (channel.fit.ok) {
      put_number(one, "best_steps", channel.fit.best.value);
      put_number(one, "best_steps_sd", channel.fit.best.sd);
      put_number(one, "modulation", channel.fit.peak.value);
      put_number(one, "modulation_sd", channel.fit.peak.sd);
      if (channel.from_green) {
        put_number(one, "from_green_steps", channel.from_green->value);
        put_number(one, "from_green_steps_sd", channel.from_green->sd);
      }
      if (channel.fit.half_depth) {
        put_number(one, "depth_of_field_steps", 2 * channel.fit.half_depth->value);
        put_number(one, "depth_of_field_steps_sd", 2 * channel.fit.half_depth->sd);
      } else {
        put_missing(one, "depth_of_field_steps", "the settings do not reach that far");
      }
      put_number(one, "chi2_per_freedom", channel.fit.chi2_per_freedom);
    } else {
      one["why"] = channel.fit.why;
    }
    Json points = Json::array();
    for (const FocusPoint& p : channel.points) {
      points.push_back({{"position", number_or_null(p.position)},
                        {"modulation", number_or_null(p.modulation)},
                        {"sd", number_or_null(p.sd)}});
    }
    one["points"] = points;
    channels[channel.name] = one;
  }
  out["channels"] = channels;
  return out;
}

std::string describe(const FocusResult& focus) {
  std::string text =
      fmt::format("Focus, by the modulation at {:.2f} cycles/pixel\n", focus.f_cy_per_px);
  for (const FocusOfChannel& channel : focus.channels) {
    text += fmt::format("  {:<9} ", channel.name);
    if (!channel.fit.ok) {
      text += channel.fit.why + "\n";
      continue;
    }
    text += "best at " + steps_text(channel.fit.best) + " steps";
    if (channel.from_green) text += ", from green " + steps_text(*channel.from_green);
    if (channel.fit.half_depth) {
      text += fmt::format(", depth of field ± {} steps (to {:.0f} % of the best)",
                          steps_text(*channel.fit.half_depth), 100 * kDepthShare);
    }
    text += "\n";
  }
  text.pop_back();
  return text;
}

}  // namespace reseau::cli
