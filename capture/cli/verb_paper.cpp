#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "capture/cli/develop_choice.h"
#include "capture/cli/read_choice.h"
#include "capture/cli/verbs.h"
#include "capture/cli/write_text.h"
#include "capture/color/color_plots.h"
#include "capture/color/paper.h"
#include "capture/color/paper_tables.h"
#include "capture/image/png_writer.h"
#include "capture/session/json_number.h"
#include "core/reconstruct/reconstruct.h"

namespace reseau::cli {

namespace {

using nlohmann::ordered_json;

constexpr int kReseauSide_px = 480, kReseauPeriods = 6;
// As Color-Screen compares: every fourth pixel, a border of 100 left out.
constexpr int kBorder_px = 100, kEvery = 4;

struct PaperArguments {
  std::string output = "paper";
  ReadChoice scan;
  std::string quality = "best";
  double white_level = 1, black_level = kPaperBlack, blur_px = kPaperBlur_px;
};

// Keeps the pixels that are compared, nothing else.
class Sampler final : public RgbRowSink {
 public:
  void begin(int width_px, int height_px) override {
    width_ = width_px;
    height_ = height_px;
  }
  void rows(int first_row, int n_rows, std::span<const float> rgb) override {
    for (int y = first_row; y < first_row + n_rows; ++y) {
      if (y < kBorder_px || y >= height_ - kBorder_px || (y - kBorder_px) % kEvery != 0) continue;
      const float* row = rgb.data() + static_cast<std::ptrdiff_t>(y - first_row) * width_ * 3;
      for (int x = kBorder_px; x < width_ - kBorder_px; x += kEvery) {
        const float* p = row + static_cast<std::ptrdiff_t>(x) * 3;
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) continue;
        intensities.push_back({p[0], p[1], p[2]});
      }
    }
  }
  void end() override {}
  std::vector<Vector3> intensities;

