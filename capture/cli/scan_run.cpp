#include "capture/cli/scan_run.h"

#include <atomic>
#include <memory>
#include <optional>
#include <stop_token>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"
#include "capture/cli/scan_finish.h"
#include "capture/cli/scan_page.h"
#include "capture/cli/scan_talk.h"
#include "capture/color/color_record.h"
#include "capture/session/request_json.h"
#include "capture/session/scan_session.h"
#include "capture/session/unit_profile.h"
#include "capture/store/master_writer.h"
#include "capture/store/names.h"
#include "core/line/capture_context.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

bool starts_with(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

struct Opened {
  OpenedScanner device;
  RecordedRequest asked;  // the recording's own when it is replayed and nothing else was asked for
};

Opened open_device(const ScanJob& job, Reporter& reporter) {
  RecordedRequest asked{job.scan.request(), choose_device(job.scan.device), utc_now(false)};
  OpenOptions options;
  if (!job.record.empty() && !job.dont_scan) {
    refuse_existing(job.record);
    options.record_to = job.record;
    options.record_comment = recorded_request_to_json(asked);
  }
  options.replay_speed = job.replay_speed;
  options.replay_fault = job.replay_fault;
  const bool replayed = starts_with(asked.device_name, "replay:");
  OpenedScanner device = as_failure(replayed ? Doing::kReadingInput : Doing::kOpeningDevice,
                                    [&] { return open_scanner(asked.device_name, options); });
  if (replayed) {
    const auto recorded = as_failure(Doing::kReadingInput, [&] {
      return recorded_request_from_json(device.recorded_comment, asked.device_name);
    });
    if (recorded) {
      asked.device_name = recorded->device_name;
      asked.started_at_utc = recorded->started_at_utc;
      if (job.scan.is_default()) asked.request = recorded->request;
    } else if (!device.recorded_at_utc.empty()) {
      asked.started_at_utc = device.recorded_at_utc;
      reporter.note(
          "The recording does not say what was asked of the scanner; trying with the options "
          "given.");
    }
  }
  return {std::move(device), std::move(asked)};
}

void announce(const Negotiated& negotiated, const Capabilities& capabilities,
              const std::string& device_name, const std::string& place, Reporter& reporter) {
  reporter.say(device_line(capabilities));
  nlohmann::ordered_json adjusted = nlohmann::ordered_json::array();
  for (const Adjustment& a : negotiated.adjusted) {
    adjusted.push_back(
        {{"field", a.field}, {"asked", a.asked}, {"granted", a.granted}, {"why", a.why}});
    reporter.say(adjustment_line(a));
  }
  reporter.say(plan_line(negotiated.plan, place));
  const LineFormat& format = negotiated.plan.format;
  reporter.event("plan", {{"device", device_name},
                          {"model", capabilities.model},
                          {"frames", 1},
                          {"resolution_dpi", negotiated.plan.resolution_dpi},
                          {"infrared", negotiated.plan.infrared},
                          {"depth_bits", negotiated.plan.depth_bits},
                          {"width_px", format.width_px},
                          {"rows", format.n_lines},
                          {"bytes", static_cast<long long>(master_bytes(format))},
                          {"place", place},
                          {"adjusted", adjusted}});
}

void show_end(const ScanRecord& record, ScanPage& page, const std::stop_token& stop) {
  std::error_code none;
  const std::filesystem::path receipt = std::filesystem::exists(record.names.receipt, none)
                                            ? record.names.receipt
                                            : std::filesystem::path();
  if (!record.development) return page.finish({}, receipt, "There is no picture.", stop);
  const Development& d = *record.development;
  if (!d.written) return page.finish({}, receipt, d.why_not, stop);
  page.finish(record.want_view ? record.names.png : std::filesystem::path(), receipt,
              describe_registration(d.registration), stop);
}

}  // namespace

