#include "calibration/profile/records_io.h"

#include <array>
#include <cmath>
#include <utility>

namespace reseau::profile {
namespace {

Json pair_of(const Measured& m) { return Json::array({m.value, m.sd}); }

void put(Json& to, const char* name, const std::optional<double>& value) {
  if (value) to[name] = *value;
}
void put(Json& to, const char* name, const std::optional<Measured>& value) {
  if (value) to[name] = pair_of(*value);
}

std::optional<Measured> measured_in(const Fields& from, const char* name) {
  if (!from.has(name)) return std::nullopt;
  const auto two = from.numbers(name);
  if (two.size() != 2) throw from.error(name, "must hold a value and its deviation");
  return Measured{two[0], two[1]};
}

Json gate_to_json(const GateRecord& gate) {
  Json json = Json::object();
  put(json, "dark_level_sd", gate.dark_level_sd);
  if (gate.noise_covariance) json["noise_covariance"] = *gate.noise_covariance;
  put(json, "flat_gain_sd", gate.flat_gain_sd);
  put(json, "shading", gate.shading);
  put(json, "pixel_gain_rms", gate.pixel_gain_rms);
  put(json, "lamp_rms", gate.lamp_rms);
  if (!gate.line_gains.empty()) {
    Json gains = Json::array(), sd = Json::array();
    for (const Measured& gain : gate.line_gains) {
      gains.push_back(gain.value);
      sd.push_back(gain.sd);
    }
    json["line_gain"] = gains;
    json["line_gain_sd"] = sd;
  }
  put(json, "nonlinearity", gate.nonlinearity);
  Json leakage = Json::object();
  for (std::size_t k = 0; k < gate.leakage.size(); ++k) {
    put(leakage, kProfileChannelNames[k], gate.leakage[k]);
  }
  if (!leakage.empty()) json["leakage_from"] = leakage;
  return json;
}

GateRecord gate_from(const Fields& from) {
  GateRecord gate;
  gate.dark_level_sd = from.optional_number("dark_level_sd");
  if (from.has("noise_covariance")) {
    const auto three = from.numbers("noise_covariance");
    if (three.size() != 3) throw from.error("noise_covariance", "must hold three numbers");
    gate.noise_covariance = std::array<double, 3>{three[0], three[1], three[2]};
  }
  gate.flat_gain_sd = from.optional_number("flat_gain_sd");
  gate.shading = from.optional_number("shading");
  gate.pixel_gain_rms = from.optional_number("pixel_gain_rms");
  gate.lamp_rms = from.optional_number("lamp_rms");
  if (from.has("line_gain")) {
    const auto gains = from.numbers("line_gain"), sd = from.numbers("line_gain_sd");
    if (gains.size() != sd.size()) {
      throw from.error("line_gain", "must hold as many deviations as gains");
    }
    for (std::size_t i = 0; i < gains.size(); ++i) gate.line_gains.push_back({gains[i], sd[i]});
  }
  gate.nonlinearity = measured_in(from, "nonlinearity");
  if (const auto leakage = from.object("leakage_from")) {
    for (std::size_t k = 0; k < gate.leakage.size(); ++k) {
      gate.leakage[k] = measured_in(*leakage, kProfileChannelNames[k]);
    }
  }
  return gate;
}

Json focus_to_json(const FocusRecord& focus) {
  Json json = Json::object();
  json["f_cy_per_px"] = focus.f_cy_per_px;
  json["best_steps"] = pair_of(focus.best_steps);
  put(json, "from_green_steps", focus.from_green_steps);
  put(json, "half_depth_steps", focus.half_depth_steps);
  json["depth_share"] = focus.depth_share;
  Json position = Json::array(), modulation = Json::array(), sd = Json::array();
  for (const auto& point : focus.curve) {
    position.push_back(point[0]);
    modulation.push_back(point[1]);
    sd.push_back(point[2]);
  }
  json["curve"] = {{"position", position}, {"modulation", modulation}, {"sd", sd}};
  return json;
}

FocusRecord focus_from(const Fields& from) {
  FocusRecord focus;
  focus.f_cy_per_px = from.number("f_cy_per_px");
  const auto best = measured_in(from, "best_steps");
  if (!best) throw from.error("best_steps", "is missing");
  focus.best_steps = *best;
  focus.from_green_steps = measured_in(from, "from_green_steps");
  focus.half_depth_steps = measured_in(from, "half_depth_steps");
  focus.depth_share = from.number("depth_share");
  if (const auto curve = from.object("curve")) {
    const auto position = curve->numbers("position"), modulation = curve->numbers("modulation"),
               sd = curve->numbers("sd");
    if (position.size() != modulation.size() || position.size() != sd.size()) {
      throw from.error("curve", "must hold as many values and deviations as positions");
    }
    for (std::size_t i = 0; i < position.size(); ++i) {
      focus.curve.push_back({position[i], modulation[i], sd[i]});
    }
  }
  return focus;
}

Json field_to_json(const FieldRecord& field) {
  Json places = Json::array();
  for (const auto& place : field.places) places.push_back(place);
  return {{"order", field.order},
          {"coefficients_px2", field.coefficients},
          {"covariance", field.covariance},
          {"places", places}};
}

FieldRecord field_from(const Fields& from) {
  FieldRecord field;
  const double order = from.number("order");
  if (order != 0 && order != 1 && order != 2) throw from.error("order", "must be 0, 1 or 2");
  field.order = static_cast<int>(order);
  field.coefficients = from.numbers("coefficients_px2");
  field.covariance = from.numbers("covariance");
  constexpr std::array<std::size_t, 3> kTerms{1, 3, 6};
  const std::size_t n = kTerms[static_cast<std::size_t>(field.order)];
  if (field.coefficients.size() != n || field.covariance.size() != n * n) {
    throw from.error("coefficients_px2", "must fit the order, and so must the covariance");
  }
  if (const auto flat = from.rows("places", 4); !flat.empty()) {
    for (const auto& row : flat) field.places.push_back({row[0], row[1], row[2], row[3]});
  }
  return field;
}

Json curve_to_json(const std::vector<std::array<double, 3>>& curve) {
  Json f = Json::array(), value = Json::array(), sd = Json::array();
  for (const auto& point : curve) {
    f.push_back(point[0]);
    value.push_back(point[1]);
    sd.push_back(point[2]);
  }
  return {{"f_cy_per_px", f}, {"value", value}, {"sd", sd}};
}

std::vector<std::array<double, 3>> curve_in(const Fields& from, const char* name) {
  std::vector<std::array<double, 3>> out;
  const auto curve = from.object(name);
  if (!curve) return out;
  const auto f = curve->numbers("f_cy_per_px"), value = curve->numbers("value"),
             sd = curve->numbers("sd");
  if (f.size() != value.size() || f.size() != sd.size()) {
    throw from.error(name, "must hold as many values and deviations as frequencies");
  }
  for (std::size_t i = 0; i < f.size(); ++i) out.push_back({f[i], value[i], sd[i]});
  return out;
}

Json random_to_json(const RandomRecord& random) {
  Json json = {{"seed", random.seed},       {"cell_um", random.cell_um}, {"side", random.side},
               {"step_px", random.step_px}, {"psf_per_px2", random.psf}, {"psf_sd", random.sd}};
  json["relative_sd"] = random.relative_sd;
  json["light_outside"] = pair_of(random.light_outside);
  put(json, "mtf50_x", random.mtf50_x);
  put(json, "mtf50_y", random.mtf50_y);
  json["along_x"] = curve_to_json(random.along_x);
  json["along_y"] = curve_to_json(random.along_y);
  return json;
}

RandomRecord random_from(const Fields& from) {
  RandomRecord random;
  random.seed = from.number("seed");
  random.cell_um = from.number("cell_um");
  const double side = from.number("side");
  random.step_px = from.number("step_px");
  random.psf = from.numbers("psf_per_px2");
  random.sd = from.numbers("psf_sd");
  constexpr double kMostSide = 1000;
  if (!(side >= 1) || !(side <= kMostSide) || side != std::floor(side) ||
      static_cast<double>(random.psf.size()) != side * side ||
      random.sd.size() != random.psf.size()) {
    throw from.error("psf_per_px2", "must hold side times side numbers, and so must 'psf_sd'");
  }
  random.side = static_cast<int>(side);
  random.relative_sd = from.number("relative_sd");
  random.light_outside = measured_in(from, "light_outside").value_or(Measured{});
  random.mtf50_x = measured_in(from, "mtf50_x");
  random.mtf50_y = measured_in(from, "mtf50_y");
  random.along_x = curve_in(from, "along_x");
  random.along_y = curve_in(from, "along_y");
  return random;
}

Json surfaces_to_json(const PsfFieldRecord& field) {
  Json json = Json::object();
  json["frame_px"] = field.frame_px;
  json["edges"] = field.edges;
  json["known"] = Json::array({field.known});
  if (field.has_focus) json["focus"] = field.focus;
  Json names = Json::array(), orders = Json::array(), determined = Json::array();
  for (const PsfFieldRecord::Surface& s : field.surfaces) {
    names.push_back(s.name);
    orders.push_back(s.order);
    determined.push_back(s.determined);
  }
  json["names"] = names;
  json["orders"] = orders;
  json["determined"] = determined;
  json["coefficients"] = field.coefficients;
  json["covariance"] = field.covariance;
  json["rank"] = field.rank;
  json["scatter"] = field.scatter;
  Json pairs = Json::array(), r = Json::array();
  for (const PsfFieldRecord::Pair& pair : field.correlated) {
    pairs.push_back(pair.a);
    pairs.push_back(pair.b);
    r.push_back(pair.r);
  }
  json["correlated"] = pairs;
  json["correlations"] = r;
  json["remarks"] = field.remarks;
  return json;
}

PsfFieldRecord surfaces_from(const Fields& from) {
  PsfFieldRecord field;
  constexpr double kMostPx = 1e7, kMostEdges = 1e6;
  const auto whole = [&](const char* name, double value, double most) {
    if (!(value >= 0) || !(value <= most)) throw from.error(name, "is out of range");
    return static_cast<int>(value);
  };
  const std::vector<double> frame = from.numbers("frame_px");
  if (frame.size() != 2) throw from.error("frame_px", "must hold width and height");
  field.frame_px = {whole("frame_px", frame[0], kMostPx), whole("frame_px", frame[1], kMostPx)};
  field.edges = whole("edges", from.number("edges"), kMostEdges);
  const std::vector<bool> known = from.flags("known");
  field.known = !known.empty() && known.front();
  field.has_focus = from.has("focus");
  field.focus = from.optional_number("focus").value_or(0);
  const auto names = from.texts("names");
  const auto orders = from.numbers("orders");
  const auto determined = from.flags("determined");
  field.coefficients = from.numbers("coefficients");
  field.covariance = from.numbers("covariance");
  if (orders.size() != names.size() || determined.size() != names.size()) {
    throw from.error("orders", "must hold one for each of the names, and so must 'determined'");
  }
  std::size_t n = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int order = whole("orders", orders[i], 2);
    n += order == 0 ? 1 : order == 1 ? 3 : 6;
    field.surfaces.push_back({names[i], order, determined[i]});
  }
  if (field.coefficients.size() != n || field.covariance.size() != n * n) {
    throw from.error("coefficients", "must fit the orders, and so must the covariance");
  }
  field.rank = whole("rank", from.number("rank"), static_cast<double>(n));
  field.scatter = from.number("scatter");
  const auto pairs = from.texts("correlated");
  const auto r = from.numbers("correlations");
  if (pairs.size() != 2 * r.size()) {
    throw from.error("correlated", "must hold two names for each of the correlations");
  }
  for (std::size_t i = 0; i < r.size(); ++i) {
    field.correlated.push_back({pairs[2 * i], pairs[2 * i + 1], r[i]});
  }
  field.remarks = from.texts("remarks");
  return field;
}

}  // namespace

