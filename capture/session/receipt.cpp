#include "capture/session/receipt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/color/color_record.h"
#include "capture/session/json_number.h"
#include "capture/session/offsets_json.h"
#include "capture/session/request_json.h"
#include "capture/store/part_file.h"
#include "capture/store/sha256.h"
#include "core/line/channel_name.h"

namespace reseau {

namespace {

using nlohmann::ordered_json;

constexpr std::array kChannelNames{"red", "green", "blue", "infrared"};

const char* end_word(ScanEnd end) {
  constexpr std::array kWords{"complete", "cancelled", "failed"};
  return kWords[static_cast<std::size_t>(end)];
}

double seconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-6; }

std::string message_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& exception) {
    return exception.what();
  } catch (...) {
    return "unknown";
  }
}

ordered_json input_to_json(const ReceiptInput& input) {
  ordered_json channels = ordered_json::array();
  for (const Channel channel : input.format.channels) channels.push_back(channel_name(channel));
  ordered_json object = {{"width_px", input.format.width_px},
                         {"lines", input.format.n_lines},
                         {"channels", channels},
                         {"significant_bits", input.format.significant_bits}};
  for (const auto& [key, dpi] :
       {std::pair{"x_dpi", input.format.x_dpi}, std::pair{"y_dpi", input.format.y_dpi}}) {
    if (dpi > 0) {
      put_number(object, key, dpi);
    } else {
      put_missing(object, key, "the scan does not say its resolution");
    }
  }
  object["tone"] = input.tone;
  object["notes"] = input.notes;
  return object;
}

ordered_json device_to_json(const CaptureContext& context) {
  ordered_json object = {{"name", context.device_name},
                         {"make", context.make},
                         {"model", context.model},
                         {"firmware", context.firmware},
                         {"serial", context.serial},
                         {"holder", context.holder},
                         {"started_at_utc", context.started_at_utc}};
  if (context.focus_position) {
    object["focus_position"] = *context.focus_position;
  } else {
    put_missing(object, "focus_position", "not known");
  }
  ordered_json exposure = ordered_json::object();
  for (std::size_t i = 0; i < kChannelNames.size(); ++i) {
    if (context.exposure_us[i]) put_number(exposure, kChannelNames[i], *context.exposure_us[i]);
  }
  object["exposure_us"] = exposure;
  return object;
}

ordered_json scan_to_json(const ReceiptScan& scan) {
  ordered_json adjusted = ordered_json::array();
  for (const Adjustment& a : scan.negotiated.adjusted) {
    adjusted.push_back(
        {{"field", a.field}, {"asked", a.asked}, {"granted", a.granted}, {"why", a.why}});
  }
  const ScanOutcome& outcome = scan.outcome;
  ordered_json object = {{"end", end_word(outcome.end)},
                         {"lines", outcome.lines},
                         {"lines_planned", scan.negotiated.plan.format.n_lines},
                         {"request", request_to_json(scan.request)},
                         {"adjusted", adjusted},
                         {"resolution_dpi", scan.negotiated.plan.resolution_dpi},
                         {"depth_bits", scan.negotiated.plan.depth_bits},
                         {"samples", scan.negotiated.plan.samples},
                         {"sensor_lines", scan.negotiated.plan.sensor_lines},
                         {"disk_stalls", outcome.queue.n_stalls}};
  put_number(object, "disk_stalled_s", seconds(outcome.queue.stalled));
  put_number(object, "preparing_s", seconds(outcome.preparing));
  put_number(object, "scanning_s", seconds(outcome.scanning));
  put_number(object, "finishing_s", seconds(outcome.finishing));
  if (outcome.error) object["error"] = message_of(outcome.error);
  return object;
}

template <std::size_t N>
ordered_json by_channel(const std::array<double, N>& values, std::size_t n_channels) {
  ordered_json object = ordered_json::object();
  for (std::size_t i = 0; i < n_channels && i < N; ++i) {
    put_number(object, kChannelNames[i], values[i]);
  }
  return object;
}

