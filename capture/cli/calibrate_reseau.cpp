#include "capture/cli/calibrate_reseau.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "capture/cli/develop_choice.h"
#include "capture/cli/read_choice.h"
#include "capture/session/json_number.h"
#include "capture/session/offsets_json.h"
#include "core/reconstruct/channel_registration.h"

namespace reseau::cli {
namespace {

constexpr std::array<std::size_t, 3> kOtherChannels{0, 2, 3};

std::string offset_line(const char* channel, Vec2 at, Vec2 sd) {
  return fmt::format(
      "{:<9} from green: {:+.4f} ± {:.4f} px along the sensor, {:+.4f} ± {:.4f} px along the "
      "motion",
      channel, at.x, sd.x, at.y, sd.y);
}

}  // namespace

bool ReseauOfFile::measured() const {
  return std::ranges::any_of(offsets.from_green, [](const auto& o) { return o.has_value(); });
}

std::optional<ReseauOfFile> measure_reseau(const std::filesystem::path& path,
                                           const MeasureChoice& choice, Work& work) {
  ReadChoice read;
  read.file = path.string();
  read.gamma = choice.read.gamma;
  read.infrared_file = choice.read.infrared_file;
  const Scan scan = read.read(work.reporter);
  ReseauOfFile out{path, scan.context, scan.source->format().x_dpi, {}, {}};
  RegisterOptions options;
  options.tone = scan.tone;
  const DevelopProgress progress =
      develop_progress(work.reporter, false, scan.source->format().n_lines);
  out.registration = register_screen(
      *scan.source, options, [&](double done) { progress(DevelopPhase::kRegister, done); },
      work.signals.stop());
  if (work.signals.stop().stop_requested()) return std::nullopt;
  if (out.registration.found) {
    out.offsets =
        measure_channel_offsets(*scan.source, out.registration, scan.tone, work.signals.stop());
  } else {
    for (const std::size_t c : kOtherChannels) out.offsets.reason[c] = out.registration.reason;
  }
  if (work.signals.stop().stop_requested()) return std::nullopt;
  return out;
}

nlohmann::ordered_json reseau_to_json(const ReseauOfFile& file) {
  nlohmann::ordered_json out = {{"file", file.path.string()},
                                {"found", file.registration.found},
                                {"screen", file.registration.screen}};
  if (file.registration.found) put_number(out, "residual_px", file.registration.residual_px);
  out["channels_from_green"] = channel_offsets_to_json(file.offsets);
  return out;
}

std::string describe(const ReseauOfFile& file) {
  std::string text = fmt::format("{}\n  réseau {}, {} tiles\n", file.path.string(),
                                 file.registration.found ? file.registration.screen : "not found",
                                 file.offsets.tiles);
  for (const std::size_t c : kOtherChannels) {
    const auto& at = file.offsets.from_green[c];
    text +=
        at ? fmt::format("  {}\n", offset_line(kProfileChannelNames[c], at->at_px, at->sd_px))
           : fmt::format("  {:<9} not told: {}\n", kProfileChannelNames[c], file.offsets.reason[c]);
  }
  text.pop_back();
  return text;
}

void put_reseau(const ReseauOfFile& file, Profile& profile) {
  for (const std::size_t c : kOtherChannels) {
    const auto& at = file.offsets.from_green[c];
    if (!at) continue;
    const auto& sd = profile.offset_sd_px[c];
    if (profile.offset_from_green_px[c] && sd && std::hypot(sd->x_px, sd->y_px) < norm(at->sd_px)) {
      continue;
    }
    profile.offset_from_green_px[c] = at->at_px;
    profile.offset_sd_px[c] = OffsetSd{at->sd_px.x, at->sd_px.y};
  }
}

void report_offsets(const Profile& profile, Reporter& reporter, nlohmann::ordered_json& result) {
  nlohmann::ordered_json offsets = nlohmann::ordered_json::object();
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    const auto& at = profile.offset_from_green_px[c];
    const auto& sd = profile.offset_sd_px[c];
    if (!at || !sd) continue;
    offsets[kProfileChannelNames[c]] = {
        {"x_px", at->x}, {"y_px", at->y}, {"x_sd_px", sd->x_px}, {"y_sd_px", sd->y_px}};
    reporter.result_line(offset_line(kProfileChannelNames[c], *at, {sd->x_px, sd->y_px}));
  }
  if (!offsets.empty()) result["offset_from_green"] = offsets;
}

}  // namespace reseau::cli
