#include "capture/cli/develop_choice.h"

#include <cerrno>
#include <cmath>
#include <memory>
#include <system_error>

#include <fmt/format.h>
#include <unistd.h>

#include "capture/cli/failure.h"
#include "capture/cli/pixel_area.h"
#include "core/base/error.h"

namespace reseau::cli {
namespace {

PixelBounds bounds_of(const std::string& roi) {
  const auto [x, y, width, height] = parse_pixel_area("--roi", roi);
  constexpr int kMost = 1 << 24;
  if (x < 0 || y < 0 || x > kMost || y > kMost || width < 1 || height < 1 || width > kMost ||
      height > kMost) {
    throw InputError(fmt::format("--roi {} cannot be: x and y begin at 0, sizes at 1.", roi));
  }
  return {x, y, x + width, y + height};
}

}  // namespace

void DevelopChoice::add_to(CLI::App& app) {
  const char* const group = "Picture";
  app.add_option(
         "--geometry", geometry,
         "scan: orientation of the scan (default); film: turned until the edges of the film "
         "are upright;\nscreen: the axes of the réseau upright, bends taken out")
      ->check(CLI::IsMember({"scan", "film", "screen"}))
      ->group(group);
  app.add_option("--scale", scale, "Pixels of the picture per pixel of the scan (default 1)")
      ->check(CLI::Range(1.0 / 64, 8.0))
      ->group(group);
  app.add_option("--roi", roi, "Only this part of the scan, in pixels, as x,y,w,h")->group(group);
  app.add_option("--quality", quality,
                 "draft, standard (default) or best: coarser and faster, or finer and slower")
      ->check(CLI::IsMember({"draft", "standard", "best"}))
      ->group(group);
  app.add_option("--demosaic", demosaic,
                 "How elements become a picture: nearest, bilinear (that of draft), bicubic "
                 "(standard),\nratio (bicubic, as bright as the silver is), joint (best); default: "
                 "that of the quality")
      ->check(CLI::IsMember({"nearest", "bilinear", "bicubic", "ratio", "joint"}))
      ->group(group);
  app.add_option(
         "--deconvolve", deconvolve,
         "Take back the blur of the silver before its elements are looked at: none, "
         "wiener, richardson-lucy\n(which stops when noise has doubled, after 10 iterations "
         "at most), or auto (default): wiener before\n'joint' where all of the frame is "
         "softer than 1.2 px, with little noise")
      ->check(CLI::IsMember({"auto", "none", "wiener", "richardson-lucy"}))
      ->group(group);
  app.add_option("--white", white_level,
                 "Linear value of clear film in the scan, 1 = full scale (default 1)")
      ->group(group);
  app.add_option("--black", black_level,
                 "Linear value of the scan without light, 1 = full scale (default 0)")
      ->group(group);
  app.add_option(
         "--silver-from", silver,
         "infrared (default; where there is none, red, green and blue), rgb, or a file: the "
         "receipt of a scan\nof the same scanner and film that has infrared, or such a scan")
      ->group(group);
  app.add_option("--profile", profile,
                 "Calibration of the scanner: auto (default; the newest that is kept of this unit "
                 "at this\nresolution), none, or a file that 'reseau calibrate' wrote")
      ->group(group);
  app.add_option("--blur", blur_px,
                 "Blur of the silver picture to undo, standard deviation in pixels; default: what "
                 "the scan shows")
      ->group(group);
  app.add_option("--threads", n_threads, "Threads; 0 = all cores (default)")
      ->check(CLI::Range(0, 1024))
      ->group(group);
  app.add_flag("--exact", exact, "No shortcut that changes a pixel")->group(group);
  color.add_to(app);
  app.add_option("--neutral", neutral,
                 "Make neutral: auto (the picture on average), or an area in pixels as x,y,w,h")
      ->group(group);
  app.add_option("--view-gamut", view_gamut,
                 "Colours outside sRGB in the view copies: clip (default) or perceptual")
      ->group(group);
  app.add_flag("--no-view", no_view, "Only the EXR, no PNG and TIFF copies for viewing")
      ->group(group);
}

DevelopOptions DevelopChoice::resolve(Reporter& reporter) const {
  if (!std::isfinite(white_level) || white_level <= 0 || white_level > 16) {
    throw InputError(fmt::format(
        "--white {} cannot be. It is the linear value of clear film, between 0 and 16; 1 is full "
        "scale.",
        white_level));
  }
  if (!std::isfinite(black_level) || black_level < 0 || black_level >= white_level) {
    throw InputError(fmt::format(
        "--black {} cannot be. It is the linear value of the scan without light, from 0 to below "
        "that of clear film, {}.",
        black_level, white_level));
  }
  DevelopOptions options;
  options.color = color.resolve(reporter);
  options.view_gamut = parse_view_gamut(view_gamut);
  options.white_level = white_level;
  options.black_level = black_level;
  if (blur_px && !(*blur_px > 0 && *blur_px <= 10)) {
    throw InputError(fmt::format(
        "--blur {} cannot be. It is a standard deviation in pixels, above 0 and at most 10.",
        *blur_px));
  }
  options.blur_px = blur_px;
  options.silver = parse_silver_choice(silver);
  if (!neutral.empty()) options.neutral = parse_neutral_area(neutral);
  options.n_threads = n_threads;
  options.exact = exact;
  options.quality = parse_quality(quality);
  if (deconvolve != "auto") options.deconvolution = parse_deconvolution(deconvolve);
  if (!demosaic.empty()) options.demosaic = parse_demosaic(demosaic);
  options.frame.geometry = parse_geometry(geometry);
  options.frame.scale = scale;
  if (!roi.empty()) options.frame.region = bounds_of(roi);
  return options;
}

PictureNames picture_names(const std::filesystem::path& directory, const std::string& name) {
  return {directory / (name + ".exr"), directory / (name + ".png"),
          directory / (name + "_view.tif"), directory / (name + ".json")};
}

void prepare_directory(const std::filesystem::path& directory) {
  std::error_code problem;
  std::filesystem::create_directories(directory, problem);
  if (problem || !std::filesystem::is_directory(directory)) {
    throw Failure(kExitOutput,
                  fmt::format("The folder {} cannot be made: {}.", directory.string(),
                              problem ? problem.message() : "a file of that name is in the way"),
                  "Choose another folder with -o.");
  }
  if (::access(directory.c_str(), W_OK | X_OK) != 0) {
    throw Failure(kExitOutput,
                  fmt::format("The folder {} cannot be written: {}.", directory.string(),
                              std::generic_category().message(errno)),
                  "Choose another folder with -o, or change its permissions.");
  }
}

PreparedDirectory::PreparedDirectory(const std::filesystem::path& directory) {
  std::error_code ignored;
  std::filesystem::path missing = directory.lexically_normal();
  if (!missing.has_filename()) missing = missing.parent_path();  // "out/"
  while (!missing.empty() && !std::filesystem::exists(missing, ignored)) {
    made_.push_back(missing);
    missing = missing.parent_path();
  }
  prepare_directory(directory);
}

PreparedDirectory::~PreparedDirectory() {
  std::error_code not_empty;
  for (const std::filesystem::path& directory : made_) {
    if (!std::filesystem::remove(directory, not_empty)) return;
  }
}

void refuse_existing(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::symlink_status(path, ignored).type() ==
      std::filesystem::file_type::not_found) {
    return;
  }
  throw Failure(kExitOutput, fmt::format("{} exists already; nothing was done.", path.string()),
                "Choose another name or folder, or move that file away.");
}

