#include "capture/cli/export_run.h"

#include <exception>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/failure.h"
#include "drivers/export_unit.h"

namespace reseau::cli {

ExitCode run_export(const std::string& device_name, const std::string& listen, Work& work) {
  ExportTalk talk;
  talk.note = [&work](const std::string& sentence) { work.reporter.note(sentence); };
  talk.ready = [&work](const std::string& address, const std::string& description) {
    work.reporter.say(fmt::format(
        "{} (simulated) is exported as USB device 1-1 at {}; Ctrl-C ends it.\n"
        "On a machine with the module vhci-hcd, as root: usbip attach -r 127.0.0.1 -b 1-1",
        description, address));
    work.reporter.event("listening",
                        {{"address", address}, {"bus_id", "1-1"}, {"device", description}});
    work.reporter.result_line(address);
  };
  try {
    export_unit({device_name, listen}, talk, work.signals.stop());
  } catch (const std::system_error& error) {
    throw Failure(kExitOutput, error.what(),
                  "Choose another address; port 0 takes one that is free.");
  } catch (...) {
    throw describe(std::current_exception(), Doing::kReadingOptions);
  }
  return kExitOk;
}

}  // namespace reseau::cli
