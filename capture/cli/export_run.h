// `simulate --usbip`: the simulated unit as a USB device for other programs.
#pragma once

#include <string>

#include "capture/cli/program.h"

namespace reseau::cli {

// Serves until Ctrl-C, which is its way to end well (exit 0). The address is a line of stdout, and
// the event "listening", once connections are taken.
[[nodiscard]] ExitCode run_export(const std::string& device_name, const std::string& listen,
                                  Work& work);

}  // namespace reseau::cli
