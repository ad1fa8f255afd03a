#include "calibration/edge/first_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace reseau {
namespace {

constexpr int kMostCells = 72;

struct LineCell {
  double x, y, n, sum;
};

std::vector<LineCell> cells_of(Span2D<const float> samples, int size) {
  std::vector<LineCell> out;
  const int across = (samples.width() + size - 1) / size;
  std::vector<LineCell> row(static_cast<std::size_t>(across));
  for (int top = 0; top < samples.height(); top += size) {
    const int n_rows = std::min(size, samples.height() - top);
    for (int i = 0; i < across; ++i) {
      const int n_columns = std::min(size, samples.width() - i * size);
      row[static_cast<std::size_t>(i)] = {i * size + 0.5 * (n_columns - 1),
                                          top + 0.5 * (n_rows - 1), 0, 0};
    }
    for (int y = top; y < top + n_rows; ++y) {
      const auto line = samples.row(y);
      for (int i = 0; i < across; ++i) {
        const int end = std::min((i + 1) * size, samples.width());
        double n = 0, sum = 0;
        for (int x = i * size; x < end; ++x) {
          const double v = double{line[static_cast<std::size_t>(x)]};
          if (!std::isfinite(v)) continue;
          n += 1;
          sum += v;
        }
        row[static_cast<std::size_t>(i)].n += n;
        row[static_cast<std::size_t>(i)].sum += sum;
      }
    }
    for (const LineCell& cell : row) {
      if (cell.n > 0) out.push_back(cell);
    }
  }
  return out;
}

struct Split {
  double gain = 0;  // sum of squares between the halves
  double angle = 0, offset = 0, low_mean = 0, high_mean = 0;
};

class Search {
 public:
  Search(std::vector<LineCell> cells, Vec2 middle) : cells_(std::move(cells)), middle_(middle) {
    for (const LineCell& c : cells_) {
      n_ += c.n;
      sum_ += c.sum;
    }
    const double mean = sum_ / n_;
    for (LineCell& c : cells_) {
      c.sum -= mean * c.n;
      total_ += c.sum * c.sum / c.n;
      reach_ = std::max(reach_, std::hypot(c.x - middle.x, c.y - middle.y));
    }
    mean_ = mean;
  }
  [[nodiscard]] double total() const { return total_; }

  // Best place for one angle.
  [[nodiscard]] Split split(double angle, double step) {
    const double c = std::cos(angle), s = std::sin(angle);
    const auto n_bins = static_cast<std::size_t>(2 * reach_ / step) + 3;
    count_.assign(n_bins, 0);
    value_.assign(n_bins, 0);
    for (const LineCell& cell : cells_) {
      const double at = c * (cell.x - middle_.x) + s * (cell.y - middle_.y) + reach_;
      const auto bin = static_cast<std::size_t>(std::floor(at / step + 0.5));
      count_[bin] += cell.n;
      value_[bin] += cell.sum;
    }
    Split best;
    best.angle = angle;
    double below = 0, sum = 0;
    for (std::size_t i = 0; i + 1 < n_bins; ++i) {
      below += count_[i];
      sum += value_[i];
      if (below <= 0 || below >= n_) continue;
      const double gain = sum * sum * n_ / (below * (n_ - below));
      if (gain > best.gain) {
        best.gain = gain;
        best.offset = (double(i) + 0.5) * step - reach_;
        best.low_mean = mean_ + sum / below;
        best.high_mean = mean_ - sum / (n_ - below);
      }
    }
    return best;
  }

 private:
  std::vector<LineCell> cells_;
  Vec2 middle_;
  double n_ = 0, sum_ = 0, mean_ = 0, total_ = 0, reach_ = 1;
  std::vector<double> count_, value_;
};

}  // namespace

std::optional<FirstLine> first_line(Span2D<const float> samples) {
  const int longest = std::max(samples.width(), samples.height());
  const int size = std::max(1, (longest + kMostCells - 1) / kMostCells);
  std::vector<LineCell> cells = cells_of(samples, size);
  double n = 0;
  for (const LineCell& cell : cells) n += cell.n;
  if (n < 16 || cells.size() < 16) return std::nullopt;
  const Vec2 middle{0.5 * (samples.width() - 1), 0.5 * (samples.height() - 1)};
  Search search(std::move(cells), middle);
  if (!(search.total() > 0)) return std::nullopt;

  constexpr double kDegree = std::numbers::pi / 180;
  Split best;
  for (int degree = 0; degree < 180; degree += 3) {
    const Split now = search.split(degree * kDegree, size);
    if (now.gain > best.gain) best = now;
  }
  for (const double step : {1.0, 0.35}) {
    const double around = best.angle;
    for (int i = -4; i <= 4; ++i) {
      const Split now = search.split(around + i * step * kDegree, 0.5 * size);
      if (now.gain > best.gain) best = now;
    }
  }
  if (!(best.gain > 0)) return std::nullopt;

  FirstLine out;
  out.line.middle = middle;
  out.line.normal_rad = best.angle;
  out.line.offset_px = best.offset;
  out.dark = best.low_mean;
  out.bright = best.high_mean;
  if (out.dark > out.bright) {
    std::swap(out.dark, out.bright);
    out.line.normal_rad += std::numbers::pi;
    out.line.offset_px = -out.line.offset_px;
  }
  out.cell_px = size;
  out.explained = best.gain / search.total();
  return out;
}

}  // namespace reseau
