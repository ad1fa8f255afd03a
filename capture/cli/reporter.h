// Talk: phases, progress with an ETA, notes and errors, to people on stderr and as events on
// stdout.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <ostream>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"

namespace reseau::cli {

struct ReportOptions {
  bool json = false;         // events on stdout
  bool json_result = false;  // --json was given: results are JSON, whether there are events or not
  bool quiet = false;
  bool plain = false;  // no carriage returns even on a terminal
  enum class Color { kAuto, kAlways, kNever };
  Color color = Color::kAuto;
};

struct Progress {
  double done = 0, total = 0;  // in `unit`; total 0 = unknown
  std::string unit;            // "lines"; empty: shown as a percentage only
  double bytes = 0;            // so far; 0 = not said
};

// Thread-safe. Phases of the vocabulary: warm-up load focus meter scan register reconstruct write.
class Reporter {
 public:
  using Now = std::chrono::steady_clock::time_point (*)();

  // `out` gets events (when asked for) and results, `talk` gets everything for people. `terminal`:
  // talk is one. Both outlive this.
  Reporter(const ReportOptions& options, const std::string& verb, std::ostream& out,
           std::ostream& talk, bool terminal, Now now = &std::chrono::steady_clock::now);
  ~Reporter();
  Reporter(const Reporter&) = delete;
  Reporter& operator=(const Reporter&) = delete;

  // A phase begins. In the background it goes to the events only, for work that another phase
  // hides.
  void phase(const std::string& name, const std::string& detail, bool background = false);
  // Shown for the phase in the foreground, at most ten times a second on a terminal and once in ten
  // seconds elsewhere; to the events at most five times a second and always when done.
  void progress(const std::string& phase, const Progress& progress);
  // A sentence on stderr, and an event.
  void note(const std::string& sentence);
  void warning(const std::string& sentence);
  // Lines for people only.
  void say(const std::string& text);
  void error(const Failure& failure);
  // An event of its own, e.g. "plan", "file", "result".
  void event(const std::string& name, nlohmann::ordered_json fields);
  // Data for people: a line on stdout, unless JSON was asked for.
  void result_line(const std::string& line);
  // Data for programs: the one object of a verb that prints no events, when JSON was asked for.
  void result_json(const nlohmann::ordered_json& object);

  // --json was given.
  [[nodiscard]] bool json() const { return json_; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Pace {
    Time began{};
    std::optional<Time> shown;
    std::optional<Time> logged;
  };

  void clear_bar();
  void draw_bar(const Progress& progress, std::optional<double> eta_s);
  void plain_line(const Progress& progress, std::optional<double> eta_s);
  [[nodiscard]] std::string styled(const char* code, const std::string& text) const;

  std::mutex mutex_;
  std::ostream& out_;
  std::ostream& talk_;
  const bool json_;
  const bool quiet_;
  const bool bar_;
  const bool color_;
  const Now now_;
  std::unique_ptr<EventLog> events_;
  std::string foreground_;
  Pace front_;
  Pace back_;
  std::string background_;
  std::size_t bar_width_ = 0;  // columns to wipe before the next line
};

// "18 s", "4 min 10 s", "1 h 05 min".
[[nodiscard]] std::string human_seconds(double seconds);
// "188.1 MB", decimal.
[[nodiscard]] std::string human_bytes(double bytes);
// Remaining seconds from the pace so far; absent while there is nothing to go by.
[[nodiscard]] std::optional<double> eta_seconds(double done, double total, double elapsed_s);

}  // namespace reseau::cli
