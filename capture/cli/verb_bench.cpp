#include "capture/cli/verb_bench.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/bench/registration_cases.h"
#include "capture/bench/registration_score.h"
#include "capture/cli/verbs.h"

namespace reseau::cli {

namespace {

struct BenchArguments {
  bool sweeps = false;
  std::string only;
  int n_threads = 1, n_seeds = 1;
};

nlohmann::ordered_json score_json(const RegistrationCase& test, const RegistrationScore& score) {
  nlohmann::ordered_json object = {
      {"group", test.group}, {"name", test.name}, {"film", test.film}, {"found", score.found}};
  if (!score.found) {
    object["reason"] = score.reason;
    return object;
  }
  object["rms_px"] = score.rms_px;
  object["lit_rms_px"] = score.lit_rms_px;
  object["max_px"] = score.max_px;
  object["claimed_px"] = score.sd_px;
  object["bound_px"] = score.bound_px;
  object["z"] = score.z_sd;
  object["worst_z"] = score.worst_z;
  object["residual_px"] = score.residual_px;
  if (test.bar_px > 0) object["bar_px"] = test.bar_px;
  object["cpu_s"] = score.cpu_s;
  object["wall_s"] = score.wall_s;
  return object;
}

std::string score_line(const RegistrationCase& test, const RegistrationScore& score) {
  if (!score.found) return fmt::format("{:<42} not found", test.name);
  const double error = test.lit_only ? score.lit_rms_px : score.rms_px;
  const std::string bar = test.bar_px > 0 ? fmt::format("{:6.3f} {}", test.bar_px,
                                                        error <= test.bar_px ? "kept" : "MISSED")
                                          : std::string("     -");
  return fmt::format("{:<42} {:8.4f} {:8.4f} {:8.4f} {:8.4f} {:8.4f} {:5.2f} {:6.1f} {:6.2f}  {}",
                     test.name, score.rms_px, score.lit_rms_px, score.max_px, score.sd_px,
                     score.bound_px, score.z_sd, score.worst_z, score.cpu_s, bar);
}

ExitCode run_registration(const BenchArguments& options, Work& work) {
  const std::vector<RegistrationCase> all =
      options.sweeps ? registration_sweeps() : registration_bars();
  std::vector<RegistrationCase> cases;
  std::copy_if(all.begin(), all.end(), std::back_inserter(cases),
               [&](const auto& test) { return test.name.find(options.only) != std::string::npos; });
  work.reporter.result_line(
      fmt::format("{:<42} {:>8} {:>8} {:>8} {:>8} {:>8} {:>5} {:>6} {:>6}  {:>6}", "film", "rms px",
                  "lit px", "max px", "claimed", "noise", "z", "most z", "cpu s", "bar px"));
  for (const RegistrationCase& test : cases) {
    if (work.signals.stop().stop_requested()) return kExitCancelled;
    const RegistrationScore score = score_registration(test, options.n_threads, options.n_seeds);
    work.reporter.result_line(score_line(test, score));
    work.reporter.event("case", score_json(test, score));
  }
  return kExitOk;
}

}  // namespace

void add_bench(Program& program) {
  CLI::App* group =
      program.add_group("bench", "Measures the program on simulated films of which all is known.",
                        "reseau bench registration\n"
                        "reseau bench reconstruction --quality best");
  auto options = std::make_shared<BenchArguments>();
  CLI::App* app = program.add_verb_below(
      group, "registration",
      "Finds the réseau of simulated films and says how far off it is: over the frame, where there "
      "is\nlight, and at most; what the map claims, and what noise alone would leave if all that "
      "the fits of "
      "windows leave were noise;\nz, error over claim, rms and at most; the processor time that it "
      "took.",
      "reseau bench registration --only wobble\n"
      "reseau bench registration --sweeps --json",
      [options](Work& work) { return run_registration(*options, work); });
  app->add_flag("--sweeps", options->sweeps,
                "One setting at a time over its range, instead of the cases that have a bar");
  app->add_option("--only", options->only, "Cases whose name contains this text");
  app->add_option("--seeds", options->n_seeds,
                  "So many noises and scenes of every case; rms over them (default 1)")
      ->check(CLI::Range(1, 100));
  app->add_option("--threads", options->n_threads, "Threads; 0 = all cores")
      ->check(CLI::Range(0, 1024));
  add_bench_reconstruction(program, group);
  add_bench_speed(program, group);
  add_bench_stress(program, group);
}

}  // namespace reseau::cli
