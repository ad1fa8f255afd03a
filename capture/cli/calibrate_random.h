// `calibrate --random`: the spread of a point in two dimensions from a random target.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/random/random_target.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

// "SEED,CELL_UM", as --target names it. Throws InputError.
struct TargetName {
  std::uint64_t seed = 1;
  double cell_um = 3.2;
};
[[nodiscard]] TargetName parse_target(const std::string& text);

struct RandomOfChannel {
  std::string channel;
  RandomPsf psf;
};
struct RandomOfFile {
  std::filesystem::path path;
  TargetName target;
  double dpi = 0;
  PixelRect region;
  CaptureContext context;
  std::vector<RandomOfChannel> channels;
  [[nodiscard]] bool measured() const;
};

// The middle of the file, or of the region of `choice`. `dpi`: what the person says, 0 where the
// file shall.
[[nodiscard]] RandomOfFile measure_random_file(const std::filesystem::path& path,
                                               const TargetName& target, double dpi,
                                               const MeasureChoice& choice, Reporter& reporter);

// A channel's target beside the edges that were measured in the same run: where both fall to one
// half along the edge's normal.
struct RandomAgainstEdge {
  std::string channel;
  double angle_deg = 0;  // of the edge
  RandomPsf::Point random, edge;
};
[[nodiscard]] std::vector<RandomAgainstEdge> against_edges(const std::vector<RandomOfFile>& random,
                                                           const std::vector<MeasuredFile>& edges);

// The spread of each channel into the profile; where it has no curve of a channel, the mean of both
// directions becomes that, so that reconstruction can use it.
void put_random(const RandomOfFile& file, Profile& profile);

[[nodiscard]] nlohmann::ordered_json random_to_json(const RandomOfFile& file);
[[nodiscard]] nlohmann::ordered_json against_to_json(const std::vector<RandomAgainstEdge>& pairs);
[[nodiscard]] std::string describe(const RandomOfFile& file);
[[nodiscard]] std::string describe(const std::vector<RandomAgainstEdge>& pairs);
[[nodiscard]] std::string random_html(const std::vector<RandomOfFile>& files,
                                      const std::vector<RandomAgainstEdge>& pairs);

}  // namespace reseau::cli
