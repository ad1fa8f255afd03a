#include "capture/cli/scan_choice.h"

#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "capture/cli/event_log.h"
#include "capture/cli/failure.h"
#include "capture/cli/units.h"
#include "core/base/error.h"
#include "drivers/registry.h"

namespace reseau::cli {

namespace {

constexpr std::array<const char*, 4> kExposureOptions{"--red-exposure", "--green-exposure",
                                                      "--blue-exposure", "--infrared-exposure"};

std::optional<double> optional_mm(const std::string& option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  return parse_mm(option, text);
}

bool is_our_device_name(std::string_view name) {
  for (const std::string_view scheme : {"usb:", "sim:", "replay:", "sg:"}) {
    if (name.substr(0, scheme.size()) == scheme) return true;
  }
  return false;
}

}  // namespace

void ScanChoice::add_to(CLI::App& app) {
  const char* const group = "Scan";
  app.add_option("-d,--device-name,--device", device,
                 "usb:04b0:4002, sim:ls5000, replay:FILE …; also RESEAU_DEVICE, "
                 "SANE_DEFAULT_DEVICE")
      ->group(group);
  app.add_option("--resolution", resolution, "For example 4000dpi; default the optical one")
      ->group(group);
  app.add_option("--depth", depth, "Bits per sample; default the deepest")->group(group);
  app.add_option("--infrared", infrared, "yes (default) or no")->expected(0, 1)->group(group);
  app.add_option("--focus", focus, "A focus position, or 'keep'")->group(group);
  app.add_option("--autofocus", autofocus, "yes (default) or no")->expected(0, 1)->group(group);
  app.add_option("--focus-x,--focusx", focus_x, "Focus at this point of the frame, across; 12mm")
      ->group(group);
  app.add_option("--focus-y,--focusy", focus_y, "The same, along")->group(group);
  for (std::size_t i = 0; i < exposure.size(); ++i) {
    app.add_option(kExposureOptions[i], exposure[i], "For example 800us; default metered")
        ->group(group);
  }
  app.add_option("--exposure", exposure_factor, "Factor on the metered exposure")->group(group);
  app.add_option("--exposure-lock", exposure_lock,
                 "yes (default): colours keep the scanner's balance; no: each is metered alone, as "
                 "for negatives")
      ->group(group);
  app.add_option("--samples,--samples-per-scan", samples,
                 "Readings of each line, averaged; default 1")
      ->check(CLI::Range(1, 16))
      ->group(group);
  app.add_option("--sensor-lines", sensor_lines,
                 "auto (default), one (slower, no difference between lines), or all")
      ->group(group);
  app.add_option("-l", left, "Left edge of the area, for example 2mm")->group(group);
  app.add_option("-t", top, "Top edge")->group(group);
  app.add_option("-x", width, "Width")->group(group);
  app.add_option("-y", height, "Height")->group(group);
  app.add_option("--frame", frame, "Frame on the strip or in the feeder")
      ->check(CLI::Range(1, 1000))
      ->group(group);
  app.add_option("--frame-offset,--subframe", frame_offset,
                 "Moves this frame along the film, for example 0.25mm or -0.5mm")
      ->group(group);
}

bool ScanChoice::is_default() const {
  const ScanChoice plain;
  return resolution.empty() && depth.empty() && infrared.empty() && focus.empty() &&
         autofocus.empty() && exposure == plain.exposure && left.empty() && top.empty() &&
         width.empty() && height.empty() && exposure_factor == plain.exposure_factor &&
         frame == plain.frame && focus_x.empty() && focus_y.empty() && frame_offset.empty() &&
         sensor_lines.empty() && exposure_lock.empty() && samples == plain.samples;
}

ScanRequest ScanChoice::request() const {
  ScanRequest request;
  if (!resolution.empty()) request.resolution_dpi = parse_dpi("--resolution", resolution);
  request.area = {optional_mm("-l", left), optional_mm("-t", top), optional_mm("-x", width),
                  optional_mm("-y", height)};
  if (!depth.empty()) request.depth_bits = parse_count("--depth", depth, 1, 16);
  if (!infrared.empty()) request.infrared = parse_yes_no("--infrared", infrared);
  const bool auto_focus = autofocus.empty() || parse_yes_no("--autofocus", autofocus);
  if (focus == "keep" || (focus.empty() && !auto_focus)) {
    request.focus.mode = FocusRequest::Mode::kKeep;
  } else if (!focus.empty()) {
    request.focus.mode = FocusRequest::Mode::kPosition;
    request.focus.position = parse_count("--focus", focus, 0, 1 << 20);
  }
  if (!autofocus.empty() && auto_focus && !focus.empty()) {
    throw InputError("--focus and --autofocus exclude each other. Leave one of them out.");
  }
  for (std::size_t i = 0; i < exposure.size(); ++i) {
    if (exposure[i].empty()) continue;
    request.exposure.mode = ExposureRequest::Mode::kFixed;
    request.exposure.exposure_us[i] = parse_us(kExposureOptions[i], exposure[i]);
  }
  if (!std::isfinite(exposure_factor) || exposure_factor <= 0) {
    throw InputError("--exposure is a factor above 0, for example 1.4.");
  }
  request.exposure.factor = exposure_factor;
  request.exposure.lock = exposure_lock.empty() || parse_yes_no("--exposure-lock", exposure_lock);
  request.focus.x_mm = optional_mm("--focus-x", focus_x);
  request.focus.y_mm = optional_mm("--focus-y", focus_y);
  request.frame = frame;
  request.frame_offset_mm = optional_mm("--frame-offset", frame_offset).value_or(0);
  request.samples = samples;
  if (sensor_lines == "one") {
    request.sensor_lines = SensorLines::kOne;
  } else if (sensor_lines == "all") {
    request.sensor_lines = SensorLines::kAll;
  } else if (!sensor_lines.empty() && sensor_lines != "auto") {
    throw InputError("--sensor-lines takes auto, one or all, not '" + sensor_lines + "'.");
  }
  return request;
}

void PlaceChoice::add_to(CLI::App& app) {
  const char* const group = "Files";
  app.add_option("-o,--output", output, "Folder for the files, or FOLDER/NAME.tif; default here")
      ->group(group);
  app.add_option("--roll", roll, "Begin of the file names; default the date")->group(group);
  app.add_option("--film", film, "What is on the film, for the metadata; for example dufay")
      ->group(group);
}

std::filesystem::path PlaceChoice::directory() const {
  std::filesystem::path path(output);
  if (exact_name().empty()) return path;
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

std::string PlaceChoice::exact_name() const {
  const std::filesystem::path path(output);
  const std::string extension = path.extension().string();
  return extension == ".tif" || extension == ".tiff" ? path.stem().string() : std::string();
}

std::string PlaceChoice::stem() const { return roll.empty() ? utc_now(false).substr(0, 10) : roll; }

std::string choose_device(const std::string& given) {
  if (!given.empty()) return given;
  for (const char* variable : {"RESEAU_DEVICE", "SANE_DEFAULT_DEVICE"}) {
    // SANE's own names ("coolscan3:usb:…") mean nothing here, and must not keep us from a unit.
    const char* value = std::getenv(variable);
    if (value != nullptr && is_our_device_name(value)) return value;
  }
  std::vector<DeviceEntry> real;
  for (DeviceEntry& entry : list_devices()) {
    if (!entry.simulated) real.push_back(std::move(entry));
  }
  if (real.size() == 1) return real.front().name;
  if (real.empty()) {
    throw Failure(kExitDevice, "No film scanner was found.",
                  "Plug it in and switch it on; 'reseau doctor' says what is missing. Without a "
                  "scanner, try 'reseau scan -d sim:ls5000'.");
  }
  std::string names;
  for (const DeviceEntry& entry : real) names += " " + entry.name;
  throw Failure(kExitUsage, fmt::format("There are {} scanners:{}.", real.size(), names),
                "Choose one with -d.");
}

}  // namespace reseau::cli