// The weights that were used, or, for a scan with infrared, those that it teaches.
ordered_json silver_to_json(const Receipt& receipt) {
  const Development& development = *receipt.development;
  const SilverWeights& used = development.report->silver_from_rgb;
  if (development.report->from_infrared) {
    if (!development.learned) return nullptr;
    ordered_json object = learned_silver_to_json(*development.learned);
    object["origin"] = "learned on this scan, not used in it";
    return object;
  }
  const std::string& learned_on = receipt.settings.silver.learned_on;
  ordered_json object = {
      {"weights",
       {number_or_null(used.weights[0]), number_or_null(used.weights[1]),
        number_or_null(used.weights[2])}},
      {"offset", number_or_null(used.offset)},
      {"origin", learned_on.empty() ? "element classes of this scan" : "learned on " + learned_on}};
  if (learned_on.empty()) {
    object["note"] =
        "The brightest of each element count as clear, so that the colours hold up to a white "
        "balance.";
  }
  if (development.learned) {
    object["infrared_of_this_scan"] = learned_silver_to_json(*development.learned);
  }
  return object;
}

ordered_json report_to_json(const Receipt& receipt) {
  const ReconstructionReport& report = *receipt.development->report;
  const std::size_t n_channels = receipt.input.format.channels.size();
  ordered_json sharpness = ordered_json::object();
  for (std::size_t i = 0; i < n_channels; ++i) {
    ordered_json channel = {{"origin", report.sharpness.origin[i]}};
    put_number(channel, "sigma_px", report.sharpness.sigma_px[i]);
    put_number(channel, "sigma_sd_px", report.sharpness.sigma_sd_px[i]);
    put_number(channel, "sigma_least_px", report.sharpness.sigma_range_px[i][0]);
    put_number(channel, "sigma_most_px", report.sharpness.sigma_range_px[i][1]);
    channel["field_degree"] = report.sharpness.field_degree[i];
    ordered_json field = ordered_json::array();
    for (const BlurPlace& place : report.sharpness.field[i]) {
      ordered_json at = {{"x_px", place.at_px.x}, {"y_px", place.at_px.y}};
      put_number(at, "sigma_px", place.sigma_px);
      if (place.sd_px > 0) put_number(at, "sigma_sd_px", place.sd_px);
      field.push_back(at);
    }
    if (!field.empty()) channel["field"] = field;
    if (const auto& unit = report.sharpness.of_unit[i]) {
      channel["of_unit"] = {{"sigma_px", unit->sigma_px},
                            {"sigma_sd_px", unit->sd_px},
                            {"far_share", unit->far_share}};
    }
    sharpness[kChannelNames[i]] = channel;
  }
  if (std::isfinite(report.sharpness.in_focus_px))
    sharpness["in_focus_px"] = report.sharpness.in_focus_px;
  const UsedProfile& profile = receipt.settings.profile;
  if (!profile.path.empty()) {
    sharpness["profile"] = {{"path", profile.path.string()},
                            {"measured_at_utc", profile.measured_at_utc}};
    const bool linear = receipt.settings.tone.is_linear();
    sharpness["profile"]["dark_level_used"] =
        linear && std::ranges::any_of(profile.levels.dark_level, [](double d) { return d != 0; });
    sharpness["profile"]["flat_field_used"] =
        linear && profile.levels.fits(receipt.input.format.width_px);
  }
  if (!profile.notes.empty()) sharpness["profile_notes"] = profile.notes;
  if (const auto& sd = report.sharpness.infrared_shift_sd_px) {
    const Vec2 at = report.sharpness.infrared_shift_px;
    sharpness["infrared_from_rgb_px"] = {number_or_null(at.x), number_or_null(at.y)};
    sharpness["infrared_from_rgb_sd_px"] = {number_or_null(sd->x), number_or_null(sd->y)};
  } else {
    put_missing(sharpness, "infrared_from_rgb_px", "the réseau does not tell it in this picture");
  }
  sharpness["channels_from_green"] = channel_offsets_to_json(report.sharpness.channel_offsets);
  put_number(sharpness, "stretch", report.sharpness.stretch);
  put_number(sharpness, "stretch_sd", report.sharpness.stretch_sd);
  ordered_json object = {{"silver_from", report.from_infrared ? "infrared" : "rgb"},
                         {"silver_from_rgb", silver_to_json(receipt)},
                         {"sharpness", sharpness}};
  if (report.deconvolution != Deconvolution::kNone) {
    object["deconvolution"] = {{"method", deconvolution_name(report.deconvolution)},
                               {"noise_gain", number_or_null(report.sharpening_noise_gain)},
                               {"iterations", report.sharpening_iterations}};
  }
  put_number(object, "unmix_condition", report.unmix_condition);
  put_number(object, "unmix_noise_gain", report.unmix_noise_gain);
  object["clipped_fraction"] = by_channel(report.clipped_fraction, n_channels);
  object["skipped"] = report.skipped;
  put_number(object, "blank_fraction", report.blank_fraction);
  return object;
}

