#include "capture/cli/calibrate_compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/profile/profile_io.h"
#include "capture/session/json_number.h"

namespace reseau::cli {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kChanged = 3;  // standard deviations

struct Change {
  std::string key, what, unit;
  double now = 0, earlier = 0;
  double change = 0, sd = 0;  // relative where `unit` is "%"
};

bool has_changed(const Change& c) { return c.sd > 0 && std::abs(c.change) > kChanged * c.sd; }

Change relative(const char* key, const char* what, Measured now, Measured earlier) {
  return {key,
          what,
          "%",
          now.value,
          earlier.value,
          now.value / earlier.value - 1,
          std::hypot(now.sd, earlier.sd) / std::abs(earlier.value)};
}

Change absolute(const char* key, const char* what, const char* unit, Measured now,
                Measured earlier) {
  return {key,
          what,
          unit,
          now.value,
          earlier.value,
          now.value - earlier.value,
          std::hypot(now.sd, earlier.sd)};
}

// Where two curves lie farthest apart, in deviations.
void compare_curves(const std::vector<TransferPoint>& now,
                    const std::vector<TransferPoint>& earlier, std::vector<Change>& out) {
  const Change* worst = nullptr;
  Change best;
  for (const TransferPoint& a : now) {
    const auto b = std::ranges::find_if(earlier, [&](const TransferPoint& p) {
      return std::abs(p.f_cy_per_px - a.f_cy_per_px) < 1e-6;
    });
    if (b == earlier.end() || !(a.sd > 0) || !(a.f_cy_per_px > 0)) continue;
    Change c = absolute("largest_transfer_change", "", "", {a.value, a.sd}, {b->value, b->sd});
    c.what = fmt::format("modulation at {:.2f} cycles/pixel", a.f_cy_per_px);
    if (worst == nullptr || std::abs(c.change) / c.sd > std::abs(best.change) / best.sd) {
      best = c;
      worst = &best;
    }
  }
  if (worst != nullptr) out.push_back(best);
}

std::vector<Change> changes_of(const Profile& now, const Profile& earlier, std::size_t c) {
  std::vector<Change> out;
  if (now.psf[c] && earlier.psf[c]) {
    out.push_back(relative("width", "width of the blur", {now.psf[c]->sigma_px, now.psf[c]->sd_px},
                           {earlier.psf[c]->sigma_px, earlier.psf[c]->sd_px}));
  }
  compare_curves(now.transfer[c], earlier.transfer[c], out);
  const auto& gate = now.gate[c];
  const auto& gate_earlier = earlier.gate[c];
  if (now.dark_level[c] && earlier.dark_level[c] && gate && gate_earlier && gate->dark_level_sd &&
      gate_earlier->dark_level_sd) {
    out.push_back(absolute("dark_level", "dark level", "of full scale",
                           {*now.dark_level[c], *gate->dark_level_sd},
                           {*earlier.dark_level[c], *gate_earlier->dark_level_sd}));
  }
  if (now.noise[c] && earlier.noise[c] && gate && gate_earlier && gate->noise_covariance &&
      gate_earlier->noise_covariance) {
    const auto at_half = [](const NoiseModel& noise, const std::array<double, 3>& v) {
      return Measured{noise.a + 0.5 * noise.b, std::sqrt(std::max(0.0, v[0] + v[1] + 0.25 * v[2]))};
    };
    out.push_back(relative("noise_variance", "noise at half scale",
                           at_half(*now.noise[c], *gate->noise_covariance),
                           at_half(*earlier.noise[c], *gate_earlier->noise_covariance)));
  }
  const std::vector<double>&flat = now.flat_gain[c], &flat_earlier = earlier.flat_gain[c];
  if (!flat.empty() && flat.size() == flat_earlier.size() && gate && gate_earlier &&
      gate->flat_gain_sd && gate_earlier->flat_gain_sd) {
    double most = 0;
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const double d = flat[i] / flat_earlier[i] - 1;
      if (std::abs(d) > std::abs(most)) most = d;
    }
    Change change =
        absolute("flat_field", "flat field, at its worst pixel", "", {1 + most, 0}, {1, 0});
    // The worst of many pixels lies some deviations away by chance alone.
    const double by_chance = std::sqrt(2 * std::log(static_cast<double>(flat.size()) + 1)) / 2;
    change.sd = by_chance * std::hypot(*gate->flat_gain_sd, *gate_earlier->flat_gain_sd);
    out.push_back(change);
  }
  if (now.focus[c] && earlier.focus[c]) {
    out.push_back(absolute("best_focus", "best focus", "steps", now.focus[c]->best_steps,
                           earlier.focus[c]->best_steps));
  }
  return out;
}

}  // namespace

