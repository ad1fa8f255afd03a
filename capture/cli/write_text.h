#pragma once

#include <string>

#include "capture/cli/reporter.h"

namespace reseau::cli {

// Writes a text file beside and renames; a file of that name is refused (Failure kExitOutput).
void write_text(const std::string& path, const std::string& text, Reporter& reporter);

}  // namespace reseau::cli
