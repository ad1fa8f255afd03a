// Light that strays far: diffraction's tails, a wide halo and flare, on a coarse map of the film
// that is made as it is needed.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "drivers/sim/film.h"
#include "drivers/sim/psf_family.h"

namespace reseau::sim {

// What a far field is made for.
struct FarFieldSpec {
  // Per channel. Members with the same place in the lists have the same width.
  std::array<std::vector<WideGaussian>, kChannels> wide;
  double flare = 0;
  // Places along the film's x that will be asked for.
  int begin_px = 0, end_px = 0;
  // The lens's field, over which flare is spread.
  int field_begin_px = 0, field_end_px = 0;
};

// Thread-safe; the map's rows are kept only as long as lines near them are asked for.
class FarField {
 public:
  // Pitch of the map. The mean that makes a cell of it, and the cubic B-spline that reads it, are
  // parts of the Gaussians: their cumulants are taken off.
  static constexpr int kCellPx = 4;

  FarField(std::shared_ptr<const Film> film, FarFieldSpec spec);
  [[nodiscard]] bool is_empty() const { return reach_cells_ < 0; }

  // One reader per thread; it remembers the rows between which it read last.
  class Reader {
   public:
    explicit Reader(const FarField& field);
    // Adds the far light at places x (film px) of height y to out. Without flare.
    void add(int channel, double y, std::span<const double> x, std::span<float> out);
    // Mean of the lit slit at height y, as flare spreads it.
    [[nodiscard]] float slit_mean(int channel, double y);

   private:
    struct Row {
      std::int64_t index = INT64_MIN;
      std::array<std::vector<float>, kChannels> values;
      std::array<float, kChannels> slit{};
    };
    const Row& row(std::int64_t index);
    const float* mean_row(std::int64_t index, int channel);

    const FarField& field_;
    std::map<std::int64_t, std::shared_ptr<const std::vector<float>>> bands_;
    std::vector<Row> rows_;
    std::vector<float> blended_, column_;
  };

 private:
  struct Kernel {
    std::array<float, kChannels> amplitude{};
    std::vector<float> x, y;  // weights from the middle outwards
  };
  // Means of kBandRows rows of the map: [row][channel][cell].
  std::shared_ptr<const std::vector<float>> band(std::int64_t index) const;
  std::shared_ptr<const std::vector<float>> make_band(std::int64_t index) const;

  std::shared_ptr<const Film> film_;
  FarFieldSpec spec_;
  std::vector<Kernel> kernels_;
  int reach_cells_ = -1;         // of the widest kernel; -1 nothing to do
  std::int64_t first_ = 0;       // cell at which rows of the map begin
  int n_cells_ = 0;              // in a row
  std::int64_t read_first_ = 0;  // the part that can be read
  int n_read_ = 0;
  mutable std::mutex mutex_;
  mutable std::map<std::int64_t, std::shared_ptr<const std::vector<float>>> bands_;
};

}  // namespace reseau::sim
