// The verbs of the program and what they share.
#pragma once

#include <functional>
#include <ostream>
#include <string>

#include <CLI/App.hpp>

#include "capture/cli/exit_code.h"
#include "capture/cli/reporter.h"
#include "capture/cli/signals.h"

namespace reseau::cli {

// What a running verb may use.
struct Work {
  Reporter& reporter;
  SignalWatcher& signals;
};

using VerbFn = std::function<ExitCode(Work&)>;

class Program {
 public:
  // All outlive the program. `terminal`: talk is a terminal.
  Program(SignalWatcher& signals, std::ostream& out, std::ostream& talk, bool terminal);

  // Parses, runs one verb, reports every error. Never throws.
  [[nodiscard]] int run(int argc, const char* const* argv) noexcept;

  // For the verbs' own files: a sub-command whose help begins with `examples` (lines, without
  // indent), with the common options and the table of exit codes, run by `verb`.
  CLI::App* add_verb(const std::string& name, const std::string& summary,
                     const std::string& examples, VerbFn verb);
  // The same below another verb ("session show").
  CLI::App* add_verb_below(CLI::App* parent, const std::string& name, const std::string& summary,
                           const std::string& examples, VerbFn verb);
  // A verb that only groups others.
  CLI::App* add_group(const std::string& name, const std::string& summary,
                      const std::string& examples);
  // Verbs that print one JSON object instead of events call this, so that the schema line of the
  // events does not come first.
  void prints_own_json(const CLI::App* verb) { own_json_.push_back(verb); }

 private:
  [[nodiscard]] int run_chosen();

  SignalWatcher& signals_;
  std::ostream& out_;
  std::ostream& talk_;
  const bool terminal_;
  CLI::App app_;
  ReportOptions report_;
  std::string color_ = "auto";
  const CLI::App* chosen_ = nullptr;
  VerbFn chosen_verb_;
  std::vector<const CLI::App*> own_json_;
};

}  // namespace reseau::cli