ordered_json settings_to_json(const Receipt& receipt) {
  const DevelopOptions& s = receipt.settings;
  ColorRecipe color = s.color;
  color.white_balance = receipt.development->white_balance;
  ordered_json object = color_to_json(color);
  if (s.neutral) object["neutral"] = s.neutral->text();
  object["view_gamut"] = s.view_gamut == ViewGamut::kClip ? "clip" : "perceptual";
  object["quality"] = receipt.quality;
  object["deconvolve"] = s.deconvolution ? deconvolution_name(*s.deconvolution) : "auto";
  object["demosaic"] = demosaic_name(demosaic_of(s.quality, s.demosaic));
  object["geometry"] = s.frame.geometry == Geometry::kScan   ? "scan"
                       : s.frame.geometry == Geometry::kFilm ? "film"
                                                             : "screen";
  put_number(object, "scale", s.frame.scale);
  if (const auto& r = s.frame.region) object["region"] = {r->x0, r->y0, r->width(), r->height()};
  object["exact"] = s.exact;
  object["threads"] = s.n_threads;
  put_number(object, "white_level", s.white_level);
  put_number(object, "black_level", s.black_level);
  if (s.blur_px) put_number(object, "blur_px", *s.blur_px);
  return object;
}

ordered_json live_to_json(const LiveReport& live) {
  ordered_json object = {{"quality", "draft"},
                         {"sharpness", "of the lines so far"},
                         {"lock_lines", live.lock_lines},
                         {"lines", live.n_lines},
                         {"tiles", live.n_tiles},
                         {"maps", live.n_maps},
                         {"largest_lag_lines", live.largest_lag_lines}};
  if (live.lock_lines == 0) object["why_not"] = "No réseau was found while lines came.";
  if (!live.why_not.empty()) object["why_not"] = live.why_not;
  return object;
}

void add_development(ordered_json& object, const Receipt& receipt) {
  if (!receipt.development) {
    object["reconstruction"] = nullptr;
    object["why_no_picture"] = "Nobody asked for one.";
    return;
  }
  const Development& development = *receipt.development;
  object["registration"] = registration_to_json(development.registration);
  ordered_json timings = ordered_json::object();
  put_number(timings, "registration_s", development.registration.seconds);
  if (development.report) {
    object["reconstruction"] = report_to_json(receipt);
    put_number(timings, "sharpness_s", development.report->seconds_sharpness);
    put_number(timings, "render_s", development.report->seconds_render);
  } else {
    object["reconstruction"] = nullptr;
    object["why_no_picture"] = development.why_not;
  }
  if (development.picture) {
    ordered_json view = ordered_json::object();
    put_number(view, "exposure", development.picture->exposure);
    put_number(view, "luminance_p995", development.picture->luminance_p995);
    put_number(view, "clipped_fraction", development.picture->clipped_fraction);
    object["view"] = view;
  }
  if (receipt.scan && receipt.scan->outcome.last_line_at && development.rendered_at) {
    put_number(timings, "last_line_to_picture_s",
               seconds(*development.rendered_at - *receipt.scan->outcome.last_line_at));
  }
  object["timings"] = timings;
  if (development.live) object["provisional"] = live_to_json(*development.live);
}

// The stage's error along the motion: on which coordinate it depends, and how large it is.
ordered_json line_error_to_json(const LineError& line) {
  if (line.none()) return nullptr;
  double sum = 0;
  Vec2 low{1e9, 1e9}, high{-1e9, -1e9};
  int n = 0;
  const double extent = (static_cast<double>(line.coefficients.size()) - 3) * line.spacing_px;
  for (double at = 0; at <= extent; at += line.spacing_px / 4, ++n) {
    const Vec2 e = line.at_position(at);
    sum += dot(e, e);
    low = {std::min(low.x, e.x), std::min(low.y, e.y)};
    high = {std::max(high.x, e.x), std::max(high.y, e.y)};
  }
  return {{"depends_on", line.axis == LineError::Axis::kColumns ? "x" : "y"},
          {"rms_px", number_or_null(std::sqrt(sum / std::max(n, 1)))},
          {"peak_to_peak_x_px", number_or_null(high.x - low.x)},
          {"peak_to_peak_y_px", number_or_null(high.y - low.y)}};
}

}  // namespace

