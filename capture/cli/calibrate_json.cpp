#include <cmath>

#include "capture/cli/calibrate_run.h"
#include "capture/session/json_number.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;

void put_crossing(Json& to, const std::string& key, const std::optional<MtfCrossing>& at,
                  const std::string& why) {
  if (at) {
    put_number(to, key, at->f_cy_per_px);
    put_number(to, key + "_sd", at->sd);
  } else {
    put_missing(to, key, why);
    put_missing(to, key + "_sd", why);
  }
}

Json points_to_json(const MtfCurve& curve) {
  Json out = Json::array();
  for (const MtfPoint& p : curve.points) {
    out.push_back({{"frequency", number_or_null(p.f_cy_per_px)},
                   {"value", number_or_null(p.value)},
                   {"sd", number_or_null(p.sd)}});
  }
  return out;
}

Json optics_to_json(const EdgeMeasurement& m) {
  constexpr const char* kNames[] = {"diffraction_px",       "gaussian_variance_px2",
                                    "aperture_squared_px2", "smear_squared_px2",
                                    "defocus_w20_waves",    "halo_share",
                                    "halo_sigma_px"};
  Json out = Json::object();
  for (std::size_t i = 0; i < m.optics_parameters.size(); ++i) {
    const std::string key = kNames[m.optics_parameters[i]];
    put_number(out, key, parameter(m.optics, m.optics_parameters[i]));
    put_number(out, key + "_sd", m.optics_sd[i]);
  }
  put_number(out, "aperture_px", std::sqrt(std::max(0.0, m.optics.aperture2_px2)));
  put_number(out, "residual_probability", m.residual_share);
  return out;
}

}  // namespace

Json channel_to_json(const EdgeMeasurement& m) {
  Json out = Json::object();
  out["status"] = name(m.status);
  Json reasons = Json::array(), sentences = Json::array();
  for (const EdgeReason reason : m.reasons) {
    reasons.push_back(code(reason));
    sentences.push_back(sentence(reason));
  }
  out["reasons"] = reasons;
  out["explanations"] = sentences;
  const bool refused = m.status == EdgeStatus::kRefused;
  const std::string why = refused ? "refused, see reasons" : "not reached up to 1 cycle per pixel";
  put_crossing(out, "mtf50", m.mtf.all.mtf50, why);
  put_crossing(out, "mtf30", m.mtf.all.mtf30, why);
  put_crossing(out, "mtf10", m.mtf.all.mtf10, why);
  out["mtf"] = points_to_json(m.mtf.all);
  if (refused) {
    put_missing(out, "angle_deg", why);
    return out;
  }
  put_number(out, "angle_deg", m.angle_deg);
  put_number(out, "normal_deg", m.normal_deg);
  Json window = Json::object();
  put_number(window, "half_width_px", m.mtf.window_px);
  put_crossing(window, "mtf50", m.mtf.window.mtf50, why);
  put_crossing(window, "mtf10", m.mtf.window.mtf10, why);
  window["mtf"] = points_to_json(m.mtf.window);
  out["window"] = window;
  put_number(out, "length_px", m.length_px);
  put_number(out, "reach_px", m.reach_px);
  put_number(out, "bend_px", m.line.bend_px);
  put_number(out, "wander_px", m.wander_px);
  put_number(out, "dark", m.dark);
  put_number(out, "bright", m.bright);
  put_number(out, "noise", m.noise);
  put_number(out, "noise_inflation", m.mtf.inflation);
  put_number(out, "line_correlation", m.mtf.line_correlation);
  put_number(out, "left_out", m.left_out);
  put_number(out, "phase_gap_px", m.phase_gap_px);
  out["optics"] = optics_to_json(m);
  return out;
}

namespace {

Json edge_to_json(const MeasuredEdge& edge) {
  Json out = Json::object();
  out["roi"] = {
      {"x", edge.roi.x}, {"y", edge.roi.y}, {"width", edge.roi.width}, {"height", edge.roi.height}};
  Json channels = Json::object();
  for (const ChannelEdge& c : edge.channels) channels[c.channel] = channel_to_json(c.measured);
  out["channels"] = channels;
  return out;
}

}  // namespace

Json file_to_json(const MeasuredFile& file) {
  Json out = {{"schema", "reseau-calibration/1"},
              {"file", file.path.string()},
              {"width_px", file.width_px},
              {"height_px", file.height_px},
              {"frequency_unit", "cycles per pixel along the normal of the edge"}};
  if (file.dpi > 0) put_number(out, "dpi", file.dpi);
  // The best edge, or the region asked for.
  out.update(edge_to_json(file.edges.front()));
  Json edges = Json::array();
  for (const MeasuredEdge& edge : file.edges) edges.push_back(edge_to_json(edge));
  out["edges"] = edges;
  return out;
}

}  // namespace reseau::cli
