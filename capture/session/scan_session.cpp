#include "capture/session/scan_session.h"

#include <thread>
#include <utility>

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {

namespace {

void check_block(const LineBlock& block, const LineFormat& format, int next_line) {
  const bool fits =
      block.first_line == next_line && block.n_lines > 0 &&
      block.n_lines <= format.n_lines - next_line && block.width_px == format.width_px &&
      block.n_channels == format.n_channels() &&
      block.samples.size() >= static_cast<std::size_t>(block.n_lines) * format.samples_per_line();
  if (fits) return;
  throw DeviceError(
      DeviceError::Kind::kProtocol,
      fmt::format("The scanner sent lines that do not belong where they came, at line {} of {}. "
                  "The lines before are kept. Scan again.",
                  next_line, format.n_lines),
      fmt::format("expected line {} width {} channels {}, got line {} +{} width {} channels {}",
                  next_line, format.width_px, format.n_channels(), block.first_line, block.n_lines,
                  block.width_px, block.n_channels));
}

}  // namespace

ScanSession::ScanSession(Scanner& scanner, const ScanPlan& plan, LineSink& master,
                         SourceFn committed, SessionObserver& observer, SessionOptions options)
    : scanner_(scanner),
      plan_(plan),
      master_(master),
      source_of_master_(std::move(committed)),
      observer_(observer),
      options_(std::move(options)) {
  if (options_.clock == nullptr) options_.clock = &system_clock_;
  CHECK(options_.ring_blocks >= 1);
}

ScanOutcome ScanSession::run(const std::stop_token& stop) noexcept {
  ScanOutcome outcome;
  Clock& clock = *options_.clock;
  const TimePoint started = clock.now();
  QueuedSink queue(master_, options_.ring_blocks);
  std::stop_source end_develop;
  const std::stop_callback on_develop_stop(options_.develop_stop,
                                           [&end_develop] { end_develop.request_stop(); });
  std::jthread develop;
  try {
    if (!scanner_.start(plan_, observer_, stop)) {
      scanner_.stop();
      outcome.end = ScanEnd::kCancelled;
      return outcome;
    }
    outcome.context = scanner_.context();
    if (!options_.device_name.empty()) outcome.context.device_name = options_.device_name;
    if (!options_.started_at_utc.empty()) outcome.context.started_at_utc = options_.started_at_utc;
    queue.begin(plan_.format, outcome.context);
    committed_ = source_of_master_();
    CHECK(committed_ != nullptr);
    outcome.began = true;
    outcome.preparing = clock.now() - started;
    observer_.began(plan_.format, outcome.context);
    if (options_.develop) {
      develop = std::jthread([this, &outcome, stop_develop = end_develop.get_token()]() noexcept {
        try {
          options_.develop(*committed_, outcome.context, stop_develop);
        } catch (...) {
          outcome.develop_error = std::current_exception();
        }
      });
    }
    outcome.end = read_lines(queue, stop);
    if (outcome.end == ScanEnd::kComplete) outcome.last_line_at = clock.now();
  } catch (...) {
    outcome.error = std::current_exception();
    outcome.end = ScanEnd::kFailed;
  }
  if (const std::string notice = scanner_.stop_notice(); !notice.empty()) observer_.note(notice);
  scanner_.stop();
  queue.end(outcome.end);
  if (queue.error()) {
    outcome.end = ScanEnd::kFailed;
    if (!outcome.error) outcome.error = queue.error();
  }
  outcome.queue = queue.stats();
  if (outcome.began) {
    outcome.scanning = clock.now() - started - outcome.preparing;
    outcome.lines = committed_->committed();
  }
  // What it makes of a scan that broke off is of no use: the caller opens that as a shorter file.
  if (outcome.end != ScanEnd::kComplete) end_develop.request_stop();
  const TimePoint closed = clock.now();
  if (develop.joinable()) develop.join();
  outcome.finishing = clock.now() - closed;
  return outcome;
}

ScanEnd ScanSession::read_lines(QueuedSink& queue, const std::stop_token& stop) {
  const int n_lines = plan_.format.n_lines;
  Clock& clock = *options_.clock;
  TimePoint last_line = clock.now();
  LineBlock block;
  int next_line = 0;
  while (true) {
    if (stop.stop_requested()) return ScanEnd::kCancelled;
    switch (scanner_.read(block, options_.read_timeout)) {
      case ReadStatus::kLines:
        check_block(block, plan_.format, next_line);
        queue.lines(block);
        next_line += block.n_lines;
        last_line = clock.now();
        observer_.progress(next_line, committed_->committed(), n_lines);
        break;
      case ReadStatus::kNotReady:
        if (clock.now() - last_line > options_.silence_limit) {
          throw DeviceError(
              DeviceError::Kind::kTimeout,
              fmt::format("The scanner has sent nothing for {} seconds, at line {} of {}. Look "
                          "whether the film moves; switch the scanner off and on if it does not, "
                          "then scan again.",
                          options_.silence_limit.count() / 1'000'000, next_line, n_lines),
              "READ answered not ready until the limit");
        }
        break;
      case ReadStatus::kEndOfScan:
        if (next_line == n_lines) return ScanEnd::kComplete;
        throw DeviceError(
            DeviceError::Kind::kProtocol,
            fmt::format("The scanner ended the scan after {} of {} lines. Scan again.", next_line,
                        n_lines),
            "end of scan before the last line");
    }
  }
}

}  // namespace reseau
