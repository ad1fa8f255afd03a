#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/failure.h"
#include "capture/cli/read_choice.h"
#include "capture/cli/verbs.h"
#include "capture/image/exr_file.h"
#include "capture/session/offsets_json.h"
#include "capture/session/receipt.h"
#include "capture/session/registration_overlay.h"
#include "capture/session/registration_plot.h"
#include "capture/store/part_file.h"
#include "core/reconstruct/channel_registration.h"
#include "core/screen/screen_description.h"

namespace reseau::cli {

namespace {

struct RegisterArguments {
  ReadChoice read;
  std::string map, overlay, plot;
  std::string screen;
  bool exchange = false;
  int n_threads = 0;
};

// u and v of every scan pixel. A float of some thousand periods is good to 3e-4 of a period.
void write_map(const Registration& registration, const LineFormat& format,
               const std::filesystem::path& path, Work& work) {
  FloatImageWriter writer(path, format.width_px, format.n_lines, {"u", "v"});
  std::vector<float> row(2 * static_cast<std::size_t>(format.width_px));
  work.reporter.phase("write", path.string());
  for (int y = 0; y < format.n_lines; ++y) {
    if (work.signals.stop().stop_requested()) return;
    for (int x = 0; x < format.width_px; ++x) {
      const Vec2 s = registration.map.screen_from_scan({double(x), double(y)});
      row[2 * static_cast<std::size_t>(x)] = static_cast<float>(s.x);
      row[2 * static_cast<std::size_t>(x) + 1] = static_cast<float>(s.y);
    }
    writer.rows(y, 1, row);
    work.reporter.progress("write", {double(y + 1), double(format.n_lines), "lines", 0});
  }
  writer.finish();
}

void write_plot(const Registration& registration, const LineFormat& format,
                const std::filesystem::path& path) {
  const std::string text = registration_plot(registration, format);
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  file.write_at(0, std::as_bytes(std::span(text)));
  file.publish();
}

ExitCode run_register(const RegisterArguments& options, Work& work) {
  Reporter& reporter = work.reporter;
  for (const std::string* name : {&options.map, &options.overlay, &options.plot}) {
    if (!name->empty()) refuse_existing(*name);
  }
  if (!options.screen.empty())
    as_failure(Doing::kReadingInput, [&] { static_cast<void>(screen_kind(options.screen)); });
  const Scan scan = options.read.read(reporter);
  const LineFormat& format = scan.source->format();
  RegisterOptions register_options;
  register_options.tone = scan.tone;
  register_options.n_threads = options.n_threads;
  register_options.check_left_out = true;
  register_options.allow_grey = true;
  register_options.screen = options.screen;
  register_options.exchange = options.exchange;
  const DevelopProgress progress = develop_progress(reporter, false, format.n_lines);
  const Registration registration = register_screen(
      *scan.source, register_options,
      [&](double fraction) { progress(DevelopPhase::kRegister, fraction); }, work.signals.stop());
  if (work.signals.count() > 0) {
    reporter.warning("Stopped.");
    return kExitCancelled;
  }
  nlohmann::ordered_json object = {{"schema", "reseau-registration/1"},
                                   {"file", options.read.file},
                                   {"width_px", format.width_px},
                                   {"height_px", format.n_lines}};
  object.update(registration_to_json(registration));
  if (!registration.found) {
    reporter.result_json(object);
    reporter.warning(fmt::format("{}: {}", options.read.file, registration.reason));
    return kExitInput;
  }
  if (format.channels.size() >= 3) {
    object["channels_from_green"] = channel_offsets_to_json(
        measure_channel_offsets(*scan.source, registration, scan.tone, work.signals.stop()));
  }
  if (!options.map.empty()) {
    as_failure(Doing::kWriting, [&] { write_map(registration, format, options.map, work); });
    if (work.signals.count() > 0) {
      reporter.warning("Stopped; the map was not written.");
      return kExitCancelled;
    }
    object["map"] = options.map;
  }
  if (!options.overlay.empty()) {
    as_failure(Doing::kWriting,
               [&] { write_overlay(*scan.source, scan.tone, registration, options.overlay); });
    object["overlay"] = options.overlay;
  }
  if (!options.plot.empty()) {
    as_failure(Doing::kWriting, [&] { write_plot(registration, format, options.plot); });
    object["plot"] = options.plot;
  }
  reporter.result_json(object);
  reporter.result_line(describe_registration(registration));
  if (registration.identity == "unknown") {
    reporter.note(
        "The scan shows no colours: which of its elements is which, and so the name of the screen, "
        "is "
        "not known. u may be half a period off; --screen and --exchange say it by hand.");
  }
  return kExitOk;
}

}  // namespace

void add_register(Program& program) {
  auto options = std::make_shared<RegisterArguments>();
  CLI::App* app = program.add_verb(
      "register",
      "Finds the réseau of a scan and says where it lies. The map has two channels, u and v, in "
      "periods\nof the pattern, for every pixel of the scan. No réseau: exit code 65.\nA scan of "
      "one "
      "channel gives lattice, angle, periods and the map but for which element is which.",
      "reseau register party.tif\n"
      "reseau register party.tif --map party-map.exr --overlay party-dots.png --json",
      [options](Work& work) { return run_register(*options, work); });
  options->read.add_to(*app);
  options->read.allow_grey = true;
  app->add_option("--screen", options->screen,
                  "Which screen it is, where you know better: dufaycolor, paget, thames …");
  app->add_flag(
      "--exchange", options->exchange,
      "The two kinds of squares lie the other way round than the scan seems to show. In a\n"
      "scan without colours (infrared alone, black and white) the brighter kind counts as\n"
      "the first: green of a Dufaycolor, at u = v = 0");
  app->add_option("--map", options->map, "Write u and v of every pixel as an EXR of this name");
  app->add_option("--overlay", options->overlay,
                  "Write a PNG of this name: parts of the scan with a dot on every element");
  app->add_option("--plot", options->plot,
                  "Write an SVG of this name: how film and stage deviate from a plane lattice");
  app->add_option("--threads", options->n_threads, "Threads; 0 = all cores (default)")
      ->check(CLI::Range(0, 1024));
  program.prints_own_json(app);
}

}  // namespace reseau::cli
