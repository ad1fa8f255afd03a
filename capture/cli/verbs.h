// One function per verb, each in its own file verb_NAME.cpp.
#pragma once

#include "capture/cli/program.h"

namespace reseau::cli {

void add_list(Program& program);
void add_doctor(Program& program);
void add_dump(Program& program);
void add_preview(Program& program);
void add_scan(Program& program);
void add_serve(Program& program);
void add_eject(Program& program);
void add_unstick(Program& program);
void add_replay(Program& program);
void add_session(Program& program);
void add_reconstruct(Program& program);
void add_register(Program& program);
void add_compare(Program& program);
void add_simulate(Program& program);
void add_colour(Program& program);
void add_paper(Program& program);
void add_bench(Program& program);
void add_calibrate(Program& program);

// All of them, in the order of the help.
void add_all_verbs(Program& program);

}  // namespace reseau::cli