DevelopProgress develop_progress(Reporter& reporter, bool scanning, int n_lines) {
  auto phase_now = std::make_shared<std::optional<DevelopPhase>>();
  return [&reporter, scanning, n_lines, phase_now](DevelopPhase phase, double fraction) {
    const bool registering = phase == DevelopPhase::kRegister;
    const char* const name = registering ? "register" : "reconstruct";
    if (*phase_now != phase) {
      *phase_now = phase;
      reporter.phase(name, registering ? "looking for the réseau" : "", registering && scanning);
    }
    reporter.progress(name,
                      {std::floor(fraction * n_lines), static_cast<double>(n_lines), "lines", 0});
  };
}

std::string describe_registration(const Registration& r) {
  if (!r.found) return "no réseau: " + r.reason;
  std::string text = fmt::format("{}, confidence {:.2f}, turned {:.2f}°, fits within {:.3f} px",
                                 r.screen, r.confidence, r.angle_deg, r.residual_px);
  if (r.left_out_px) {
    text += r.lines_alone ? fmt::format(", {:.3f} px", r.left_out_px->y)
                          : fmt::format(", {:.3f} x {:.3f} px", r.left_out_px->x, r.left_out_px->y);
    text += " on what was left out of the fit";
  }
  const LineError& line = r.map.line_error();
  if (!line.none()) {
    text += fmt::format(", an error of the stage along {}",
                        line.axis == LineError::Axis::kColumns ? "x" : "y");
  }
  if (r.period_um[1] > 0) text += fmt::format(", {:.1f} lines/mm", 1000 / r.period_um[1]);
  return text;
}

std::string describe_clipping(const ReconstructionReport& report, bool infrared) {
  const auto& c = report.clipped_fraction;
  std::string text = fmt::format("red {:.2f} %, green {:.2f} %, blue {:.2f} %", 100 * c[0],
                                 100 * c[1], 100 * c[2]);
  if (infrared) text += fmt::format(", infrared {:.2f} %", 100 * c[3]);
  return text;
}

}  // namespace reseau::cli
