// The verbs below `reseau colour`, each in its own file verb_colour_NAME.cpp.
#pragma once

#include "capture/cli/program.h"

namespace reseau::cli {

void add_colour_apply(Program& program, CLI::App* group);
void add_colour_compare(Program& program, CLI::App* group);
void add_colour_profile(Program& program, CLI::App* group);

}  // namespace reseau::cli
