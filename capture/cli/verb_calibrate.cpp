#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "calibration/profile/profile_io.h"
#include "capture/cli/calibrate_bench.h"
#include "capture/cli/calibrate_compare.h"
#include "capture/cli/calibrate_field.h"
#include "capture/cli/calibrate_focus.h"
#include "capture/cli/calibrate_gate.h"
#include "capture/cli/calibrate_gather.h"
#include "capture/cli/calibrate_psf.h"
#include "capture/cli/calibrate_random.h"
#include "capture/cli/calibrate_report.h"
#include "capture/cli/calibrate_reseau.h"
#include "capture/cli/calibrate_run.h"
#include "capture/cli/develop_choice.h"
#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"
#include "capture/cli/pixel_area.h"
#include "capture/cli/verbs.h"
#include "capture/cli/write_text.h"
#include "core/base/error.h"

namespace reseau::cli {

namespace {

PixelRect parse_roi(const std::string& text) {
  const auto [x, y, width, height] = parse_pixel_area("--roi", text);
  return {x, y, width, height};
}

bool is_profile(const std::string& path) {
  return std::filesystem::path(path).extension() == ".json";
}

// Profiles instead of scans: two against each other.
ExitCode run_compare(const CalibrateArguments& options, Work& work) {
  if (options.files.size() != 2 || !is_profile(options.files[0]) || !is_profile(options.files[1])) {
    throw Failure(kExitUsage, "Two calibrations are compared, or scans with the one that is kept.",
                  "Give 'calibrate --compare NOW.json EARLIER.json', or scans of edges.");
  }
  const nlohmann::ordered_json result = as_failure(Doing::kReadingInput, [&] {
    return compare_files(options.files[0], options.files[1], work.reporter);
  });
  work.reporter.result_json(result);
  return kExitOk;
}

void check_profile(const Profile& profile) {
  if (profile.model.empty()) {
    throw InputError(
        "The files do not say which scanner made them; give --model, and --serial if there is "
        "one.");
  }
  if (!(profile.resolution_dpi > 0)) {
    throw InputError("The files do not say their resolution; give --dpi.");
  }
  validate(profile);
}

ExitCode run_calibrate(const CalibrateArguments& options, Work& work) {
  Reporter& reporter = work.reporter;
  const bool profiles = std::ranges::any_of(options.files, is_profile);
  if (options.compare && profiles) return run_compare(options, work);
  // With neither scans nor an open frame to read, a scanner makes them.
  const bool bench = options.files.empty() && options.gate.empty() && options.random.empty() &&
                     options.reseau.empty();
  if (!bench && !options.bench.scan.device.empty()) {
    throw Failure(kExitUsage, "Files were given and a scanner.",
                  "Leave out the files to calibrate at the scanner, or --device to measure files.");
  }
  MeasureChoice choice;
  as_failure(Doing::kReadingOptions, [&] {
    if (!options.roi.empty()) choice.roi = parse_roi(options.roi);
    const std::size_t n = options.files.empty() ? options.random.size() : options.files.size();
    if (choice.roi && n != 1) {
      throw InputError("--roi is a region of one file; give one file with it.");
    }
  });
  if (!options.report.empty()) refuse_existing(options.report);
  choice.read.gamma = options.gamma;
  choice.read.infrared_file = options.infrared_file;
  choice.window_px = options.window_px;
  // How sharpness changes over the frame takes edges all over it.
  constexpr int kEdgesOfField = 40;
  if (options.psf || options.save || !options.report.empty() || !options.profile.empty()) {
    choice.most_edges = kEdgesOfField;
  }
  Gathered all;
  std::string report = options.report, device;
  if (bench) {
    auto done = run_bench(options.bench, choice, work);
    if (!done) return kExitCancelled;
    device = done->device;
    if (report.empty()) {
      report = std::filesystem::path(done->edge_file).replace_extension(".html").string();
    }
    all.files.push_back(std::move(done->edges));
    all.focus = std::move(done->focus);
    all.gate = std::move(done->gate);
    if (!done->random_file.empty()) {
      all.random.push_back(as_failure(Doing::kReadingInput, [&] {
        return measure_random_file(done->random_file, parse_target(options.target), options.dpi,
                                   choice, reporter);
      }));
    }
  } else if (!gather_files(options, choice, work, all)) {
    return kExitCancelled;
  }
  const bool any = std::ranges::any_of(all.files, [](const MeasuredFile& file) {
    return !file.edges.empty() && file.edges.front().measured();
  });

  nlohmann::ordered_json result;
  if (all.files.size() == 1) {
    result = file_to_json(all.files.front());
  } else {
    result = {{"schema", "reseau-calibration/1"}};
    for (const MeasuredFile& file : all.files) result["files"].push_back(file_to_json(file));
  }
  if (bench) result["device"] = device;
  for (const MeasuredFile& file : all.files) reporter.result_line(describe(file));
  std::optional<FocusResult> focus;
  if (!all.focus.empty()) focus = find_focus(all.focus);
  if (focus) {
    result["focus"] = focus_to_json(*focus);
    reporter.result_line(describe(*focus));
  }
  std::optional<GateResult> gate;
  if (!all.gate.empty()) {
    gate = measure_gate(all.gate);
    result["gate"] = gate_to_json(*gate);
    reporter.result_line(describe(*gate));
  }
  const std::vector<RandomAgainstEdge> pairs = against_edges(all.random, all.files);
  if (!all.random.empty()) {
    result["random"] = nlohmann::ordered_json::array();
    for (const RandomOfFile& file : all.random) {
      result["random"].push_back(random_to_json(file));
      reporter.result_line(describe(file));
    }
  }
  if (!pairs.empty()) {
    result["random_against_edges"] = against_to_json(pairs);
    reporter.result_line(describe(pairs));
  }
  for (const ReseauOfFile& file : all.reseau) {
    result["reseau"].push_back(reseau_to_json(file));
    reporter.result_line(describe(file));
  }
  const bool keep = bench || options.save || !options.profile.empty();
  std::optional<PsfFit> psf;
  std::optional<PsfFieldRecord> over_frame;
  PsfChoice psf_choice;
  if (any && (options.psf || keep || !report.empty())) {
    psf_choice = psf_edges(all.files);
    std::vector<PsfEdge> edges = psf_choice.edges;
    if (bench) add_psf_edges(all.focus, edges);
    const auto stop = [&] { return work.signals.stop().stop_requested(); };
    psf = fit_psf(edges, stop);
    if (psf->ok) {
      over_frame = field_of(all.files, bench ? all.focus : std::vector<FocusShot>{}, *psf, stop);
    }
    if (work.signals.stop().stop_requested()) return kExitCancelled;
    result["psf"] = psf_to_json(*psf);
    reporter.result_line(describe(*psf));
    if (over_frame) {
      result["psf_field"] = psf_field_to_json(*over_frame);
      reporter.result_line(describe(*over_frame));
    }
  }
  std::optional<Profile> profile = profile_from(all, any, gate.has_value(), options);
  if (profile) {
    report_offsets(*profile, reporter, result);
    if (psf) put_psf(*psf, psf_choice, all.files, *profile);
    if (profile->psf_model) {
      profile->psf_model->surfaces = over_frame;
      result["field"] = field_to_json(*profile->psf_model);
    }
    if (focus) put_focus(*focus, *profile);
    if (gate) put_gate(*gate, *profile);
  }
  if (!report.empty()) {
    write_text(report,
               calibration_html(
                   {all.files, psf ? &*psf : nullptr, &psf_choice, profile ? &*profile : nullptr,
                    focus ? &*focus : nullptr, gate ? &*gate : nullptr,
                    all.random.empty() ? nullptr : &all.random, &pairs, utc_now(false)}),
               reporter);
    result["report"] = report;
  }
  const bool spread = std::ranges::any_of(all.random, &RandomOfFile::measured);
  const bool lies = std::ranges::any_of(all.reseau, &ReseauOfFile::measured);
  const bool useful = any || ((gate || spread || lies) && all.files.empty());
  if (profile && useful && (keep || options.compare)) {
    as_failure(Doing::kReadingInput, [&] { check_profile(*profile); });
    if (options.compare) compare_with_kept(*profile, reporter, result);
    if (keep) {
      const std::filesystem::path path = options.profile.empty()
                                             ? profile_path(default_profile_directory(), *profile)
                                             : std::filesystem::path(options.profile);
      as_failure(Doing::kWriting, [&] { save_profile(*profile, path); });
      result["profile"] = path.string();
      reporter.result_line(fmt::format("Kept as {}", path.string()));
    }
  }
  reporter.result_json(result);
  if (!useful) {
    reporter.warning("Nothing could be measured; the reasons stand beside each channel.");
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
      "none. Without --roi the\nedges are sought. No edge: exit code 65. Without FILES a scanner "
      "makes the scans: the edge, other\nfocus settings, an open frame; the calibration is kept, a "
      "report written.",
      "reseau calibrate razor.tif --roi 120,80,172,100 --json\n"
      "reseau calibrate razor-a.tif razor-b.tif --report razor.html --save --model 'LS-9000 ED' "
      "--dpi 4000\n"
      "reseau calibrate --device sim:ls5000 --yes -x 8mm -y 8mm -o bench",
      [options](Work& work) {
        const ExitCode code = run_calibrate(*options, work);
        if (code == kExitCancelled) work.reporter.warning("Stopped; no calibration was kept.");
        return code;
      });
  app->add_option("FILES", options->files,
                  "Scans of edges: TIFF (8, 16 bit, float) or EXR; none: a scanner makes them");
  app->add_option("--gate", options->gate,
                  "A scan of an open frame; again for scans of other exposures")
      ->allow_extra_args(false);
  app->add_option(
         "--random", options->random,
         "A scan of a random target, for the spread of a point in both directions at once;\n"
         "the middle of the picture, or with no FILES the region of --roi")
      ->allow_extra_args(false);
  app->add_option("--reseau", options->reseau,
                  "A scan of a film with a réseau, which tells where red, blue and infrared lie "
                  "against green")
      ->allow_extra_args(false);
  app->add_option(
      "--target", options->target,
      "Which random target: SEED,CELL_UM (1,3.2), as 'simulate --film random' makes it");
  options->bench.add_to(*app);
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
                "Hold the result against the calibration that is kept, or two calibrations\n"
                "(FILES: NOW.json EARLIER.json) against each other")
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
