#include "capture/cli/calibrate_psf.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "capture/session/json_number.h"

namespace reseau::cli {

using Json = nlohmann::ordered_json;

bool fits_psf(const ChannelEdge& edge) {
  const EdgeMeasurement& m = edge.measured;
  return profile_channel(edge.channel) && m.status != EdgeStatus::kRefused && m.bins.size() >= 12 &&
         m.noise > 0 && m.reach_px > 0 && m.reach_px <= 98;
}

std::vector<PsfEdge> psf_edges(const std::vector<MeasuredFile>& files) {
  std::vector<PsfEdge> out;
  for (const MeasuredFile& file : files) {
    for (const MeasuredEdge& edge : file.edges) {
      for (const ChannelEdge& c : edge.channels) {
        const EdgeMeasurement& m = c.measured;
        const auto channel = profile_channel(c.channel);
        if (!fits_psf(c)) continue;
        PsfEdge one;
        one.channel = static_cast<int>(*channel);
        if (file.context.focus_position) one.focus = *file.context.focus_position;
        one.normal = {std::abs(std::cos(m.line.normal_rad)), std::abs(std::sin(m.line.normal_rad))};
        one.reach_px = m.reach_px;
        one.noise = m.noise * std::max(1.0, m.mtf.inflation);
        one.bins = m.bins;
        one.optics = m.optics;
        one.mtf50_cy_per_px = m.mtf.all.mtf50 ? m.mtf.all.mtf50->f_cy_per_px : 0;
        out.push_back(std::move(one));
      }
    }
  }
  return out;
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
