#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/profile/profile_io.h"
#include "capture/cli/calibrate_psf.h"
#include "capture/cli/calibrate_report.h"
#include "capture/cli/calibrate_run.h"
#include "capture/cli/develop_choice.h"
#include "capture/cli/pixel_area.h"
#include "capture/cli/verbs.h"
#include "capture/cli/write_text.h"
#include "core/base/error.h"

namespace reseau::cli {

namespace {

struct CalibrateArguments {
  std::vector<std::string> files;
  std::string roi, infrared_file, profile, model, serial, report;
  std::optional<double> gamma;
  double window_px = 28, dpi = 0;
  bool save = false, compare = false, psf = false;
};

PixelRect parse_roi(const std::string& text) {
  const auto [x, y, width, height] = parse_pixel_area("--roi", text);
  return {x, y, width, height};
}

// What the files say of the unit, or the person where they do not.
Profile unit_of(const std::vector<MeasuredFile>& files, const CalibrateArguments& options) {
  Profile profile = profile_of(files);
  if (!options.model.empty()) profile.model = options.model;
  if (!options.serial.empty()) profile.serial = options.serial;
  if (options.dpi > 0) profile.resolution_dpi = options.dpi;
  profile.measured_at_utc = utc_now(false);
  return profile;
}

// The profile of this unit that is kept, held against the new one, as sentences and JSON.
void compare_with_kept(const Profile& now, Reporter& reporter, nlohmann::ordered_json& result) {
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
  nlohmann::ordered_json compared = {{"path", search.found->path.string()},
                                     {"measured_at_utc", kept.measured_at_utc}};
  CaptureContext context;
  context.make = now.make;
  context.model = now.model;
  context.serial = now.serial;
  context.firmware = now.firmware;
  context.holder = now.holder;
  compared["mismatches"] = mismatches(kept, context, now.resolution_dpi);
  nlohmann::ordered_json channels = nlohmann::ordered_json::object();
  reporter.result_line(fmt::format("Against the calibration of {}:", kept.measured_at_utc));
  for (std::size_t c = 0; c < kProfileChannels; ++c) {
    if (!now.psf[c] || !kept.psf[c]) continue;
    const double change = now.psf[c]->sigma_px / kept.psf[c]->sigma_px - 1;
    const double sd = std::hypot(now.psf[c]->sd_px, kept.psf[c]->sd_px) / kept.psf[c]->sigma_px;
    channels[kProfileChannelNames[c]] = {{"width_change", change}, {"width_change_sd", sd}};
    reporter.result_line(fmt::format("  {:<9} width {:+.2f} % ± {:.2f} %{}",
                                     kProfileChannelNames[c], 100 * change, 100 * sd,
                                     std::abs(change) > 3 * sd ? ", changed" : ""));
  }
  compared["channels"] = channels;
  result["compared_with"] = compared;
}

ExitCode run_calibrate(const CalibrateArguments& options, Work& work) {
  Reporter& reporter = work.reporter;
  MeasureChoice choice;
  as_failure(Doing::kReadingOptions, [&] {
    if (!options.roi.empty()) choice.roi = parse_roi(options.roi);
    if (choice.roi && options.files.size() > 1) {
      throw InputError("--roi is a region of one file; give one file with it.");
    }
  });
  if (!options.report.empty()) refuse_existing(options.report);
  choice.read.gamma = options.gamma;
  choice.read.infrared_file = options.infrared_file;
  choice.window_px = options.window_px;
  std::vector<MeasuredFile> files;
  bool any = false;
  for (const std::string& path : options.files) {
    if (work.signals.stop().stop_requested()) return kExitCancelled;
    files.push_back(
        as_failure(Doing::kReadingInput, [&] { return measure_file(path, choice, reporter); }));
    any = any || files.back().edges.front().measured();
  }
  nlohmann::ordered_json result;
  if (files.size() == 1) {
    result = file_to_json(files.front());
  } else {
    result = {{"schema", "reseau-calibration/1"}};
    for (const MeasuredFile& file : files) result["files"].push_back(file_to_json(file));
  }
  for (const MeasuredFile& file : files) reporter.result_line(describe(file));
  std::optional<PsfFit> psf;
  if (any && (options.psf || !options.report.empty())) {
    psf = fit_psf(psf_edges(files));
    result["psf"] = psf_to_json(*psf);
    reporter.result_line(describe(*psf));
  }
  if (!options.report.empty()) {
    std::optional<Profile> unit;
    if (any) unit = unit_of(files, options);
    write_text(
        options.report,
        calibration_html({files, psf ? &*psf : nullptr, unit ? &*unit : nullptr, utc_now(false)}),
        reporter);
    result["report"] = options.report;
  }
  if (any && (options.save || options.compare || !options.profile.empty())) {
    const Profile profile = unit_of(files, options);
    as_failure(Doing::kReadingInput, [&] {
      if (profile.model.empty()) {
        throw InputError(
            "The files do not say which scanner made them; give --model, and --serial "
            "if there is one.");
      }
      if (!(profile.resolution_dpi > 0)) {
        throw InputError("The files do not say their resolution; give --dpi.");
      }
      validate(profile);
    });
    if (options.compare) compare_with_kept(profile, reporter, result);
    if (options.save || !options.profile.empty()) {
      const std::filesystem::path path = options.profile.empty()
                                             ? profile_path(default_profile_directory(), profile)
                                             : std::filesystem::path(options.profile);
      as_failure(Doing::kWriting, [&] { save_profile(profile, path); });
      result["profile"] = path.string();
      reporter.result_line(fmt::format("Kept as {}", path.string()));
    }
  }
  reporter.result_json(result);
  if (!any) {
    reporter.warning("No edge could be measured; the reasons stand beside each channel.");
    return kExitInput;
  }
  return kExitOk;
}

}  // namespace

void add_calibrate(Program& program) {
  auto options = std::make_shared<CalibrateArguments>();
  CLI::App* app = program.add_verb(
      "calibrate",
      "Measures how sharp a scanner is from slanted edges (a razor blade, a slit) in its scans: "
      "modulation\ntransfer of every channel with its uncertainty, or the reasons why there is "
      "none. Without --roi the\nedges are sought. No edge: exit code 65.",
      "reseau calibrate razor.tif --roi 120,80,172,100 --json\n"
      "reseau calibrate razor-a.tif razor-b.tif --report razor.html --save --model 'LS-9000 ED' "
      "--dpi 4000",
      [options](Work& work) { return run_calibrate(*options, work); });
  app->add_option("FILES", options->files, "Scans of edges: TIFF (8, 16 bit, float) or EXR")
      ->required();
  app->add_option("--roi", options->roi, "The region of the edge, x,y,width,height in pixels");
  app->add_option("--gamma", options->gamma,
                  "Encoding gamma of the samples; overrides an embedded profile")
      ->group("Scan");
  app->add_option("--infrared-file", options->infrared_file,
                  "A TIFF with the infrared, instead of what is in or beside the scan")
      ->group("Scan");
  app->add_option("--window", options->window_px,
                  "Half width of the windowed curve that is told beside the whole one (28 px)")
      ->check(CLI::Range(2.0, 80.0));
  app->add_flag(
      "--psf", options->psf,
      "Fit lens, aperture, blur and halo to all edges together: what the scanner shares,\n"
      "best focus per channel from three focus settings or more, what cannot be told");
  app->add_option("--report", options->report,
                  "Write tables and plots as one HTML file; implies --psf");
  app->add_flag("--save", options->save,
                "Keep the result as the calibration of this unit, for later scans")
      ->group("Profile");
  app->add_option("--profile", options->profile, "Write the calibration to this file")
      ->group("Profile");
  app->add_flag("--compare", options->compare,
                "Hold the result against the calibration that is kept")
      ->group("Profile");
  app->add_option("--model", options->model, "The scanner, where the files do not say")
      ->group("Profile");
  app->add_option("--serial", options->serial, "Its serial number, where the files do not say")
      ->group("Profile");
  app->add_option("--dpi", options->dpi, "The resolution, where the files do not say")
      ->group("Profile");
  program.prints_own_json(app);
}

}  // namespace reseau::cli