ExitCode run_scan(const ScanJob& job, Work& work) {
  Reporter& reporter = work.reporter;
  const DevelopOptions base =
      as_failure(Doing::kReadingOptions, [&] { return job.picture.resolve(reporter); });
  const ProfileChoice profile =
      as_failure(Doing::kReadingOptions, [&] { return job.picture.resolve_profile(); });
  // The options are looked at before any device is touched.
  as_failure(Doing::kReadingOptions, [&] { static_cast<void>(job.scan.request()); });
  std::optional<ScanPage> page;
  if (job.page.any() && !job.dont_scan) {
    as_failure(Doing::kReadingOptions,
               [&] { page.emplace(job.page, srgb_from_output(base.color), reporter); });
  }
  const std::filesystem::path directory = job.place.directory();
  std::optional<PreparedDirectory> prepared, prepared_record;
  if (!job.dont_scan) prepared.emplace(directory);
  const std::filesystem::path record_folder = std::filesystem::path(job.record).parent_path();
  if (!job.dont_scan && !record_folder.empty()) prepared_record.emplace(record_folder);

  Opened opened = open_device(job, reporter);
  Scanner& scanner = *opened.device.scanner;
  ScanTalk talk(reporter, page ? &*page : nullptr);
  if (job.load && !job.dont_scan) {
    as_failure(Doing::kReadingOptions, [&] { scanner.load(talk); });
  }
  const Negotiated negotiated =
      as_failure(Doing::kReadingOptions, [&] { return scanner.negotiate(opened.asked.request); });
  // A calibration that was named and is another unit's must not cost a scan's time.
  as_failure(Doing::kReadingInput, [&] {
    CaptureContext unit;
    unit.make = scanner.capabilities().make;
    unit.model = scanner.capabilities().model;
    unit.serial = scanner.capabilities().serial;
    static_cast<void>(use_profile(profile, unit, negotiated.plan.format.x_dpi));
  });
  announce(negotiated, scanner.capabilities(), opened.asked.device_name, directory.string(),
           reporter);
  if (job.dont_scan) return kExitOk;

  const NameReservation name = as_failure(Doing::kWriting, [&] {
    return job.place.exact_name().empty() ? reserve_numbered(directory, job.place.stem())
                                          : reserve_exact(directory, job.place.exact_name());
  });
  MasterOptions master_options;
  master_options.path = name.path(".tif");
  master_options.film = job.place.film;
  MasterWriter master(master_options);

  // The first Ctrl-C ends the scan and lets the picture of what is there finish; when all lines are
  // in, it ends the picture.
  std::atomic<bool> scanned = false;
  std::stop_source end_develop;
  const std::stop_callback on_stop(work.signals.stop(), [&] {
    if (scanned) end_develop.request_stop();
  });
  const std::stop_callback on_hurry(work.signals.hurry(), [&] { end_develop.request_stop(); });

  ScanRecord record;
  record.request = opened.asked.request;
  record.negotiated = negotiated;
  record.settings = base;
  record.settings.dpi = negotiated.plan.format.x_dpi;
  record.names = picture_names(directory, name.name());
  record.recording = job.record;
  record.want_view = !job.picture.no_view;
  record.want_picture = !job.no_reconstruct;
  record.quality = job.picture.quality;

  SessionOptions session_options;
  session_options.device_name = opened.asked.device_name;
  session_options.started_at_utc = opened.asked.started_at_utc;
  session_options.develop_stop = end_develop.get_token();
  if (record.want_picture) {
    session_options.develop = [&](const LineSource& lines, const CaptureContext& context,
                                  const std::stop_token& stop) {
      record.settings.profile = use_profile(profile, context, lines.format().x_dpi);
      const int n_lines = lines.format().n_lines;
      const DevelopProgress progress = develop_progress(reporter, true, n_lines);
      DevelopOptions options = record.options_with_paths();
      if (page) options.live = &*page;
      record.development = develop(
          lines, options,
          [&](DevelopPhase phase, double fraction) {
            if (phase == DevelopPhase::kReconstruct) {
              scanned = true;
              if (page) page->set_phase("finishing");
            }
            progress(phase, fraction);
          },
          stop);
    };
  }
  ScanSession session(
      scanner, negotiated.plan, master, [&master] { return master.source(); }, talk,
      session_options);
  record.outcome = session.run(work.signals.stop());
  scanned = true;
  if (job.eject) {
    try {
      scanner.eject(talk);
    } catch (const std::exception& error) {
      // The picture is what counts.
      reporter.warning(error.what());
    }
  }
  // Closes the recording, so that it can be hashed, and frees the unit before anything slow.
  opened.device.scanner.reset();
  record.master = master.result();
  const ExitCode code = finish_scan(record, end_develop.get_token(), work);
  if (page) show_end(record, *page, work.signals.stop());
  return code;
}

}  // namespace reseau::cli
