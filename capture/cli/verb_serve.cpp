#include <memory>

#include "capture/cli/scan_run.h"
#include "capture/cli/verbs.h"

namespace reseau::cli {

void add_serve(Program& program) {
  auto job = std::make_shared<ScanJob>();
  job->page.stay = true;
  CLI::App* app = program.add_verb(
      "serve",
      "Scans as 'scan --page' does, and keeps the page with picture and receipt until Ctrl-C. The "
      "page shows\nprovisional colour a moment behind the scan head, of draft quality and as sharp "
      "as the lines so far say\nthat the scan is; the final picture takes its place. It needs "
      "nothing from other places, and only this\nmachine sees it unless --listen says otherwise.",
      "reseau serve -o scans\n"
      "reseau serve -d 'sim:ls5000?pace=real' --listen 127.0.0.1:8080 -o scans",
      [job](Work& work) { return run_scan(*job, work); });
  add_scan_options(*app, *job);
}

}  // namespace reseau::cli
