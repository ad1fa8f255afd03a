#include "capture/compare/compare_json.h"

#include <fmt/format.h>

#include "capture/session/json_number.h"

namespace reseau::compare {
namespace {

using Json = nlohmann::ordered_json;

Json picture_json(const PictureHeader& header, const std::string& encoding,
                  const std::vector<std::string>& notes) {
  Json object = {{"format", header.format},
                 {"width_px", header.width_px},
                 {"height_px", header.height_px},
                 {"encoding", encoding}};
  if (header.has_process) object["truth"] = true;
  if (!header.space.empty()) object["space"] = header.space;
  if (!header.primaries.empty()) object["primaries"] = header.primaries;
  if (!header.balance.empty()) object["balance"] = header.balance;
  object["map"] = header.has_map;
  object["notes"] = notes;
  return object;
}

Json rect_json(const Rect& rect) {
  return {{"x_px", rect.x_px},
          {"y_px", rect.y_px},
          {"width_px", rect.width_px},
          {"height_px", rect.height_px}};
}

Json figures_json(const DifferenceFigures& figures) {
  Json object = Json::object();
  put_number(object, "mean", figures.mean);
  put_number(object, "median", figures.median);
  put_number(object, "p95", figures.p95);
  put_number(object, "max", figures.max);
  object["pixels"] = figures.n;
  return object;
}

template <typename Values>
Json lab_json(const Values& values) {
  Json object = Json::object();
  constexpr std::array<const char*, 3> kNames{"L", "a", "b"};
  for (std::size_t k = 0; k < 3; ++k) object[kNames[k]] = number_or_null(values[k]);
  return object;
}

Json list_json(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(number_or_null(v));
  return list;
}

Json optional_list_json(const std::vector<std::optional<double>>& values) {
  Json list = Json::array();
  for (const auto& v : values) list.push_back(v ? number_or_null(*v) : Json());
  return list;
}

Json edge_json(const EdgeMtf& edge) {
  Json object = Json::object();
  if (edge.mtf50_cy_per_px) {
    put_number(object, "mtf50_cy_per_px", *edge.mtf50_cy_per_px);
  } else {
    put_missing(object, "mtf50_cy_per_px", "above 1 cycle per pixel");
  }
  put_number(object, "angle_deg", edge.angle_deg);
  put_number(object, "normal_deg", edge.geometry.normal_deg);
  put_number(object, "length_px", edge.length_px);
  put_number(object, "support_px", edge.support_px);
  put_number(object, "contrast", edge.contrast);
  put_number(object, "residual", edge.residual);
  object["mtf"] = list_json(edge.mtf);
  return object;
}

Json resolution_json(const ResolutionFigures& r) {
  Json object = {{"edge", rect_json(r.edge)}, {"a", edge_json(r.a)}, {"b", edge_json(r.b)}};
  if (r.a.mtf50_cy_per_px && r.b.mtf50_cy_per_px) {
    put_number(object, "mtf50_ratio", *r.b.mtf50_cy_per_px / *r.a.mtf50_cy_per_px);
  } else {
    put_missing(object, "mtf50_ratio", "one of the two is above 1 cycle per pixel");
  }
  put_number(object, "contrast_ratio", r.b.contrast / r.a.contrast);
  put_number(object, "edge_shift_px", r.shift_px);
  std::vector<double> frequencies;
  for (std::size_t i = 0; i < r.ratio.size(); ++i) {
    frequencies.push_back(kMtfStep * static_cast<double>(i));
  }
  object["frequency_cy_per_px"] = list_json(frequencies);
  object["mtf_ratio"] = optional_list_json(r.ratio);
  return object;
}

Json registration_json(const MapError& r) {
  Json object = Json::object();
  put_number(object, "rms_px", r.rms_px);
  put_number(object, "median_px", r.median_px);
  put_number(object, "p95_px", r.p95_px);
  put_number(object, "max_px", r.max_px);
  put_number(object, "mean_x_px", r.mean_x_px);
  put_number(object, "mean_y_px", r.mean_y_px);
  put_number(object, "rms_without_mean_px", r.rms_without_mean_px);
  object["pixels"] = r.n;
  object["not_finite"] = r.n_not_finite;
  object["whole_periods_slipped"] = r.n_slipped;
  object["period_px"] = {number_or_null(r.period_u_px), number_or_null(r.period_v_px)};
  object["equivalence"] = {
      {"axes_exchanged", r.equivalence.swapped},
      {"sign", {r.equivalence.sign_u, r.equivalence.sign_v}},
      {"periods",
       {number_or_null(r.equivalence.periods_u), number_or_null(r.equivalence.periods_v)}},
      {"gradient_mismatch", number_or_null(r.equivalence.gradient_mismatch)}};
  Json cells = Json::array();
  for (const FieldCell& cell : r.field) {
    if (cell.n == 0) continue;
    cells.push_back({{"x_px", number_or_null(cell.x_px)},
                     {"y_px", number_or_null(cell.y_px)},
                     {"dx_px", number_or_null(cell.dx_px)},
                     {"dy_px", number_or_null(cell.dy_px)},
                     {"rms_px", number_or_null(cell.rms_px)}});
  }
  object["field"] = {{"columns", r.field_columns}, {"rows", r.field_rows}, {"cells", cells}};
  return object;
}

Json shift_json(const ShiftFigures& s) {
  Json object = Json::object();
  put_number(object, "x_px", s.x_px);
  put_number(object, "y_px", s.y_px);
  put_number(object, "sd_x_px", s.sd_x_px);
  put_number(object, "sd_y_px", s.sd_y_px);
  return object;
}

Json noise_json(const NoiseFigures& n) {
  Json ratio = Json::object();
  constexpr std::array<const char*, 3> kNames{"L", "a", "b"};
  for (std::size_t k = 0; k < 3; ++k) {
    if (n.ratio[k]) {
      put_number(ratio, kNames[k], *n.ratio[k]);
    } else {
      put_missing(ratio, kNames[k], "A has no noise to divide by");
    }
  }
  return {{"squares", n.n_blocks}, {"a", lab_json(n.a)}, {"b", lab_json(n.b)}, {"ratio", ratio}};
}

void put_color(Json& object, const Comparison& c, const CompareOptions& options) {
  if (!c.color) {
    for (const char* key : {"delta_e_2000", "delta_e_2000_without_worst_1_percent",
                            "delta_e_2000_trimmed", "mean_difference_lab"}) {
      put_missing(object, key, c.no_color);
    }
    return;
  }
  object["delta_e_2000"] = figures_json(c.color->all);
  object["delta_e_2000_without_worst_1_percent"] = figures_json(c.color->without_worst_percent);
  object["delta_e_2000_trimmed"] = figures_json(c.color->trimmed);
  object["delta_e_2000_trimmed"]["worst_fraction"] = number_or_null(options.worst_fraction);
  if (c.color->bias.n_blocks > 0) {
    object["mean_difference_lab"] = lab_json(c.color->bias.lab);
    object["mean_difference_lab"]["sd"] = lab_json(c.color->bias.sd);
  } else {
    put_missing(object, "mean_difference_lab", "no whole square of 16 x 16 finite pixels");
  }
  put_number(object, "max_abs_difference", c.max_abs);
}

Json convention_json(const Comparison& c, const CompareOptions& options) {
  Json object = {{"difference", "CIEDE2000"},
                 {"lab_white", word_of(options.white)},
                 {"lab_white_xyz_a", c.lab_white_a},
                 {"lab_white_xyz_b", c.lab_white_b},
                 {"xyz_clamped", options.clamp_xyz},
                 {"own_white_adapted", options.adapt_own_white},
                 {"colors", c.pairing},
                 {"process_rgb", c.process_rgb},
                 {"fit", word_of(options.fit)}};
  if (c.color && options.fit != Fit::kNone) {
    put_number(object, "gain", c.color->gain);
    object["fit_xyz"] = c.color->fit_matrix;
  }
  return object;
}

}  // namespace

nlohmann::ordered_json comparison_to_json(const Comparison& c, const CompareOptions& options) {
  Json object = {{"schema", "reseau-compare/1"},
                 {"a", c.a.path.string()},
                 {"b", c.b.path.string()},
                 {"width_px", c.area.width_px},
                 {"height_px", c.area.height_px},
                 {"area", rect_json(c.area)},
                 {"a_picture", picture_json(c.a, c.encoding_a, c.notes_a)},
                 {"b_picture", picture_json(c.b, c.encoding_b, c.notes_b)}};
  if (c.color) {
    object["pixels"] = c.color->all.n;
    object["not_finite"] = c.color->n_not_finite;
    object["identical"] = c.identical;
    object["convention"] = convention_json(c, options);
  }
  put_color(object, c, options);
  const auto put = [&object](const char* key, const auto& figures, const std::string& reason,
                             const auto& to_json) {
    if (figures) {
      object[key] = to_json(*figures);
    } else {
      put_missing(object, key, reason);
    }
  };
  put("registration", c.registration, c.no_registration, registration_json);
  put("shift", c.shift, c.no_shift, shift_json);
  put("resolution", c.resolution, c.no_resolution, resolution_json);
  put("noise", c.noise, c.no_noise, noise_json);
  object["warnings"] = c.warnings;
  return object;
}

}  // namespace reseau::compare