Json compare_profiles(const Profile& now, const Profile& earlier, Reporter& reporter) {
  Json out = Json::object();
  out["measured_at_utc"] = {now.measured_at_utc, earlier.measured_at_utc};
  CaptureContext context;
  context.make = now.make;
  context.model = now.model;
  context.serial = now.serial;
  context.firmware = now.firmware;
  context.holder = now.holder;
  const std::vector<std::string> apart = mismatches(earlier, context, now.resolution_dpi);
  out["mismatches"] = apart;
  for (const std::string& sentence : apart) reporter.warning(sentence);
  bool any = false;
  Json channels = Json::object();
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    Json one = Json::object();
    for (const Change& change : changes_of(now, earlier, c)) {
      const bool changed = has_changed(change);
      any = any || changed;
      Json entry = Json::object();
      put_number(entry, "now", change.now);
      put_number(entry, "earlier", change.earlier);
      put_number(entry, "change", change.change);
      put_number(entry, "change_sd", change.sd);
      entry["relative"] = change.unit == "%";
      entry["changed"] = changed;
      if (change.key == "width") {
        put_number(one, "width_change", change.change);
        put_number(one, "width_change_sd", change.sd);
      }
      one[change.key] = entry;
      const double scale = change.unit == "%" ? 100 : 1;
      reporter.result_line(fmt::format("  {:<9} {}: {:+.4g} ± {:.2g}{}{}{}",
                                       kProfileChannelNames[c], change.what, scale * change.change,
                                       scale * change.sd, change.unit.empty() ? "" : " ",
                                       change.unit, changed ? ", changed" : ""));
    }
    if (!one.empty()) channels[kProfileChannelNames[c]] = one;
  }
  out["channels"] = channels;
  out["changed"] = any;
  return out;
}

void compare_with_kept(const Profile& now, Reporter& reporter, Json& result) {
  const ProfileSearch search =
      find_profile(default_profile_directory(), now.model, now.serial, now.resolution_dpi);
  for (const std::string& problem : search.problems) reporter.warning(problem);
  if (!search.found) {
    reporter.warning(fmt::format("There is no earlier calibration of '{}' with serial number '{}'.",
                                 now.model, now.serial));
    result["compared_with"] = nullptr;
    return;
  }
  const Profile& kept = search.found->profile;
  reporter.result_line(fmt::format("Against the calibration of {}:", kept.measured_at_utc));
  Json compared = {{"path", search.found->path.string()},
                   {"measured_at_utc", kept.measured_at_utc}};
  compared.update(compare_profiles(now, kept, reporter));
  compared["measured_at_utc"] = kept.measured_at_utc;
  result["compared_with"] = compared;
}

Json compare_files(const std::filesystem::path& now, const std::filesystem::path& earlier,
                   Reporter& reporter) {
  const Profile a = load_profile(now), b = load_profile(earlier);
  reporter.result_line(fmt::format("{} against {}:", now.string(), earlier.string()));
  Json out = {{"schema", "reseau-calibration-comparison/1"},
              {"now", now.string()},
              {"earlier", earlier.string()}};
  out.update(compare_profiles(a, b, reporter));
  return out;
}

}  // namespace reseau::cli
