// What the program tells a script. 2 to 11 mean what they mean for scanimage; 64 and up are
// sysexits.
#pragma once

#include <string>

namespace reseau::cli {

enum ExitCode : int {
  kExitOk = 0,
  kExitChecks = 1,         // a figure that was asked for lies outside its limits
  kExitCancelled = 2,      // stopped by a person; what was read is kept
  kExitBusy = 3,           // another program holds the unit
  kExitNoFilm = 7,         // no film
  kExitDevice = 9,         // the unit failed or went away before any line
  kExitNoMemory = 10,      // out of memory
  kExitAccessDenied = 11,  // no permission on the device
  kExitUsage = 64,         // an option or value that cannot be used
  kExitInput = 65,         // a file that cannot be used, or no réseau in it
  kExitInternal = 70,      // a bug of the program
  kExitOutput = 74,        // the output cannot be written, or exists already
  kExitPartial = 75,       // the scan broke off; a master with every line read is kept
  kExitSecondCtrlC = 130,  // told twice to stop
};

// One word for events and receipts, e.g. "no-film".
[[nodiscard]] const char* exit_word(ExitCode code);

// The table printed at the end of every --help.
[[nodiscard]] std::string exit_code_help();

}  // namespace reseau::cli
