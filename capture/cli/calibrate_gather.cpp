#include "capture/cli/calibrate_gather.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "capture/cli/calibrate_gate.h"
#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"

namespace reseau::cli {
namespace {

// What the person says of the unit.
Profile with_names(Profile profile, const CalibrateArguments& options) {
  if (!options.model.empty()) profile.model = options.model;
  if (!options.serial.empty()) profile.serial = options.serial;
  if (options.dpi > 0) profile.resolution_dpi = options.dpi;
  profile.measured_at_utc = utc_now(false);
  return profile;
}

// What the files say of the unit, or the person where they do not.
Profile unit_of(const std::vector<MeasuredFile>& files, const CalibrateArguments& options) {
  return with_names(profile_of(files), options);
}

// The same where there is no edge.
Profile unit_of(const CaptureContext& context, double dpi, const std::string& file,
                const char* method, const CalibrateArguments& options) {
  Profile profile;
  profile.make = context.make;
  profile.model = context.model;
  profile.serial = context.serial;
  profile.firmware = context.firmware;
  profile.holder = context.holder;
  profile.resolution_dpi = dpi;
  profile.source_file = std::filesystem::path(file).filename().string();
  profile.tool_version = RESEAU_VERSION;
  profile.method = method;
  return with_names(std::move(profile), options);
}

}  // namespace

bool gather_files(const CalibrateArguments& options, const MeasureChoice& choice, Work& work,
                  Gathered& out) {
  for (const std::string& path : options.files) {
    if (work.signals.stop().stop_requested()) return false;
    out.files.push_back(as_failure(Doing::kReadingInput,
                                   [&] { return measure_file(path, choice, work.reporter); }));
  }
  out.focus = focus_shots(out.files);
  for (const std::string& path : options.gate) {
    if (work.signals.stop().stop_requested()) return false;
    CaptureContext context;
    double dpi = 0;
    out.gate.push_back(as_failure(Doing::kReadingInput, [&] {
      return read_gate(path, choice.read, context, dpi, work.reporter);
    }));
    if (out.gate.size() > 1) continue;
    out.gate_context = context;
    out.gate_dpi = dpi;
  }
  const TargetName target =
      as_failure(Doing::kReadingOptions, [&] { return parse_target(options.target); });
  for (const std::string& path : options.random) {
    if (work.signals.stop().stop_requested()) return false;
    // A region is that of the one file it is given with.
    MeasureChoice of_target = choice;
    if (!options.files.empty()) of_target.roi.reset();
    out.random.push_back(as_failure(Doing::kReadingInput, [&] {
      return measure_random_file(path, target, options.dpi, of_target, work.reporter);
    }));
  }
  for (const std::string& path : options.reseau) {
    auto one = as_failure(Doing::kReadingInput, [&] { return measure_reseau(path, choice, work); });
    if (!one) return false;
    out.reseau.push_back(std::move(*one));
  }
  return true;
}

std::optional<Profile> profile_from(const Gathered& all, bool any_edge, bool gate,
                                    const CalibrateArguments& options) {
  std::optional<Profile> out;
  const auto random = std::ranges::find_if(all.random, &RandomOfFile::measured);
  const auto reseau = std::ranges::find_if(all.reseau, &ReseauOfFile::measured);
  if (any_edge) {
    out = unit_of(all.files, options);
  } else if (gate) {
    out = unit_of(all.gate_context, all.gate_dpi, options.gate.empty() ? "" : options.gate.front(),
                  "open frame", options);
  } else if (random != all.random.end()) {
    out = unit_of(random->context, random->dpi, random->path.string(), "random target", options);
  } else if (reseau != all.reseau.end()) {
    out = unit_of(reseau->context, reseau->dpi, reseau->path.string(), "réseau", options);
  }
  for (const ReseauOfFile& file : all.reseau) {
    if (out && file.measured()) put_reseau(file, *out);
  }
  for (const RandomOfFile& file : all.random) {
    if (out && file.measured()) put_random(file, *out);
  }
  return out;
}

}  // namespace reseau::cli
