// `calibrate --random`: the two-dimensional spread from a random target.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/random/random_target.h"
#include "capture/cli/calibrate_run.h"

namespace reseau::cli {

// "SEED,CELL_PX" or "SEED,CELL_PX,X,Y": the target, and where the first pixel of the picture (of
// the region, where one is given) lies in it [px]. Throws InputError.
struct RandomAsked {
  RandomTarget target;
  Vec2 start_px;
};
[[nodiscard]] RandomAsked parse_random(const std::string& text);

struct RandomOfChannel {
  std::string channel;
  RandomPsf psf;
};
struct RandomOfFile {
  std::filesystem::path path;
  std::vector<RandomOfChannel> channels;
  [[nodiscard]] bool measured() const;
};

[[nodiscard]] RandomOfFile measure_random_file(const std::filesystem::path& path,
                                               const RandomAsked& asked,
                                               const MeasureChoice& choice, Reporter& reporter);
[[nodiscard]] nlohmann::ordered_json random_to_json(const RandomOfFile& file);
[[nodiscard]] std::string describe(const RandomOfFile& file);

}  // namespace reseau::cli
