// The options of `scan`, with SANE's names and units.
#pragma once

#include <array>
#include <filesystem>
#include <string>

#include <CLI/App.hpp>

#include "drivers/scan_plan.h"

namespace reseau::cli {

struct ScanChoice {
  std::string device;
  std::string resolution, depth, infrared, focus, autofocus;
  std::array<std::string, 4> exposure;  // red green blue infrared
  std::string focus_x, focus_y;         // the point of the autofocus
  std::string left, top, width, height;
  std::string frame_offset, sensor_lines, exposure_lock;
  int samples = 1;
  double exposure_factor = 1.0;
  int frame = 1;

  // All options; the device as well.
  void add_to(CLI::App& app);
  // Throws InputError for a value that cannot be understood.
  [[nodiscard]] ScanRequest request() const;
  // Nothing was asked for but the defaults.
  [[nodiscard]] bool is_default() const;
};

// Where the files of a scan go.
struct PlaceChoice {
  std::string output = ".";  // a folder, or FOLDER/NAME.tif
  std::string roll;          // stem of the name; empty = today's date
  std::string film;          // what is on the film, for the metadata

  void add_to(CLI::App& app);
  [[nodiscard]] std::filesystem::path directory() const;
  // From -o FOLDER/NAME.tif; empty = number it.
  [[nodiscard]] std::string exact_name() const;
  [[nodiscard]] std::string stem() const;
};

// The device to use: as given, from RESEAU_DEVICE or SANE_DEFAULT_DEVICE, or the only one there is.
// Failure when there is none or more than one.
[[nodiscard]] std::string choose_device(const std::string& given);

}  // namespace reseau::cli
