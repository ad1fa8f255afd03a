#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/failure.h"
#include "capture/cli/scan_choice.h"
#include "capture/cli/scan_talk.h"
#include "capture/cli/verbs.h"
#include "capture/image/png_writer.h"
#include "capture/store/part_file.h"
#include "core/line/line_block.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

struct PreviewChoice {
  std::string device, output = "preview.png";
};

// Lines of red, green and blue, as they came.
struct Strip {
  LineFormat format;
  std::vector<std::uint16_t> samples;
  int n_lines = 0;
};

Strip read_strip(Scanner& scanner, Work& work) {
  ScanRequest request;
  request.overview = true;
  const ScanPlan plan = scanner.negotiate(request).plan;
  ScanTalk talk(work.reporter);
  Strip strip;
  strip.format = plan.format;
  if (!scanner.start(plan, talk, work.signals.stop())) return strip;
  work.reporter.phase("scan", "overview");
  LineBlock block;
  while (!work.signals.stop().stop_requested() &&
         scanner.read(block, std::chrono::seconds(30)) == ReadStatus::kLines) {
    strip.samples.insert(strip.samples.end(), block.used().begin(), block.used().end());
    strip.n_lines += block.n_lines;
    work.reporter.progress("scan", {static_cast<double>(strip.n_lines),
                                    static_cast<double>(plan.format.n_lines), "lines", 0});
  }
  scanner.stop();
  return strip;
}

// For the eye: a display gamma, nothing else.
void write_png(const Strip& strip, const std::filesystem::path& path) {
  std::vector<std::uint8_t> display(65536);
  for (std::size_t v = 0; v < display.size(); ++v) {
    constexpr double kGamma = 1 / 2.2;
    display[v] = static_cast<std::uint8_t>(
        std::lround(255 * std::pow(static_cast<double>(v) / 65535, kGamma)));
  }
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  PngWriter png(file, strip.format.width_px, strip.n_lines, strip.format.x_dpi);
  const auto width = static_cast<std::size_t>(strip.format.width_px);
  std::vector<std::uint8_t> row(3 * width);
  for (std::size_t line = 0; line < static_cast<std::size_t>(strip.n_lines); ++line) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t x = 0; x < width; ++x) {
        row[3 * x + c] = display[strip.samples[(line * 3 + c) * width + x]];
      }
    }
    png.row(row);
  }
  png.finish();
  file.publish();
}

ExitCode preview(const PreviewChoice& choice, Work& work) {
  const std::filesystem::path file(choice.output);
  refuse_existing(file);
  const PreparedDirectory prepared(file.has_parent_path() ? file.parent_path() : ".");
  const std::string name =
      as_failure(Doing::kReadingOptions, [&] { return choose_device(choice.device); });
  OpenedScanner opened = as_failure(Doing::kOpeningDevice, [&] { return open_scanner(name, {}); });
  const Strip strip =
      as_failure(Doing::kReadingOptions, [&] { return read_strip(*opened.scanner, work); });
  if (work.signals.stop().stop_requested()) return kExitCancelled;
  as_failure(Doing::kWriting, [&] { write_png(strip, file); });

  const Capabilities& c = opened.scanner->capabilities();
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  int number = 0;
  for (const FramePlace& frame : c.frames) {
    ++number;
    frames.push_back({{"frame", number},
                      {"top_mm", frame.top_mm},
                      {"height_mm", frame.height_mm},
                      {"found", frame.found}});
    work.reporter.say(fmt::format("frame {:>2}: {:7.2f} mm{}", number, frame.top_mm,
                                  frame.found ? "" : " (by the adapter's raster)"));
  }
  work.reporter.result_line(choice.output);
  work.reporter.result_json({{"schema", "reseau-preview/1"},
                             {"device", name},
                             {"file", choice.output},
                             {"width_px", strip.format.width_px},
                             {"rows", strip.n_lines},
                             {"y_dpi", strip.format.y_dpi},
                             {"frames", frames}});
  return kExitOk;
}

}  // namespace

void add_preview(Program& program) {
  auto choice = std::make_shared<PreviewChoice>();
  CLI::App* app = program.add_verb(
      "preview",
      "Takes a quick picture of the whole strip or holder, and says where the frames are. The unit "
      "keeps\nthem until the film is changed; 'scan --frame N --frame-offset 0.25mm' moves one of "
      "them.",
      "reseau preview -o strip.png\n"
      "reseau preview -d 'sim:ls5000?frames=4' -o strip.png --json",
      [choice](Work& work) { return preview(*choice, work); });
  program.prints_own_json(app);
  app->add_option("-d,--device-name", choice->device, "The scanner; default the only one");
  app->add_option("-o,--output", choice->output, "The picture, PNG; default preview.png");
}

}  // namespace reseau::cli
