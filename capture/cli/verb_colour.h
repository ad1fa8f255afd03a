// The verbs below `reseau colour`, each in its own file verb_colour_NAME.cpp.
#pragma once

#include <string>

#include "capture/cli/program.h"

namespace reseau::cli {

void add_colour_apply(Program& program, CLI::App* group);
void add_colour_compare(Program& program, CLI::App* group);
void add_colour_profile(Program& program, CLI::App* group);

// Writes a text file beside and renames; a file of that name is refused (Failure kExitOutput).
void write_text(const std::string& path, const std::string& text, Reporter& reporter);

}  // namespace reseau::cli
