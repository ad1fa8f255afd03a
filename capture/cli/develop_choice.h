// The options of every verb that makes pictures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "capture/cli/color_choice.h"
#include "capture/cli/reporter.h"
#include "capture/session/develop.h"

namespace reseau::cli {

struct DevelopChoice {
  ColorChoice color;
  std::string view_gamut = "clip";
  std::string quality = "standard";
  std::string deconvolve = "auto";
  std::string demosaic;  // empty: that of the quality
  std::string geometry = "scan";
  double scale = 1;
  std::string roi;      // empty: all of the scan
  std::string neutral;  // empty: nothing is made neutral
  std::string silver = "infrared";
  std::string profile = "auto";
  double white_level = 1.0, black_level = 0.0;
  std::optional<double> blur_px;
  int n_threads = 0;
  bool exact = false;
  bool no_view = false;

  void add_to(CLI::App& app);
  // Throws InputError for what cannot be; says on the reporter what is granted otherwise than
  // asked.
  [[nodiscard]] DevelopOptions resolve(Reporter& reporter) const;
  // Reads a profile that is named. Throws InputError, std::system_error.
  [[nodiscard]] ProfileChoice resolve_profile() const { return parse_profile_choice(profile); }
};

// Names of one picture's files in a folder.
struct PictureNames {
  std::filesystem::path exr, png, view_tiff, receipt;
};
[[nodiscard]] PictureNames picture_names(const std::filesystem::path& directory,
                                         const std::string& name);
// Makes the folder and looks that it can be written. Failure kExitOutput otherwise.
void prepare_directory(const std::filesystem::path& directory);
// The same; what it made and nothing came to lie in is taken away again, so that a scan that could
// not begin leaves no empty folders behind.
class PreparedDirectory {
 public:
  explicit PreparedDirectory(const std::filesystem::path& directory);
  ~PreparedDirectory();
  PreparedDirectory(const PreparedDirectory&) = delete;
  PreparedDirectory& operator=(const PreparedDirectory&) = delete;

 private:
  std::vector<std::filesystem::path> made_;  // the innermost first
};
// Failure kExitOutput when a file is there already: nothing is ever overwritten.
void refuse_existing(const std::filesystem::path& path);

// Shows registration and reconstruction as they go; registration as work in the background when
// `scanning`.
[[nodiscard]] DevelopProgress develop_progress(Reporter& reporter, bool scanning, int n_lines);

// A few lines about the finished picture, for people.
[[nodiscard]] std::string describe_registration(const Registration& registration);
[[nodiscard]] std::string describe_clipping(const ReconstructionReport& report, bool infrared);

}  // namespace reseau::cli