void put_records(const Profile& profile, std::size_t channel, Json& to) {
  if (const auto& gate = profile.gate[channel]) to["gate"] = gate_to_json(*gate);
  if (const auto& focus = profile.focus[channel]) to["focus"] = focus_to_json(*focus);
  if (const auto& sd = profile.offset_sd_px[channel]) to["offset_sd_px"] = {sd->x_px, sd->y_px};
  if (const auto& random = profile.random[channel]) to["random"] = random_to_json(*random);
}

void get_records(const Fields& from, std::size_t channel, Profile& profile) {
  if (const auto random = from.object("random")) profile.random[channel] = random_from(*random);
  if (const auto gate = from.object("gate")) profile.gate[channel] = gate_from(*gate);
  if (const auto focus = from.object("focus")) profile.focus[channel] = focus_from(*focus);
  if (from.has("offset_sd_px")) {
    const auto xy = from.numbers("offset_sd_px");
    if (xy.size() != 2) throw from.error("offset_sd_px", "must hold those of x and y");
    profile.offset_sd_px[channel] = OffsetSd{xy[0], xy[1]};
  }
}

Json psf_record_to_json(const PsfRecord& record) {
  Json json = Json::object();
  json["names"] = record.names;
  json["values"] = record.values;
  json["sd"] = record.sd;
  json["determined"] = record.determined;
  json["covariance"] = record.covariance;
  json["chi2_per_freedom"] = record.chi2_per_freedom;
  Json field = Json::object();
  for (std::size_t c = 0; c < record.field.size(); ++c) {
    if (record.field[c]) field[kProfileChannelNames[c]] = field_to_json(*record.field[c]);
  }
  if (!field.empty()) json["field"] = field;
  if (record.surfaces) json["surfaces"] = surfaces_to_json(*record.surfaces);
  return json;
}

PsfRecord psf_record_from(const Fields& from) {
  PsfRecord record;
  record.names = from.texts("names");
  record.values = from.numbers("values");
  record.sd = from.numbers("sd");
  record.determined = from.flags("determined");
  record.covariance = from.numbers("covariance");
  record.chi2_per_freedom = from.number("chi2_per_freedom");
  const std::size_t n = record.names.size();
  if (record.values.size() != n || record.sd.size() != n || record.determined.size() != n ||
      record.covariance.size() != n * n) {
    throw from.error("values", "must hold one for each of the names, and so must the others");
  }
  if (const auto field = from.object("field")) {
    for (std::size_t c = 0; c < record.field.size(); ++c) {
      if (const auto one = field->object(kProfileChannelNames[c])) {
        record.field[c] = field_from(*one);
      }
    }
  }
  if (const auto surfaces = from.object("surfaces")) record.surfaces = surfaces_from(*surfaces);
  return record;
}

}  // namespace reseau::profile
