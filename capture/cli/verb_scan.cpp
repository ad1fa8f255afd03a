#include <memory>

#include "capture/cli/scan_run.h"
#include "capture/cli/verbs.h"

namespace reseau::cli {

void add_scan_options(CLI::App& app, ScanJob& job) {
  job.scan.add_to(app);
  app.add_flag("-n,--dont-scan", job.dont_scan, "Say what would be done, and stop there")
      ->group("Scan");
  app.add_flag("--load", job.load, "Load the film or the next slide first")->group("Scan");
  app.add_flag("--eject", job.eject, "Eject the film afterwards")->group("Scan");
  app.add_option("--record", job.record, "Keep the whole session as FILE.pcapng")->group("Files");
  job.place.add_to(app);
  app.add_flag("--no-reconstruct", job.no_reconstruct, "Only the master")->group("Picture");
  job.picture.add_to(app);
  job.page.add_listen_to(app);
}

void add_scan(Program& program) {
  auto job = std::make_shared<ScanJob>();
  CLI::App* app = program.add_verb(
      "scan",
      "Focuses, meters, scans red, green, blue and infrared in one pass, and reconstructs the "
      "colours while\nthe film moves. Writes NAME.tif (master), NAME.exr (reconstruction), "
      "NAME.png "
      "and NAME_view.tif\n(to look at) and NAME.json (receipt). Nothing is ever overwritten. A "
      "film "
      "without réseau gives its\nmaster, a note and exit code 0. Ctrl-C stops at the next line and "
      "keeps what was read; a second\none leaves out the picture.",
      "reseau scan -o scans\n"
      "reseau scan -d sim:ls5000 --resolution 4000dpi -x 5mm -y 4mm -o scans",
      [job](Work& work) { return run_scan(*job, work); });
  add_scan_options(*app, *job);
  job->page.add_flag_to(*app);
}

}  // namespace reseau::cli
