#include "capture/cli/calibrate_gate.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "capture/cli/calibrate_run.h"
#include "capture/image/linear_picture.h"
#include "capture/session/json_number.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;
constexpr int kMostGateLines = 256;

void put_measured(Json& to, const std::string& key, const std::optional<Measured>& m,
                  const char* why) {
  if (m) {
    put_number(to, key, m->value);
    put_number(to, key + "_sd", m->sd);
  } else {
    put_missing(to, key, why);
  }
}

Json gate_channel_json(const GateChannel& channel) {
  Json out = Json::object();
  put_measured(out, "dark_level", channel.dark, "needs two known exposures");
  if (channel.noise) {
    Json noise = Json::object();
    put_number(noise, "read_variance", channel.noise->read);
    put_number(noise, "shot_variance_per_level", channel.noise->shot);
    noise["covariance"] = {
        {number_or_null(channel.noise->read_variance), number_or_null(channel.noise->covariance)},
        {number_or_null(channel.noise->covariance), number_or_null(channel.noise->shot_variance)}};
    out["noise"] = noise;
  } else {
    put_missing(out, "noise", "needs two levels");
  }
  if (!channel.flat_gain.empty()) {
    out["flat_pixels"] = channel.flat_gain.size();
    put_number(out, "flat_gain_sd", channel.flat_gain_sd);
  }
  if (channel.shading) put_number(out, "shading", *channel.shading);
  if (channel.pixel_rms) put_number(out, "pixel_gain_rms", *channel.pixel_rms);
  if (channel.lamp_rms) put_number(out, "lamp_rms", *channel.lamp_rms);
  Json lines = Json::array();
  for (const Measured& gain : channel.line_gains) {
    lines.push_back({{"gain", number_or_null(gain.value)}, {"sd", number_or_null(gain.sd)}});
  }
  out["line_gains"] = lines;
  put_measured(out, "nonlinearity", channel.nonlinearity, "needs three known exposures");
  Json leakage = Json::object();
  for (std::size_t k = 0; k < channel.leakage.size(); ++k) {
    if (!channel.leakage[k]) continue;
    leakage[kProfileChannelNames[k]] = {{"share", number_or_null(channel.leakage[k]->value)},
                                        {"sd", number_or_null(channel.leakage[k]->sd)}};
  }
  out["leakage_from"] = leakage;
  Json levels = Json::array();
  for (const GateLevel& level : channel.levels) {
    levels.push_back({{"exposure_us", level.exposure_us ? Json(*level.exposure_us) : Json(nullptr)},
                      {"level", number_or_null(level.level)},
                      {"level_sd", number_or_null(level.level_sd)},
                      {"variance", number_or_null(level.variance)},
                      {"variance_sd", number_or_null(level.variance_sd)},
                      {"clipped", level.clipped}});
  }
  out["levels"] = levels;
  return out;
}

}  // namespace

GateScan read_gate(const std::filesystem::path& path, const ReadScanOptions& read,
                   CaptureContext& context, double& dpi, Reporter& reporter) {
  const LinearPicture picture(path, read);
  for (const std::string& note : picture.notes()) reporter.note(note);
  context = picture.context();
  dpi = picture.dpi();
  GateScan out;
  out.width_px = picture.width_px();
  out.n_lines = std::min(kMostGateLines, picture.height_px());
  out.exposure_us = context.exposure_us;
  const PixelRect middle{0, (picture.height_px() - out.n_lines) / 2, out.width_px, out.n_lines};
  for (std::size_t c = 0; c < picture.channels().size(); ++c) {
    if (const auto at = profile_channel(picture.channels()[c])) {
      out.light[*at] = picture.plane(c, middle);
    }
  }
  return out;
}

void put_gate(const GateResult& gate, Profile& profile) {
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    const GateChannel& channel = gate.channels[c];
    if (channel.levels.empty()) continue;
    GateRecord record;
    if (channel.dark) {
      // A level a hair below zero is zero with noise.
      profile.dark_level[c] = std::max(0.0, channel.dark->value);
      record.dark_level_sd = channel.dark->sd;
    }
    if (channel.noise) {
      profile.noise[c] = NoiseModel{channel.noise->read, channel.noise->shot};
      record.noise_covariance = {channel.noise->read_variance, channel.noise->covariance,
                                 channel.noise->shot_variance};
    }
    if (!channel.flat_gain.empty()) {
      profile.flat_gain[c] = channel.flat_gain;
      record.flat_gain_sd = channel.flat_gain_sd;
    }
    record.shading = channel.shading;
    record.pixel_gain_rms = channel.pixel_rms;
    record.lamp_rms = channel.lamp_rms;
    record.line_gains = channel.line_gains;
    record.nonlinearity = channel.nonlinearity;
    record.leakage = channel.leakage;
    profile.gate[c] = std::move(record);
  }
}

Json gate_to_json(const GateResult& gate) {
  Json out = Json::object();
  out["units"] = "levels of full scale (1 = 65535), variances of its square";
  Json channels = Json::object();
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    if (gate.channels[c].levels.empty()) continue;
    channels[kProfileChannelNames[c]] = gate_channel_json(gate.channels[c]);
  }
  out["channels"] = channels;
  out["remarks"] = gate.remarks;
  return out;
}

std::string describe(const GateResult& gate) {
  std::string text = "Open frame, of full scale\n";
  for (std::size_t c = 0; c < gate.channels.size(); ++c) {
    const GateChannel& channel = gate.channels[c];
    if (channel.levels.empty()) continue;
    text += fmt::format("  {:<9}", kProfileChannelNames[c]);
    if (channel.dark) {
      text += fmt::format(" dark {:.6f} ± {:.6f};", channel.dark->value, channel.dark->sd);
    }
    if (channel.noise) {
      text += fmt::format(" noise {:.5f} in the dark, {:.5f} at half scale;",
                          std::sqrt(channel.noise->read),
                          std::sqrt(channel.noise->read + 0.5 * channel.noise->shot));
    }
    if (channel.shading) text += fmt::format(" shading {:.2f} %;", 100 * *channel.shading);
    if (channel.pixel_rms) text += fmt::format(" pixels {:.3f} % rms;", 100 * *channel.pixel_rms);
    for (const Measured& gain : channel.line_gains) {
      text += fmt::format(" line gain {:.5f} ± {:.5f};", gain.value, gain.sd);
    }
    if (channel.nonlinearity) {
      text += fmt::format(" straight to {:.5f};", channel.nonlinearity->value);
    }
    if (c != 3 && channel.leakage[3]) {
      text += fmt::format(" from infrared {:.4f} ± {:.4f} %;", 100 * channel.leakage[3]->value,
                          100 * channel.leakage[3]->sd);
    }
    text.back() = '\n';
  }
  for (const std::string& remark : gate.remarks) text += "  " + remark + "\n";
  text.pop_back();
  return text;
}

}  // namespace reseau::cli
