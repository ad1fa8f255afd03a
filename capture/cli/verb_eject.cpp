#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "capture/cli/failure.h"
#include "capture/cli/scan_choice.h"
#include "capture/cli/scan_talk.h"
#include "capture/cli/verbs.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

ExitCode eject(const std::string& device, bool load, Work& work) {
  const std::string name =
      as_failure(Doing::kReadingOptions, [&] { return choose_device(device); });
  OpenedScanner opened = as_failure(Doing::kOpeningDevice, [&] { return open_scanner(name, {}); });
  ScanTalk talk(work.reporter);
  as_failure(Doing::kReadingOptions, [&] {
    if (load) {
      opened.scanner->load(talk);
    } else {
      opened.scanner->eject(talk);
    }
  });
  const bool film = opened.scanner->capabilities().film_present;
  work.reporter.result_line(film ? "film is in" : "no film is in the scanner");
  work.reporter.result_json(
      {{"schema", "reseau-eject/1"}, {"device", name}, {"film_present", film}});
  return kExitOk;
}

}  // namespace

void add_eject(Program& program) {
  struct Options {
    std::string device;
    bool load = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb(
      "eject",
      "Lets the scanner push the film out, and waits until it is out; with --load the other way "
      "round,\nwhere the adapter has a motor for that (slide feeder, APS).",
      "reseau eject\n"
      "reseau eject --load -d usb:04b0:4002",
      [options](Work& work) { return eject(options->device, options->load, work); });
  program.prints_own_json(app);
  app->add_option("-d,--device-name", options->device, "The scanner; default the only one");
  app->add_flag("--load", options->load, "Load the next slide or film instead");
}

}  // namespace reseau::cli
