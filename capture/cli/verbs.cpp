#include "capture/cli/verbs.h"

namespace reseau::cli {

void add_all_verbs(Program& program) {
  add_list(program);
  add_doctor(program);
  add_dump(program);
  add_preview(program);
  add_scan(program);
  add_serve(program);
  add_calibrate(program);
  add_eject(program);
  add_unstick(program);
  add_reconstruct(program);
  add_register(program);
  add_compare(program);
  add_replay(program);
  add_session(program);
  add_simulate(program);
  add_colour(program);
  add_paper(program);
  add_bench(program);
}

}  // namespace reseau::cli
