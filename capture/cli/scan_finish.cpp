#include "capture/cli/scan_finish.h"

#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"
#include "capture/image/scan_reader.h"
#include "capture/session/receipt.h"

namespace reseau::cli {

namespace {

double seconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-6; }

// A scan that broke off still is a picture of its upper part.
void develop_partial(ScanRecord& record, const std::stop_token& stop, Reporter& reporter) {
  refuse_existing(record.names.exr);
  const Scan scan = read_scan(record.master.path);
  record.development = develop(*scan.source, record.options_with_paths(),
                               develop_progress(reporter, false, record.master.n_lines), stop);
}

std::vector<ReceiptFile> files_of(const ScanRecord& record) {
  std::vector<ReceiptFile> files{{"master", record.master.path}};
  if (record.development && record.development->written) {
    files.push_back({"reconstruction", record.names.exr});
    if (record.want_view) {
      files.push_back({"view", record.names.png});
      files.push_back({"view16", record.names.view_tiff});
    }
  }
  if (!record.recording.empty()) files.push_back({"recording", record.recording});
  return files;
}

void write_receipt(const ScanRecord& record, const std::vector<ReceiptFile>& files) {
  Receipt receipt;
  receipt.verb = "scan";
  receipt.written_at = utc_now(false);
  receipt.scan = ReceiptScan{record.request, record.negotiated, record.outcome};
  receipt.input.format = record.negotiated.plan.format;
  receipt.input.format.n_lines = record.master.n_lines;
  receipt.input.context = record.outcome.context;
  receipt.input.tone = "linear";
  receipt.settings = record.settings;
  receipt.quality = record.quality;
  receipt.development = record.development;
  receipt.files = files;
  write_json_file(receipt_to_json(receipt), record.names.receipt);
}

void summarize(const ScanRecord& record, Reporter& reporter) {
  const LineFormat& format = record.negotiated.plan.format;
  reporter.say("");
  reporter.say(
      fmt::format("Master    {}  {} × {} px, {}", record.master.path.string(), format.width_px,
                  record.master.n_lines,
                  record.negotiated.plan.infrared ? "red green blue infrared" : "red green blue"));
  if (record.development) {
    const Development& d = *record.development;
    reporter.say("Réseau    " + describe_registration(d.registration));
    if (d.written && d.report) {
      reporter.say(fmt::format(
          "Picture   {}{}", record.names.exr.string(),
          record.want_view ? ", to look at: " + record.names.png.string() : std::string()));
      reporter.say("Clipped   " + describe_clipping(*d.report, record.negotiated.plan.infrared));
    }
  }
  if (record.development && record.development->live) {
    const LiveReport& live = *record.development->live;
    reporter.say(live.lock_lines == 0
                     ? std::string("Page      nothing provisional: the réseau was not found while "
                                   "lines came")
                     : fmt::format("Page      {} provisional tiles from line {} on, at most {} "
                                   "lines behind the scan head",
                                   live.n_tiles, live.lock_lines, live.largest_lag_lines));
  }
  reporter.say(fmt::format("Receipt   {}", record.names.receipt.string()));
  std::string times =
      fmt::format("Time      {:.1f} s to prepare, {:.1f} s to scan",
                  seconds(record.outcome.preparing), seconds(record.outcome.scanning));
  if (record.outcome.end == ScanEnd::kComplete && record.development &&
      record.development->written) {
    times += fmt::format(", {:.1f} s more to the picture", seconds(record.outcome.finishing));
  }
  reporter.say(times);
}

// The exit code of the scan itself, having said what happened.
ExitCode judge_scan(const ScanRecord& record, Reporter& reporter) {
  const MasterResult& master = record.master;
  const int planned = record.negotiated.plan.format.n_lines;
  const std::string kept = master.path.empty()
                               ? std::string("No line was read; nothing was written.")
                               : fmt::format("{} of {} lines are safe in {}.", master.n_lines,
                                             planned, master.path.string());
  if (record.outcome.end == ScanEnd::kCancelled) {
    reporter.warning("Stopped. " + kept + " The scanner is free.");
    return kExitCancelled;
  }
  if (record.outcome.end == ScanEnd::kFailed) {
    const Failure why = describe(record.outcome.error, Doing::kWriting);
    const bool device = why.code() != kExitOutput && why.code() != kExitInternal;
    const ExitCode code = device && master.n_lines > 0 ? kExitPartial : why.code();
    reporter.error(
        Failure(code, fmt::format("{} {}", why.what(), kept), why.remedy(), why.detail()));
    return code;
  }
  if (master.error) {
    const Failure why = describe(master.error, Doing::kWriting);
    reporter.error(
        Failure(kExitOutput, fmt::format("{} {}", why.what(), kept), why.remedy(), why.detail()));
    return kExitOutput;
  }
  return kExitOk;
}

}  // namespace

DevelopOptions ScanRecord::options_with_paths() const {
  DevelopOptions options = settings;
  options.exr = names.exr;
  if (want_view) {
    options.png = names.png;
    options.tiff = names.view_tiff;
  }
  return options;
}

ExitCode finish_scan(ScanRecord& record, const std::stop_token& stop, Work& work) {
  Reporter& reporter = work.reporter;
  ExitCode code = judge_scan(record, reporter);
  if (record.master.path.empty()) return code;
  reporter.event(
      "file",
      {{"role", "master"}, {"path", record.master.path.string()}, {"rows", record.master.n_lines}});
  // A disk that could not take the master will not take a picture.
  const bool disk_failed = code == kExitOutput;
  std::exception_ptr picture_error = record.outcome.develop_error;
  const bool cut_short = record.outcome.end != ScanEnd::kComplete;
  if (cut_short) {
    // NAME.partial.tif goes with NAME.partial.exr.
    record.names =
        picture_names(record.master.path.parent_path(), record.master.path.stem().string());
  }
  if (cut_short && record.want_picture && !disk_failed && !stop.stop_requested()) {
    picture_error = nullptr;
    try {
      develop_partial(record, stop, reporter);
    } catch (...) {
      picture_error = std::current_exception();
      record.development.reset();
    }
  }
  if (disk_failed) return code;
  if (picture_error) {
    const Failure why = describe(picture_error, Doing::kWriting);
    reporter.error(Failure(
        why.code(), fmt::format("{} The master is kept.", why.what()),
        fmt::format("reseau reconstruct {} -o FOLDER", record.master.path.string()), why.detail()));
    if (code == kExitOk) code = why.code();
  } else if (record.development && !record.development->written) {
    reporter.warning(
        fmt::format("{} The master is kept, there is no picture.", record.development->why_not));
    if (record.development->stopped && code == kExitOk) code = kExitCancelled;
  }
  const std::vector<ReceiptFile> files = files_of(record);
  write_receipt(record, files);
  for (std::size_t i = 1; i < files.size(); ++i) {
    reporter.event("file", {{"role", files[i].role}, {"path", files[i].path.string()}});
  }
  reporter.event("file", {{"role", "receipt"}, {"path", record.names.receipt.string()}});
  summarize(record, reporter);
  const bool written = record.development && record.development->written;
  reporter.result_line(written ? record.names.exr.string() : record.master.path.string());
  return code;
}

}  // namespace reseau::cli