ordered_json registration_to_json(const Registration& r) {
  ordered_json object = {{"found", r.found}, {"screen", r.screen}};
  put_number(object, "confidence", r.confidence);
  put_number(object, "probability", r.screen_probability);
  put_number(object, "none_probability", r.none_probability);
  if (r.runner_up.empty()) {
    put_missing(object, "runner_up", "nothing came near");
  } else {
    object["runner_up"] = {{"screen", r.runner_up},
                           {"probability", number_or_null(r.runner_up_probability)}};
  }
  if (!r.printing.empty()) {
    object["printing"] = {{"screen", r.printing},
                          {"probability", number_or_null(r.printing_probability)}};
  }
  put_number(object, "explained", r.explained);
  if (r.found) object["identity"] = r.identity;
  if (!r.found) {
    object["reason"] = r.reason;
    for (const char* key :
         {"lattice_cy_per_px", "residual_px", "angle_deg", "period_px", "period_um", "mirrored"}) {
      put_missing(object, key, "no réseau was found");
    }
  } else {
    ordered_json lattice = ordered_json::array();
    for (const Vec2& f : r.lattice_cy_per_px) {
      lattice.push_back({number_or_null(f.x), number_or_null(f.y)});
    }
    object["lattice_cy_per_px"] = lattice;
    put_number(object, "residual_px", r.residual_px);
    if (r.left_out_px) {
      // Of lines alone u is not measured.
      object["left_out_px"] = {
          r.lines_alone ? nlohmann::ordered_json() : number_or_null(r.left_out_px->x),
          number_or_null(r.left_out_px->y)};
    }
    put_number(object, "uncertainty_px", r.uncertainty.rms_px());
    put_number(object, "angle_deg", r.angle_deg);
    put_number(object, "angle_sd_deg", r.angle_sd_deg);
    object["period_px"] = {number_or_null(r.period_px[0]), number_or_null(r.period_px[1])};
    object["period_sd_px"] = {number_or_null(r.period_sd_px[0]), number_or_null(r.period_sd_px[1])};
    if (r.period_um[1] > 0) {
      // Of lines alone the first direction has no period: null, and no lines.
      const double um = r.lines_alone ? std::numeric_limits<double>::infinity() : r.period_um[0];
      object["period_um"] = {number_or_null(um), number_or_null(r.period_um[1])};
      object["lines_per_mm"] = {number_or_null(1000 / um), number_or_null(1000 / r.period_um[1])};
    } else {
      put_missing(object, "period_um", "the scan does not say its resolution");
    }
    if (r.mirrored) {
      object["mirrored"] = *r.mirrored;
    } else {
      put_missing(object, "mirrored",
                  r.lines_alone ? "lines alone look the same mirrored and turned by 180 degrees"
                                : "the pattern is symmetric and cannot tell");
    }
    object["affine"] = r.map.is_affine();
    object["line_error"] = line_error_to_json(r.map.line_error());
  }
  object["windows"] = r.n_windows;
  object["outliers"] = r.n_outliers;
  return object;
}

ordered_json receipt_to_json(const Receipt& receipt) {
  ordered_json object = {{"schema", "reseau-receipt/1"},
                         {"program", {{"name", "reseau"}, {"version", RESEAU_VERSION}}},
                         {"verb", receipt.verb},
                         {"written_at_utc", receipt.written_at},
                         {"device", device_to_json(receipt.input.context)},
                         {"input", input_to_json(receipt.input)}};
  if (receipt.scan) object["scan"] = scan_to_json(*receipt.scan);
  if (receipt.development) object["settings"] = settings_to_json(receipt);
  add_development(object, receipt);
  ordered_json files = ordered_json::array();
  for (const ReceiptFile& file : receipt.files) {
    const bool known =
        file.role == "reconstruction" && receipt.development && receipt.development->picture;
    files.push_back(
        {{"role", file.role},
         {"name", file.path.filename().string()},
         {"bytes", std::filesystem::file_size(file.path)},
         {"sha256", known ? receipt.development->picture->exr_sha256 : sha256_of_file(file.path)}});
  }
  object["files"] = files;
  object["notes"] = receipt.notes;
  return object;
}

void write_json_file(const ordered_json& object, const std::filesystem::path& path) {
  const std::string text =
      object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  file.write_at(0, std::as_bytes(std::span(text)));
  file.publish();
}

}  // namespace reseau