 private:
  int width_ = 0, height_ = 0;
};

std::vector<Vector3> intensities_of(const Scan& scan, const Registration& registration,
                                    const ReconstructOptions& options, const std::string& file,
                                    const std::stop_token& stop) {
  Sampler sampler;
  static_cast<void>(reconstruct(*scan.source, registration, options, sampler, {}, stop));
  if (sampler.intensities.size() < 100) {
    throw Failure(kExitInput,
                  fmt::format("{} is too small: inside a border of {} px hardly a pixel "
                              "is left to compare.",
                              file, kBorder_px));
  }
  return std::move(sampler.intensities);
}

// The scan with Color-Screen's parameters, for the comparison, and by itself.
PaperReport report_of_scan(const PaperArguments& options, Work& work) {
  const std::stop_token stop = work.signals.stop();
  const Scan scan = options.scan.read(work.reporter);
  RegisterOptions register_options;
  register_options.tone = scan.tone;
  const auto registration = register_screen(*scan.source, register_options, {}, stop);
  if (!registration.found) {
    throw Failure(kExitInput, options.scan.file + ": no réseau was found. " + registration.reason);
  }
  ReconstructOptions own;
  own.tone = scan.tone;
  own.white_level = options.white_level;
  own.quality = parse_quality(options.quality);
  ReconstructOptions as_compared = own;
  as_compared.black_level = options.black_level;
  as_compared.blur_px = options.blur_px;
  const std::string& file = options.scan.file;
  return paper_of_scan(
      intensities_of(scan, registration, as_compared, file, stop),
      intensities_of(scan, registration, own, file, stop),
      fmt::format("quality {}, blur {} px and black {}, the two by default those of the parameter "
                  "file of Color-Screen's crop; below, the blur that the scan shows, and no black "
                  "level",
                  options.quality, options.blur_px, options.black_level));
}

void write_png(const std::filesystem::path& path, const std::string& set) {
  const auto pixels = reseau_pixels(paper_reseau_colors(set), kReseauPeriods, kReseauSide_px);
  PartFile file(path, PartFile::Kind::kScratch, Existing::kRefuse);
  PngWriter png(file, kReseauSide_px, kReseauSide_px, 0);
  constexpr std::size_t kRow = std::size_t{3} * kReseauSide_px;
  for (std::size_t at = 0; at < pixels.size(); at += kRow)
    png.row(std::span(pixels).subspan(at, kRow));
  png.finish();
  file.publish();
}

ordered_json json_of(const PaperReport& report, const std::filesystem::path& directory) {
  ordered_json json = {{"schema", "reseau-paper/1"},
                       {"folder", directory.string()},
                       {"held", report.held()},
                       {"figures", ordered_json::array()}};
  for (const PaperFigure& f : report.figures) {
    json["figures"].push_back({{"part", f.part},
                               {"figure", f.what},
                               {"ours", number_or_null(f.ours)},
                               {"published", number_or_null(f.published)},
                               {"limit", f.limit},
                               {"held", f.held},
                               {"remark", f.remark}});
  }
  return json;
}

ExitCode run(const PaperArguments& options, Work& work) {
  if (!(options.white_level > 0) || !std::isfinite(options.white_level)) {
    throw Failure(kExitUsage, "--white must be a number above 0.");
  }
  PaperReport report = make_paper();
  if (!options.scan.file.empty()) {
    const PaperReport more =
        as_failure(Doing::kReadingOptions, [&] { return report_of_scan(options, work); });
    report.scan_parameters = more.scan_parameters;
    report.figures.insert(report.figures.end(), more.figures.begin(), more.figures.end());
    report.files.insert(report.files.end(), more.files.begin(), more.files.end());
  }
  report.files.push_back({"report.txt", paper_text(report)});
  report.files.push_back({"figures.csv", paper_csv(report)});
  const std::filesystem::path directory(options.output);
  const std::filesystem::path png1 = directory / "reseau_tab1.png",
                              png2 = directory / "reseau_tab2.png";
  for (const PaperFile& file : report.files) refuse_existing(directory / file.name);
  refuse_existing(png1);
  refuse_existing(png2);
  prepare_directory(directory);
  for (const PaperFile& file : report.files) {
    write_text((directory / file.name).string(), file.text, work.reporter);
  }
  write_png(png1, "cornwell-clyne-1951-tab1");
  write_png(png2, "hubicka-2025");
  work.reporter.result_json(json_of(report, directory));
  work.reporter.result_line(paper_text(report));
  if (report.held()) return kExitOk;
  work.reporter.warning("Some figures lie outside their limits; the report says which (NOT HELD).");
  return kExitChecks;
}

}  // namespace

void add_paper(Program& program) {
  auto options = std::make_shared<PaperArguments>();
  CLI::App* app = program.add_verb(
      "paper",
      "Recomputes the tables and figures of Hubička, Kimrová, Konečný (arXiv:2501.06216) from the "
      "printed\nsources and sets them beside the published ones: report.txt, figures.csv, tab1.csv "
      "to tab4.csv,\nplots (SVG) and the simulated réseau (SVG, PNG). Exit code 1 when a figure "
      "lies "
      "outside its limit.",
      "reseau paper -o paper\n"
      "reseau paper --scan party.tif -o paper_with_scan",
      [options](Work& work) { return run(*options, work); });
  app->add_option("-o,--output", options->output, "Folder for the files; default 'paper'")
      ->group("Files");
  app->add_option("--scan", options->scan.file,
                  "A scan with infrared: the colour differences on its own pixels as well")
      ->group("Scan");
  app->add_option("--gamma", options->scan.gamma,
                  "Encoding gamma of the scan; overrides an embedded profile")
      ->group("Scan");
  app->add_option("--quality", options->quality,
                  "Of the reconstruction: draft, standard or best (default)")
      ->group("Scan");
  app->add_option("--white", options->white_level,
                  "Linear value of clear film in the scan, 1 = full scale (default 1)")
      ->group("Scan");
  app->add_option("--black", options->black_level,
                  "Linear value of the scan without light, for the comparison with Color-Screen; "
                  "default 0.014328,\nas its crop says")
      ->group("Scan");
  app->add_option("--blur", options->blur_px,
                  "Blur to undo in the comparison [px]; default 0.5, as Color-Screen's crop says")
      ->group("Scan");
  program.prints_own_json(app);
}

}  // namespace reseau::cli
