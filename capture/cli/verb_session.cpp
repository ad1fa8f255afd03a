#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/failure.h"
#include "capture/cli/verbs.h"
#include "capture/session/request_json.h"
#include "core/base/error.h"
#include "drivers/registry.h"
#include "drivers/sessions.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

ordered_json session_json(const ShownSession& session) {
  return {{"unit", session.device},
          {"serial", session.serial},
          {"opened_as", session.name},
          {"started_at_utc", session.started_at},
          {"commands", session.n_exchanges}};
}

struct ShowOptions {
  std::string file, phase;
  bool brief = false, failed = false;
};

ExitCode show(const ShowOptions& options, Work& work) {
  Reporter& reporter = work.reporter;
  const ShownSession session = as_failure(Doing::kReadingInput, [&] {
    return show_session(options.file, [&](const ShownExchange& e) {
      if (!options.phase.empty() && e.phase != options.phase) return;
      if (options.failed && e.good) return;
      reporter.event("command", {{"number", e.number},
                                 {"packet", e.first_packet},
                                 {"start_s", e.start_s},
                                 {"duration_ms", e.duration_ms},
                                 {"phase", e.phase},
                                 {"name", e.command},
                                 {"bytes", e.command_hex},
                                 {"sent_bytes", e.out_bytes},
                                 {"received_bytes", e.in_bytes},
                                 {"status", e.status_hex},
                                 {"outcome", e.outcome}});
      if (options.brief) {
        reporter.result_line(fmt::format("#{:<6} {:<60} {}", e.number, e.command, e.outcome));
      } else {
        reporter.result_line(e.text);
      }
    });
  });
  reporter.event("session", session_json(session));
  reporter.say(fmt::format("{} commands to {}{}.", session.n_exchanges, session.device,
                           session.name.empty() ? "" : ", recorded as " + session.name));
  return kExitOk;
}

class SilentObserver final : public ScanObserver {
 public:
  void phase(ScanPhase /*phase*/, const std::string& /*detail*/) override {}
  void note(const std::string& /*sentence*/) override {}
};

// What this program does otherwise than the recording; absent when nothing. Nothing to say where
// the recording does not tell what was asked for.
struct ReplayCheck {
  bool asked = false;
  int n_lines = 0;
  std::optional<std::string> difference;
};

ReplayCheck check_replay(const std::string& file, const std::stop_token& stop) {
  ReplayCheck check;
  try {
    OpenedScanner opened = open_scanner("replay:" + file, {});
    const auto recorded = recorded_request_from_json(opened.recorded_comment, file);
    if (!recorded) return check;
    check.asked = true;
    Scanner& scanner = *opened.scanner;
    SilentObserver observer;
    if (!scanner.start(scanner.negotiate(recorded->request).plan, observer, stop)) return check;
    LineBlock block;
    while (!stop.stop_requested() && scanner.read(block, Duration(0)) == ReadStatus::kLines) {
      check.n_lines += block.n_lines;
    }
  } catch (const DeviceError& error) {
    check.asked = true;
    check.difference = error.what();
  } catch (const InputError& error) {
    check.asked = true;
    check.difference = error.what();
  }
  return check;
}

ExitCode check(const std::string& file, Work& work) {
  Reporter& reporter = work.reporter;
  SessionCheck found = as_failure(Doing::kReadingInput, [&] { return check_session(file); });
  const ReplayCheck replay = check_replay(file, work.signals.stop());
  if (replay.difference) {
    found.problems.push_back("Replayed with this program: " + *replay.difference);
  }
  const bool whole = found.problems.empty();
  reporter.result_line(fmt::format(
      "{} commands to {}, {} not ready, {} refused, {} failed transfers", found.session.n_exchanges,
      found.session.device, found.n_not_ready, found.n_refused, found.n_failed_transfers));
  if (replay.asked && !replay.difference) {
    reporter.result_line(
        fmt::format("this program does the same: {} lines replayed", replay.n_lines));
  } else if (!replay.asked) {
    reporter.result_line("the recording does not say what was asked for, so it was not replayed");
  }
  for (const std::string& problem : found.problems) reporter.result_line("problem: " + problem);
  ordered_json json = {{"schema", "reseau-session-check/1"}, {"whole", whole}};
  json.update(session_json(found.session));
  json["not_ready"] = found.n_not_ready;
  json["refused"] = found.n_refused;
  json["failed_transfers"] = found.n_failed_transfers;
  json["replayed"] = replay.asked && !replay.difference;
  json["replayed_lines"] = replay.n_lines;
  json["problems"] = found.problems;
  reporter.result_json(json);
  return whole ? kExitOk : kExitChecks;
}

struct WriteOptions {
  std::string from, to;
  RewriteOptions rewrite;
};

