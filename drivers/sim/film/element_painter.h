// Which dyes cover what part of each cell.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/sim/edge_ramp.h"
#include "drivers/sim/film/placed_screen.h"
#include "drivers/sim/film/plane_row.h"
#include "drivers/sim/film/printing_noise.h"
#include "drivers/sim/film/screen_of.h"
#include "drivers/sim/film_spec.h"

namespace reseau::sim {

// Shapes are painted one after the other. The mean of a straight edge over a square cell is exact
// and a shape is the product of its edges; one that is printed across others covers its share of
// what lies in the cell, one beside others takes from the ground. That is exact but for cells with
// a corner (divided into 4 x 4 when it belongs to a polygon), where the error is second order in
// the size of a cell. Immutable, thread-safe.
class ElementPainter {
 public:
  explicit ElementPainter(const FilmSpec& spec);

  // The sets of dyes (element_response.h) that can occur; plane i of a row belongs to sets()[i].
  [[nodiscard]] const std::vector<int>& sets() const { return sets_; }
  [[nodiscard]] const PlacedScreen& screen() const { return screen_; }
  [[nodiscard]] const ScreenDescription& description() const { return description_; }
  // Fractions of the area of every cell; they sum to 1. Values depend on the place only, but for
  // rounding where a row begins or ends within a block of kBlockPx.
  void areas(double y, int first_px, int n_px, int per_px, PlaneRow& out, bool tents = false) const;

 private:
  struct Block;
  // What lies where dye `bit` overlaps the neighbour `set` or leaves a gap to it.
  [[nodiscard]] int between(int set, int bit) const;
  struct Shape;
  struct Cover;
  struct Painting;
  [[nodiscard]] ScreenGradient gradient_at(double x, double y) const;
  void place(double y, int first_px, Block& block) const;
  void ramps(const ScreenGradient& g, double cell_px, bool tents, std::vector<Shape>& shapes) const;
  void cover(Shape& shape, const Block& block, const float* u, const float* v, Cover& out) const;
  void cover_disc(const Shape& shape, float du, float dv, float grow_px, float& inner,
                  float& outer) const;
  void cover_polygons(const Shape& shape, const float* u, const float* v, float grow_px,
                      std::array<float, 16>& out) const;
  [[nodiscard]] float cover_polygon(const Shape& shape, float du, float dv, float grow_px) const;
  void paint_across(const Shape& shape, const Cover& cover, float (*areas)[16]) const;
  void paint_beside(const Shape& shape, const Cover& cover, float (*areas)[16]) const;

  void paint_strip(Painting& to, const Block& block, int begin, int end, int block_in_row,
                   PlaneRow& out) const;
  void paint(std::vector<Shape>& shapes, const Block& block, const float* u, const float* v,
             float (*areas)[16], float* meet) const;
  void find_meetings(const Cover& cover, const float (*areas)[16], float* meet) const;
  void divide(std::vector<Shape>& fine, const Block& block, float u, float v, bool tent,
              std::size_t cell, float (*areas)[16]) const;

  PlacedScreen screen_;
  ScreenDescription description_;
  PrintSpec print_;
  double pixel_um_;
  std::uint64_t seed_;
  std::vector<int> sets_;
  std::array<int, 9> slot_of_set_{};
  bool errors_;        // of printing
  int node_px_;        // distance between exactly placed points
  bool strained_;      // so much that edges change their direction within the frame
  int strip_px_ = 16;  // of pixels over which they do not
};

}  // namespace reseau::sim
