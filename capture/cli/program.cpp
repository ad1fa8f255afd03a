#include "capture/cli/program.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace reseau::cli {

namespace {

std::string with_examples(const std::string& summary, const std::string& examples) {
  std::string text = "Examples:\n";
  std::size_t at = 0;
  while (at < examples.size()) {
    const std::size_t end = std::min(examples.find('\n', at), examples.size());
    text += "  " + examples.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text + "\n" + summary;
}

bool asks_for_json(int argc, const char* const* argv) {
  return std::any_of(argv, argv + argc,
                     [](const char* word) { return std::string_view(word) == "--json"; });
}

}  // namespace

Program::Program(SignalWatcher& signals, std::ostream& out, std::ostream& talk, bool terminal)
    : signals_(signals),
      out_(out),
      talk_(talk),
      terminal_(terminal),
      app_(with_examples("Scans Dufaycolor and other screen films, and brings back their colour.",
                         "reseau scan -o scans\n"
                         "reseau reconstruct old-scan.tif -o pictures"),
           "reseau") {
  app_.require_subcommand(1);
  app_.footer(exit_code_help());
  app_.set_version_flag("--version", "reseau " RESEAU_VERSION);
  app_.get_formatter()->column_width(34);
}

CLI::App* Program::add_group(const std::string& name, const std::string& summary,
                             const std::string& examples) {
  CLI::App* group = app_.add_subcommand(name, with_examples(summary, examples));
  group->require_subcommand(1);
  group->footer(exit_code_help());
  return group;
}

CLI::App* Program::add_verb(const std::string& name, const std::string& summary,
                            const std::string& examples, VerbFn verb) {
  return add_verb_below(&app_, name, summary, examples, std::move(verb));
}

CLI::App* Program::add_verb_below(CLI::App* parent, const std::string& name,
                                  const std::string& summary, const std::string& examples,
                                  VerbFn verb) {
  CLI::App* sub = parent->add_subcommand(name, with_examples(summary, examples));
  sub->footer(exit_code_help());
  sub->add_flag("--json", report_.json, "Events or results as JSON on stdout, one object per line")
      ->group("Talk");
  sub->add_flag("-q,--quiet", report_.quiet, "Only warnings and errors on stderr")->group("Talk");
  sub->add_flag("--plain", report_.plain, "Plain lines, no progress bar")->group("Talk");
  sub->add_option("--color", color_, "auto, always or never; NO_COLOR is honoured")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->group("Talk");
  sub->callback([this, sub, verb = std::move(verb)] {
    chosen_ = sub;
    chosen_verb_ = verb;
  });
  return sub;
}

int Program::run(int argc, const char* const* argv) noexcept {
  try {
    app_.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      return app_.exit(error, out_, talk_);  // --help, --version
    }
    ReportOptions options;
    options.json = asks_for_json(argc, argv);
    Reporter reporter(options, "", out_, talk_, terminal_);
    reporter.error(Failure(kExitUsage, error.what(), "See 'reseau --help'."));
    return kExitUsage;
  } catch (...) {
    Reporter reporter({}, "", out_, talk_, terminal_);
    const Failure failure = describe(std::current_exception(), Doing::kReadingOptions);
    reporter.error(failure);
    return failure.code();
  }
  try {
    return run_chosen();
  } catch (...) {
    return kExitInternal;
  }
}

int Program::run_chosen() {
  const char* no_color = std::getenv("NO_COLOR");
  if (color_ == "always") report_.color = ReportOptions::Color::kAlways;
  if (color_ == "never" || (color_ == "auto" && no_color != nullptr && *no_color != '\0')) {
    report_.color = ReportOptions::Color::kNever;
  }
  const bool own_json = std::find(own_json_.begin(), own_json_.end(), chosen_) != own_json_.end();
  ReportOptions options = report_;
  options.json = report_.json && !own_json;
  options.json_result = report_.json;
  Reporter reporter(options, chosen_->get_name(), out_, talk_, terminal_);
  ExitCode code = kExitOk;
  try {
    Work work{reporter, signals_};
    code = chosen_verb_(work);
  } catch (...) {
    const Failure failure = describe(std::current_exception(), Doing::kWorking);
    reporter.error(failure);
    code = failure.code();
  }
  if (code != kExitOk && signals_.count() >= 2) code = kExitSecondCtrlC;
  reporter.event("end", {{"exit", int{code}}, {"code", exit_word(code)}});
  return code;
}

}  // namespace reseau::cli
