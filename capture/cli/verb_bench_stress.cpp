#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/bench/stress_bench.h"
#include "capture/cli/verb_bench.h"

namespace reseau::cli {

namespace {

struct StressArguments {
  int n_random = 8;
  unsigned seed = 1;
  std::string only;
};

const char* outcome_word(StressOutcome outcome) {
  return outcome == StressOutcome::kAnswered  ? "answered"
         : outcome == StressOutcome::kRefused ? "refused"
                                              : "FAILED";
}

ExitCode bench_stress(const StressArguments& options, Work& work) {
  std::vector<StressCase> cases = stress_cases(options.n_random, options.seed);
  std::erase_if(cases, [&options](const StressCase& test) {
    return (test.group + ": " + test.name).find(options.only) == std::string::npos;
  });
  work.reporter.result_line(fmt::format("{:<40} {:<9} {:>8} {:>8} {:>8} {:>7} {:>8}", "case",
                                        "outcome", "off px", "claimed", "cond.", "gain",
                                        "largest"));
  int n_failed = 0;
  StressResult worst;
  for (const StressCase& test : cases) {
    if (work.signals.stop().stop_requested()) return kExitCancelled;
    const StressResult r = run_stress_case(test);
    n_failed += r.outcome == StressOutcome::kFailed ? 1 : 0;
    worst.condition = std::max(worst.condition, r.condition);
    worst.noise_gain = std::max(worst.noise_gain, r.noise_gain);
    std::string line =
        fmt::format("{:<40} {:<9}", test.group + ": " + test.name, outcome_word(r.outcome));
    if (r.outcome != StressOutcome::kRefused) {
      line += fmt::format(" {:>8.4f} {:>8.4f} {:>8.2f} {:>7.2f} {:>8.2f}", r.off_px, r.claimed_px,
                          r.condition, r.noise_gain, r.largest_sample);
    }
    work.reporter.result_line(r.words.empty() ? line : line + "  " + r.words);
    work.reporter.event("case", {{"group", test.group},
                                 {"name", test.name},
                                 {"film", test.film},
                                 {"outcome", outcome_word(r.outcome)},
                                 {"words", r.words},
                                 {"off_px", r.off_px},
                                 {"claimed_px", r.claimed_px},
                                 {"unmix_condition", r.condition},
                                 {"unmix_noise_gain", r.noise_gain},
                                 {"largest_sample", r.largest_sample},
                                 {"same_bytes", r.same_bytes}});
  }
  work.reporter.result_line(
      fmt::format("{} cases, {} failed; largest condition number {:.1f}, largest noise gain {:.2f}",
                  cases.size(), n_failed, worst.condition, worst.noise_gain));
  return kExitOk;
}

}  // namespace

void add_bench_stress(Program& program, CLI::App* bench) {
  auto options = std::make_shared<StressArguments>();
  CLI::App* app = program.add_verb_below(
      bench, "stress",
      "Scans and parameters that break programs. Each has to give a finite picture, the same with "
      "one thread\nand with five, on a map that is off by no more than it says, or a sentence that "
      "there is none.",
      "reseau bench stress\n"
      "reseau bench stress --random 100 --seed 7 --only lot --json",
      [options](Work& work) { return bench_stress(*options, work); });
  app->add_option("--random", options->n_random, "Films by lot (default 8)")
      ->check(CLI::Range(0, 100000));
  app->add_option("--seed", options->seed, "Of the lot (default 1)");
  app->add_option("--only", options->only, "Cases whose group and name contain this text");
}

}  // namespace reseau::cli
