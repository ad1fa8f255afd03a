#include <memory>
#include <string>

#include "capture/cli/scan_run.h"
#include "capture/cli/verbs.h"

namespace reseau::cli {

void add_replay(Program& program) {
  struct Options {
    ScanJob job;
    std::string file;
  };
  auto options = std::make_shared<Options>();
  CLI::App* app = program.add_verb(
      "replay",
      "Plays a recorded session without a scanner, as 'scan -d replay:FILE' does. A recording made "
      "with\n'scan --record' says itself what was asked for, and gives the same master again.",
      "reseau replay box3-slide24.pcapng -o again\n"
      "reseau replay box3-slide24.pcapng -o again --no-reconstruct --json --speed 10",
      [options](Work& work) {
        options->job.scan.device = "replay:" + options->file;
        return run_scan(options->job, work);
      });
  app->add_option("FILE", options->file, "A recording, pcapng or pcap")->required();
  app->add_flag("-n,--dont-scan", options->job.dont_scan, "Say what would be done, and stop there");
  app->add_option("--speed", options->job.replay_speed,
                  "Times the recorded speed: 1 as it was, 0 (default) as fast as possible")
      ->check(CLI::NonNegativeNumber);
  app->add_option("--fault", options->job.replay_fault,
                  "stall@N, timeout@N, short@N or disconnect@N: fails that transfer");
  options->job.place.add_to(*app);
  app->add_flag("--no-reconstruct", options->job.no_reconstruct, "Only the master")
      ->group("Picture");
  options->job.picture.add_to(*app);
  options->job.page.add_flag_to(*app);
  options->job.page.add_listen_to(*app);
}

}  // namespace reseau::cli