ExitCode rewrite(const WriteOptions& options, Work& work) {
  const RewriteResult result = as_failure(Doing::kReadingInput, [&] {
    if (std::filesystem::exists(options.to)) {
      throw Failure(kExitOutput, options.to + " exists already and is not overwritten.",
                    "Choose another name.");
    }
    return rewrite_session(options.from, options.to, options.rewrite);
  });
  work.reporter.say(fmt::format("{} commands, {} packets; {} packets left out, {} places blanked.",
                                result.n_exchanges, result.n_packets, result.n_packets_left_out,
                                result.n_blanked));
  work.reporter.result_line(options.to);
  work.reporter.result_json({{"schema", "reseau-session-file/1"},
                             {"file", options.to},
                             {"commands", result.n_exchanges},
                             {"packets", result.n_packets},
                             {"packets_left_out", result.n_packets_left_out},
                             {"places_blanked", result.n_blanked}});
  return kExitOk;
}

void add_files(CLI::App* app, const std::shared_ptr<WriteOptions>& options) {
  app->add_option("FILE", options->from, "A recording, pcapng or pcap")->required();
  app->add_option("-o,--output", options->to, "The new file; never overwritten")->required();
}

void add_show(Program& program, CLI::App* group) {
  auto options = std::make_shared<ShowOptions>();
  CLI::App* app = program.add_verb_below(
      group, "show", "Prints a recording as commands with what they mean and what was answered.",
      "reseau session show box3-slide24.pcapng\n"
      "reseau session show nikonscan.pcapng --brief --failed",
      [options](Work& work) { return show(*options, work); });
  app->add_option("FILE", options->file, "A recording, pcapng or pcap")->required();
  app->add_option("--phase", options->phase, "Only this phase");
  app->add_flag("--brief", options->brief, "One line a command");
  app->add_flag("--failed", options->failed, "Only commands that were not answered with good");
}

void add_check(Program& program, CLI::App* group) {
  auto file = std::make_shared<std::string>();
  CLI::App* app = program.add_verb_below(
      group, "check",
      "Says whether a recording is whole, and whether this program does the same today. Exit code "
      "1\nwhen not.",
      "reseau session check box3-slide24.pcapng\n"
      "reseau session check nikonscan.pcapng --json",
      [file](Work& work) { return check(*file, work); });
  program.prints_own_json(app);
  app->add_option("FILE", *file, "A recording, pcapng or pcap")->required();
}

void add_anonymise(Program& program, CLI::App* group) {
  auto options = std::make_shared<WriteOptions>();
  options->rewrite.blank_serial = true;
  CLI::App* app = program.add_verb_below(
      group, "anonymise",
      "Writes a copy with the scanner alone, its serial number blanked wherever it stands.",
      "reseau session anonymise box3-slide24.pcapng -o to-report.pcapng\n"
      "reseau session anonymise scan.pcapng -o out.pcapng --also 'Miller'",
      [options](Work& work) { return rewrite(*options, work); });
  program.prints_own_json(app);
  add_files(app, options);
  app->add_option("--also", options->rewrite.also_blank, "Another text to blank")
      ->allow_extra_args(false);
}

void add_trim(Program& program, CLI::App* group) {
  auto options = std::make_shared<WriteOptions>();
  CLI::App* app = program.add_verb_below(
      group, "trim", "Writes a copy with a part of the commands, counted as 'session show' does.",
      "reseau session trim scan.pcapng -o start.pcapng --last 200\n"
      "reseau session trim scan.pcapng -o focus.pcapng --phase focus",
      [options](Work& work) { return rewrite(*options, work); });
  program.prints_own_json(app);
  add_files(app, options);
  app->add_option("--first", options->rewrite.first_exchange, "From this command on")
      ->check(CLI::PositiveNumber);
  app->add_option("--last", options->rewrite.last_exchange, "Up to this one")
      ->check(CLI::PositiveNumber);
  app->add_option("--phase", options->rewrite.phase, "Only this phase");
}

void add_import(Program& program, CLI::App* group) {
  auto options = std::make_shared<WriteOptions>();
  CLI::App* app = program.add_verb_below(
      group, "import",
      "Makes a session of a capture that another program made: Linux usbmon, Windows USBPcap, or a "
      "list\nof commands (.jsonl). Other devices of the bus are left out.",
      "reseau session import usbpcap.pcapng -o nikonscan.pcapng\n"
      "reseau session import ls5000.jsonl -o ls5000.pcapng",
      [options](Work& work) { return rewrite(*options, work); });
  program.prints_own_json(app);
  add_files(app, options);
}

}  // namespace

void add_session(Program& program) {
  CLI::App* group =
      program.add_group("session", "Reads, checks and prepares recordings of scans.",
                        "reseau session show box3-slide24.pcapng\n"
                        "reseau session anonymise box3-slide24.pcapng -o to-report.pcapng");
  add_show(program, group);
  add_check(program, group);
  add_anonymise(program, group);
  add_trim(program, group);
  add_import(program, group);
}

}  // namespace reseau::cli
