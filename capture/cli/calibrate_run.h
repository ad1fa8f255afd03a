// Sharpness of the edges in pictures, channel by channel, and what it says of the unit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/edge/measure_edge.h"
#include "calibration/profile/profile.h"
#include "capture/cli/reporter.h"
#include "capture/image/linear_picture.h"

namespace reseau::cli {

struct ChannelEdge {
  std::string channel;
  EdgeMeasurement measured;
};

struct MeasuredEdge {
  PixelRect roi;
  std::vector<ChannelEdge> channels;
  // Of the channel that is measured best; infinite when none is.
  [[nodiscard]] double relative_sd() const;
  [[nodiscard]] bool measured() const;
};

struct MeasuredFile {
  std::filesystem::path path;
  int width_px = 0, height_px = 0;
  double dpi = 0;
  CaptureContext context;
  std::vector<MeasuredEdge> edges;  // best first; one when a region was given
};

struct MeasureChoice {
  std::optional<PixelRect> roi;
  ReadScanOptions read;
  double window_px = 28;
  int most_edges = 6;
};

// Failures name the file, or the region that lies outside it.
[[nodiscard]] MeasuredFile measure_file(const std::filesystem::path& path,
                                        const MeasureChoice& choice, Reporter& reporter);

[[nodiscard]] nlohmann::ordered_json channel_to_json(const EdgeMeasurement& m);
[[nodiscard]] nlohmann::ordered_json file_to_json(const MeasuredFile& file);

// Red, green, blue, infrared as 0 to 3; grey stands for green.
[[nodiscard]] std::optional<std::size_t> profile_channel(const std::string& name);

// The table on the terminal.
[[nodiscard]] std::string describe(const MeasuredFile& file);

// What all edges together say of the unit. Throws InputError when nothing was measured.
[[nodiscard]] Profile profile_of(const std::vector<MeasuredFile>& files);

}  // namespace reseau::cli
