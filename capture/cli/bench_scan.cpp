#include "capture/cli/bench_scan.h"

#include <cerrno>
#include <chrono>
#include <exception>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include "capture/cli/failure.h"
#include "capture/cli/scan_talk.h"
#include "capture/session/scan_session.h"
#include "capture/store/master_writer.h"
#include "core/base/error.h"
#include "core/line/line_block.h"

namespace reseau::cli {
namespace {

// However the scan is left, the unit is idle afterwards.
class StopAtEnd {
 public:
  explicit StopAtEnd(Scanner& scanner) : scanner_(scanner) {}
  ~StopAtEnd() { scanner_.stop(); }
  StopAtEnd(const StopAtEnd&) = delete;
  StopAtEnd& operator=(const StopAtEnd&) = delete;

 private:
  Scanner& scanner_;
};

}  // namespace

std::string device_with(const std::string& name, const std::string& target, bool replace) {
  if (!name.starts_with("sim:")) return name;
  const std::size_t query = name.find('?');
  std::string head = name.substr(0, query), kept;
  std::string rest = query == std::string::npos ? std::string() : name.substr(query + 1);
  bool says = false;
  while (!rest.empty()) {
    const std::size_t end = rest.find('&');
    const std::string key = rest.substr(0, end);
    rest = end == std::string::npos ? std::string() : rest.substr(end + 1);
    const bool of_film = key.starts_with("film=") || key.starts_with("scene=") ||
                         key.starts_with("image=") || key.starts_with("screen=");
    says = says || of_film;
    if (of_film && replace) continue;
    kept += (kept.empty() ? "" : "&") + key;
  }
  // What lies in the unit comes first, so that other keys can change it.
  if (!says || replace) kept = "film=" + target + (kept.empty() ? "" : "&") + kept;
  return head.append("?").append(kept);
}

bool scan_to_file(Scanner& scanner, const ScanPlan& plan, const std::string& device_name,
                  const std::filesystem::path& path, Work& work) {
  ScanTalk talk(work.reporter);
  MasterOptions options;
  options.path = path;
  MasterWriter master(options);
  SessionOptions session_options;
  session_options.device_name = device_name;
  session_options.started_at_utc = utc_now(false);
  ScanSession session(
      scanner, plan, master, [&master] { return master.source(); }, talk, session_options);
  const ScanOutcome outcome = session.run(work.signals.stop());
  if (outcome.error) std::rethrow_exception(outcome.error);
  if (outcome.end == ScanEnd::kCancelled) return false;
  if (master.result().error) std::rethrow_exception(master.result().error);
  return true;
}

std::optional<BenchScan> scan_to_memory(Scanner& scanner, const ScanPlan& plan, Work& work) {
  ScanTalk talk(work.reporter);
  const StopAtEnd stop_at_end(scanner);
  if (!scanner.start(plan, talk, work.signals.stop())) return std::nullopt;
  BenchScan out;
  out.context = scanner.context();
  out.width_px = plan.format.width_px;
  out.sensor_lines = plan.sensor_lines;
  constexpr std::array kChannels{Channel::kRed, Channel::kGreen, Channel::kBlue,
                                 Channel::kInfrared};
  std::array<int, 4> planes{};
  for (std::size_t c = 0; c < kChannels.size(); ++c) planes[c] = plan.format.plane_of(kChannels[c]);
  LineBlock block;
  const auto begun = std::chrono::steady_clock::now();
  constexpr std::chrono::minutes kSilence{2};
  auto last = begun;
  while (out.n_lines < plan.format.n_lines) {
    if (work.signals.stop().stop_requested()) return std::nullopt;
    const ReadStatus status = scanner.read(block, Duration{500'000});
    if (status == ReadStatus::kEndOfScan) break;
    if (status == ReadStatus::kNotReady) {
      if (std::chrono::steady_clock::now() - last < kSilence) continue;
      throw DeviceError(DeviceError::Kind::kTimeout,
                        "The scanner has sent nothing for two minutes. Switch it off and on, then "
                        "calibrate again.",
                        "READ answered not ready until the limit");
    }
    last = std::chrono::steady_clock::now();
    for (int line = 0; line < block.n_lines; ++line) {
      for (std::size_t c = 0; c < planes.size(); ++c) {
        if (planes[c] < 0) continue;
        for (const std::uint16_t sample : block.plane(line, planes[c])) {
          out.light[c].push_back(static_cast<float>(sample) / 65535.0F);
        }
      }
    }
    out.n_lines += block.n_lines;
  }
  if (out.n_lines == 0) {
    throw DeviceError(DeviceError::Kind::kProtocol,
                      "The scanner ended the scan without a line. Calibrate again.",
                      "end of scan before the first line");
  }
  return out;
}

bool ask(const std::string& sentence, bool yes, Work& work) {
  work.reporter.say(sentence + (yes ? "" : " Then press Enter."));
  if (yes) return !work.signals.stop().stop_requested();
  while (!work.signals.stop().stop_requested()) {
    pollfd waiting{STDIN_FILENO, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, 200);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    char c = 0;
    const ssize_t n = ready < 0 ? -1 : ::read(STDIN_FILENO, &c, 1);
    if (n <= 0) {
      throw Failure(kExitUsage, "Nobody is there to answer.",
                    "Give --yes when everything is in place.");
    }
    if (c == '\n') return true;
  }
  return false;
}

}  // namespace reseau::cli
