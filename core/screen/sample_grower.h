// Follows the réseau from a seed outwards, block by block, surest first.
#pragma once

#include <queue>
#include <utility>
#include <vector>

#include "core/screen/phase_samples.h"

namespace reseau {

// The samples are connected, so that none is off by a whole period where the film does not tear.
// Rows of blocks may be added as lines arrive. Thread-bound; the cells must outlive it.
class SampleGrower {
 public:
  // A pattern of lines has no u; it is predicted only.
  SampleGrower(const CellGrid& cells, const ColorSeries& series, const BlockShape& shape);

  // Measures the block of the seed.
  void start(const LatticeSeed& seed);
  // Goes as far as the rows of blocks [0, end) lead, which are full. Never falls.
  void grow(int end_block_row);
  [[nodiscard]] int n_block_rows() const { return ny_; }

  // Instead of following: every block where a map puts it, to within most_step [periods].
  void measure_all(const ScreenMap& map, double most_step);

  // Which blocks were measured [row][column].
  [[nodiscard]] std::vector<bool> accepted() const;
  [[nodiscard]] int n_block_columns() const { return nx_; }
  // By rows of blocks.
  [[nodiscard]] std::vector<PhaseSample> samples() const;

 private:
  struct Node {
    bool done = false, accepted = false;
    PhaseSample sample;
    Mat2 jacobian{0, 0, 0, 0};
  };
  struct Prediction {
    Vec2 screen;
    Mat2 jacobian{0, 0, 0, 0};
  };
  using Neighbours = std::vector<std::pair<const Node*, double>>;
  using Entry = std::pair<double, std::pair<int, int>>;  // information; column, row

  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] Node& node_at(int i, int j) { return nodes_[index(i, j)]; }
  [[nodiscard]] Vec2 middle(int i, int j) const;
  // `there` holds at the middle of the block.
  void measure(int i, int j, const Prediction& there);
  void spread();
  void wake(int i, int j);
  [[nodiscard]] Prediction predict(int i, int j);
  [[nodiscard]] static Prediction bent(const Neighbours& neighbours, Vec2 p,
                                       const Prediction& flat);
  void step_to(int i, int j, const Node& from);

  const CellGrid& cells_;
  ColorSeries series_;
  BlockShape shape_;
  bool bends_;
  double most_step_ = 1;  // from where a block is expected [periods]
  int nx_, ny_, end_row_ = 0;
  std::vector<Node> nodes_;
  std::priority_queue<Entry> queue_;
};

}  // namespace reseau
