// What lies under the scan head, as the light sees it: radiant transmittance in four bands at
// continuous positions. The seam between a film and the simulated optics.
#pragma once

#include <cstddef>
#include <vector>

namespace reseau::sim {

// Channels of everything in drivers/sim, in the order of the wire.
inline constexpr int kChannels = 4;  // red, green, blue, infrared
inline constexpr int kInfrared = 3;

// Rows are computed in blocks of this many pixels at absolute positions, so that a sample does not
// depend on where the asking window begins.
inline constexpr int kBlockPx = 16;
// The first pixel of the block that holds this one.
[[nodiscard]] constexpr int floor_to_block(int px) {
  return px >= 0 ? px / kBlockPx * kBlockPx : -((-px + kBlockPx - 1) / kBlockPx) * kBlockPx;
}

// One row of square cells of side 1/per_px optical pixels, each the mean transmittance over the
// cell. Cell s of pixel i is centred at x = first_px + i + (s + 0.5) / per_px - 0.5. Cells are kept
// by phase so that neighbours in memory are one pixel apart: [channel][phase s][pixel i].
class CellRow {
 public:
  // Tents: a cell's weight is not even over its square but falls evenly from its middle to those of
  // its neighbours, along either axis: the mean of even cells over a cell. Asked for where
  // Film::Edges says that the film knows them.
  void set_tents(bool tents) { tents_ = tents; }
  [[nodiscard]] bool tents() const { return tents_; }
  void resize(int first_px, int n_px, int per_px) {
    first_px_ = first_px;
    n_px_ = n_px;
    per_px_ = per_px;
    values_.resize(static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(per_px) *
                   static_cast<std::size_t>(n_px));
  }
  [[nodiscard]] int first_px() const { return first_px_; }
  [[nodiscard]] int n_px() const { return n_px_; }
  [[nodiscard]] int per_px() const { return per_px_; }
  [[nodiscard]] float* phase(int channel, int s) { return values_.data() + index(channel, s); }
  [[nodiscard]] const float* phase(int channel, int s) const {
    return values_.data() + index(channel, s);
  }

 private:
  [[nodiscard]] std::size_t index(int channel, int s) const {
    return (static_cast<std::size_t>(channel) * static_cast<std::size_t>(per_px_) +
            static_cast<std::size_t>(s)) *
           static_cast<std::size_t>(n_px_);
  }
  int first_px_ = 0, n_px_ = 0, per_px_ = 1;
  bool tents_ = false;
  std::vector<float> values_;
};

// Coordinates: optical pixels of the scanner. x along the sensor from the film edge where windows
// start, y along the film; pixel (0, 0) is centred at (0, 0), frame k begins at y = k * pitch.
// Immutable after construction, therefore thread-safe.
class Film {
 public:
  // Along the sensor; beyond it the holder is opaque.
  struct Extent {
    int begin_px, end_px;
  };
  virtual ~Film() = default;
  // What decides how small cells have to be. The default is a film without edges.
  struct Edges {
    // Up to which edges run along the borders of cells, as it were.
    static constexpr double kNearAxesDeg = 12;
    // Smallest angle between straight edges and the axes of the scan [degree]: the longer an edge
    // runs along the borders of cells, the smaller these must be.
    double off_axes_deg = 45;
    // Largest step across them; dyes leave half of the light.
    double contrast = 0.5;
    // The same of a scene finer than pixels; a step of 0: it is not.
    double scene_off_axes_deg = 45, scene_contrast = 0;
    // Smallest radius of round edges, which run along both axes somewhere; 0 without.
    double radius_px = 0;
    // Whether cells() knows the means over tents.
    bool tents = false;
    // Whether there is detail as fine as a third of a pixel everywhere; whether light or silver
    // spread.
    bool grainy = false, spreads = false;
    // Cells per px that the film needs for itself; fewest_plain where no lens softens it.
    int fewest_cells = 0, fewest_tents = 0, fewest_plain = 0;
  };
  [[nodiscard]] virtual Edges edges() const { return {}; }
  [[nodiscard]] virtual Extent extent() const = 0;
  // Fills a row of cells whose centres lie at height y. first_px and n_px are multiples of
  // kBlockPx; the row may reach outside the film, where bare light gives 1.
  virtual void cells(double y, int first_px, int n_px, int per_px, CellRow& out) const = 0;
  // Height of the film above the plane of best focus at (x, y), towards the lens [um]: curl,
  // buckle. The optics make defocus of it. Smooth on the scale of a block.
  [[nodiscard]] virtual double height_um(double /*x*/, double /*y*/) const { return 0; }
};

}  // namespace reseau::sim
