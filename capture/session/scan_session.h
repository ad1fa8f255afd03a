// One scan from the start of the motor to the last line on disk, with whoever develops the picture
// looking over the writer's shoulder.
//
//   thread        owns                    waits for
//   device (run)  scanner, one block      the unit; room in the ring
//   writer        the master              blocks in the ring; the disk
//   develop       the picture             committed lines of the master
//
// Order of death: stop request, the device thread stops the scanner, the ring drains, the master
// closes, the picture finishes, run() returns.
#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "capture/session/queued_sink.h"
#include "core/base/clock.h"
#include "core/line/line_sink.h"
#include "core/line/line_source.h"
#include "drivers/scanner.h"

namespace reseau {

// Told what happens. Calls come from the threads of the session, so it must be thread-safe.
class SessionObserver : public ScanObserver {
 public:
  // Exposure and focus are settled and the master is open.
  virtual void began(const LineFormat& format, const CaptureContext& context) = 0;
  // Lines of the scan that have left the unit, and those that are safe in the master.
  virtual void progress(int lines_read, int lines_committed, int n_lines) = 0;
};

// Runs on the develop thread while lines arrive; returns when it is done with them or when stop is
// requested, which also happens when the scan ends before its last line. What it throws is reported
// in the outcome and harms neither scan nor master.
using DevelopFn = std::function<void(const LineSource& lines, const CaptureContext& context,
                                     const std::stop_token& stop)>;

using SourceFn = std::function<std::shared_ptr<const LineSource>()>;

struct SessionOptions {
  int ring_blocks = 16;
  Duration read_timeout{500'000};       // one wait for lines; stop requests are seen between waits
  Duration silence_limit{120'000'000};  // no line for so long means the unit has died
  Clock* clock = nullptr;               // null: the system's
  DevelopFn develop;                    // empty: only the master
  std::stop_token develop_stop;         // ends develop early
  // Go into the master in place of what the scanner says; empty = the scanner's. A replay gives
  // what the recording says, so that its master is the same file.
  std::string device_name, started_at_utc;
};

struct ScanOutcome {
  ScanEnd end = ScanEnd::kFailed;
  int lines = 0;                          // committed to the master
  std::exception_ptr error;               // why it failed; null when complete or cancelled
  std::exception_ptr develop_error;       // what develop threw
  bool began = false;                     // a master exists
  CaptureContext context;                 // valid when began
  std::optional<TimePoint> last_line_at;  // when the last line came from the scanner; when complete
  QueueStats queue;
  // Up to the first READ; from there to the closed master; from there to the end of develop.
  Duration preparing{}, scanning{}, finishing{};
};

class ScanSession {
 public:
  // Scanner, master and observer outlive the session. `committed` gives the reading side of
  // `master`; it is called once, when master.begin() has returned.
  ScanSession(Scanner& scanner, const ScanPlan& plan, LineSink& master, SourceFn committed,
              SessionObserver& observer, SessionOptions options);

  // Blocks; the calling thread becomes the device thread. Every line that read() delivered is in
  // the master when it returns, whatever happened, unless the disk itself failed. Leaves the
  // scanner stopped. May be called once.
  [[nodiscard]] ScanOutcome run(const std::stop_token& stop) noexcept;

 private:
  [[nodiscard]] ScanEnd read_lines(QueuedSink& queue, const std::stop_token& stop);

  Scanner& scanner_;
  ScanPlan plan_;
  LineSink& master_;
  SourceFn source_of_master_;
  std::shared_ptr<const LineSource> committed_;
  SessionObserver& observer_;
  SessionOptions options_;
  SystemClock system_clock_;
};

}  // namespace reseau
