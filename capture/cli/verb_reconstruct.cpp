#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/event_log.h"
#include "capture/cli/read_choice.h"
#include "capture/cli/recolor_run.h"
#include "capture/cli/verbs.h"
#include "capture/session/receipt.h"

namespace reseau::cli {

namespace {

struct ReconstructArguments {
  ReadChoice read;
  DevelopChoice picture;
  std::string output = ".";
};

void refuse_all_existing(const PictureNames& names, bool view) {
  refuse_existing(names.exr);
  refuse_existing(names.receipt);
  if (!view) return;
  refuse_existing(names.png);
  refuse_existing(names.view_tiff);
}

Receipt make_receipt(const ReconstructArguments& options, const Scan& scan,
                     const DevelopOptions& settings, const Development& development,
                     const PictureNames& names) {
  Receipt receipt;
  receipt.verb = "reconstruct";
  receipt.written_at = utc_now(false);
  receipt.input.format = scan.source->format();
  receipt.input.context = scan.context;
  receipt.input.tone = options.read.tone_word(scan);
  receipt.input.notes = scan.notes;
  receipt.settings = settings;
  receipt.quality = options.picture.quality;
  receipt.development = development;
  receipt.files = {{"source", options.read.file}, {"reconstruction", names.exr}};
  if (!scan.infrared_path.empty()) receipt.files.push_back({"infrared", scan.infrared_path});
  if (!options.picture.no_view) {
    receipt.files.push_back({"view", names.png});
    receipt.files.push_back({"view16", names.view_tiff});
  }
  return receipt;
}

ExitCode run_reconstruct(const ReconstructArguments& options, Work& work) {
  Reporter& reporter = work.reporter;
  DevelopOptions settings =
      as_failure(Doing::kReadingOptions, [&] { return options.picture.resolve(reporter); });
  const ProfileChoice profile =
      as_failure(Doing::kReadingOptions, [&] { return options.picture.resolve_profile(); });
  if (is_exr(options.read.file)) {
    return run_recolor(
        {"reconstruct", options.read.file, options.output, settings.color, settings.neutral,
         settings.view_gamut, settings.n_threads, !options.picture.no_view},
        work);
  }
  const std::filesystem::path directory(options.output);
  const PictureNames names =
      picture_names(directory, std::filesystem::path(options.read.file).stem().string());
  const bool view = !options.picture.no_view;
  // Before any work, so that nobody waits for a refusal.
  refuse_all_existing(names, view);
  const Scan scan = options.read.read(reporter);
  settings.profile = as_failure(Doing::kReadingInput, [&] {
    return use_profile(profile, scan.context, scan.source->format().x_dpi);
  });
  prepare_directory(directory);

  const LineFormat& format = scan.source->format();
  const bool infrared = format.plane_of(Channel::kInfrared) >= 0;
  reporter.say(fmt::format("{} · {} × {} px · {} · to {}", options.read.file, format.width_px,
                           format.n_lines, infrared ? "RGB+IR" : "RGB without infrared",
                           directory.string()));
  settings.tone = scan.tone;
  settings.dpi = format.x_dpi;
  settings.exr = names.exr;
  if (view) {
    settings.png = names.png;
    settings.tiff = names.view_tiff;
  }
  const Development development =
      develop(*scan.source, settings, develop_progress(reporter, false, format.n_lines),
              work.signals.stop());
  if (development.stopped) {
    reporter.warning("Stopped; nothing was written.");
    return kExitCancelled;
  }
  if (!development.written) {
    throw Failure(kExitInput, fmt::format("{}: {}", options.read.file, development.why_not),
                  "Only a film with a colour screen can be reconstructed; 'reseau register' says "
                  "more about this scan.");
  }
  write_json_file(receipt_to_json(make_receipt(options, scan, settings, development, names)),
                  names.receipt);
  reporter.event("file", {{"role", "reconstruction"}, {"path", names.exr.string()}});
  reporter.event("file", {{"role", "receipt"}, {"path", names.receipt.string()}});
  reporter.say("");
  reporter.say("Réseau    " + describe_registration(development.registration));
  if (development.report) {
    if (!settings.profile.path.empty())
      reporter.say("Unit      calibrated " + settings.profile.measured_at_utc);
    for (const std::string& note : settings.profile.notes) reporter.say("          " + note);
    reporter.say("Clipped   " + describe_clipping(*development.report, infrared));
    reporter.say(fmt::format(
        "Time      {:.2f} s to register, {:.2f} s to reconstruct", development.registration.seconds,
        development.report->seconds_sharpness + development.report->seconds_render));
  }
  if (view) reporter.say("To look at  " + names.png.string());
  reporter.result_line(names.exr.string());
  return kExitOk;
}

}  // namespace

void add_reconstruct(Program& program) {
  auto options = std::make_shared<ReconstructArguments>();
  CLI::App* app = program.add_verb(
      "reconstruct",
      "Brings back the colours of a scan that is a file. Writes NAME.exr and NAME.json, and "
      "NAME.png "
      "and\nNAME_view.tif to look at, NAME being that of FILE. Refuses, with exit code 74 and "
      "before "
      "any work,\nwhen one of them exists. No réseau in the scan: exit code 65 and the reason. A "
      "FILE "
      "that\nis a reconstruction (EXR) is only coloured anew, as by 'reseau colour apply'.",
      "reseau reconstruct party.tif -o pictures\n"
      "reseau reconstruct old-scan.tif --gamma 2.2 --space process -o pictures",
      [options](Work& work) { return run_reconstruct(*options, work); });
  options->read.add_to(*app);
  app->add_option("-o,--output", options->output, "Folder for the files; default here")
      ->group("Files");
  options->picture.add_to(*app);
}

}  // namespace reseau::cli
