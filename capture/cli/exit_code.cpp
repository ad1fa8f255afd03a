#include "capture/cli/exit_code.h"

#include <array>

#include <fmt/format.h>

namespace reseau::cli {

namespace {

struct Row {
  ExitCode code;
  const char* word;
  const char* meaning;
};

constexpr std::array kRows{
    Row{kExitOk, "ok", "done"},
    Row{kExitChecks, "checks", "a figure of paper lies outside its limits"},
    Row{kExitCancelled, "cancelled", "stopped by Ctrl-C; what was read is kept"},
    Row{kExitBusy, "busy", "another program holds the scanner"},
    Row{kExitNoFilm, "no-film", "no film"},
    Row{kExitDevice, "device", "the scanner failed before any line was read"},
    Row{kExitNoMemory, "no-memory", "out of memory"},
    Row{kExitAccessDenied, "access-denied", "no permission on the device"},
    Row{kExitUsage, "usage", "an option or value that cannot be used"},
    Row{kExitInput, "input", "a file that cannot be used, or no réseau in it"},
    Row{kExitInternal, "internal", "an error in the program itself"},
    Row{kExitOutput, "output", "the output cannot be written, or exists already"},
    Row{kExitPartial, "partial", "the scan broke off; every line that was read is kept"},
    Row{kExitSecondCtrlC, "second-ctrl-c", "told twice to stop"},
};

}  // namespace

const char* exit_word(ExitCode code) {
  for (const Row& row : kRows) {
    if (row.code == code) return row.word;
  }
  return "internal";
}

std::string exit_code_help() {
  std::string text = "Exit codes:\n";
  for (const Row& row : kRows) text += fmt::format("  {:>3}  {}\n", int{row.code}, row.meaning);
  return text;
}

}  // namespace reseau::cli
