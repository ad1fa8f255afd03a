#include "capture/compare/map_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/check.h"

namespace reseau::compare {
namespace {

constexpr int kProbesPerSide = 48;
constexpr int kFieldCells = 12;
// Half a period is a displacement; more is a lost count.
constexpr double kSlip = 0.75;

struct Pair {
  double u = 0, v = 0;
};
// d(u, v) / d(x, y).
struct Jacobian {
  double ux = 0, uy = 0, vx = 0, vy = 0;
  [[nodiscard]] double determinant() const { return ux * vy - uy * vx; }
};

Pair pair_at(std::span<const float> rows, int width, int row, int x) {
  const std::size_t i = 2 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x));
  return {double{rows[i]}, double{rows[i + 1]}};
}

// Differences over the rows `up` and `down` of the buffer and the columns beside x.
Jacobian jacobian_at(std::span<const float> rows, int width, int row, int up, int down, int x) {
  const int left = std::max(0, x - 1), right = std::min(width - 1, x + 1);
  const Pair l = pair_at(rows, width, row, left), r = pair_at(rows, width, row, right);
  const Pair t = pair_at(rows, width, up, x), b = pair_at(rows, width, down, x);
  const double across = std::max(1, right - left), along = std::max(1, down - up);
  return {(r.u - l.u) / across, (b.u - t.u) / along, (r.v - l.v) / across, (b.v - t.v) / along};
}

struct Probe {
  Pair a, b;
  Jacobian ja, jb;
};

bool finite(const Probe& p) {
  return std::isfinite(p.a.u + p.a.v + p.b.u + p.b.v + p.ja.ux + p.ja.uy + p.ja.vx + p.ja.vy +
                       p.jb.ux + p.jb.uy + p.jb.vx + p.jb.vy);
}

std::vector<Probe> probe(int width, int height, int border, const MapRows& a, const MapRows& b) {
  std::vector<Probe> probes;
  const auto row = 2 * static_cast<std::size_t>(width);
  std::vector<float> rows_a(3 * row), rows_b(3 * row);
  const int inner_h = height - 2 * border, inner_w = width - 2 * border;
  const int n_y = std::min(kProbesPerSide, inner_h), n_x = std::min(kProbesPerSide, inner_w);
  for (int j = 0; j < n_y; ++j) {
    const int y = border + static_cast<int>((j + 0.5) * inner_h / n_y);
    const int first = std::clamp(y - 1, 0, std::max(0, height - 3));
    const int n = std::min(3, height - first);
    a(first, n, std::span(rows_a).first(static_cast<std::size_t>(n) * row));
    b(first, n, std::span(rows_b).first(static_cast<std::size_t>(n) * row));
    for (int i = 0; i < n_x; ++i) {
      const int x = border + static_cast<int>((i + 0.5) * inner_w / n_x);
      const Probe p{pair_at(rows_a, width, y - first, x), pair_at(rows_b, width, y - first, x),
                    jacobian_at(rows_a, width, y - first, 0, n - 1, x),
                    jacobian_at(rows_b, width, y - first, 0, n - 1, x)};
      if (finite(p)) probes.push_back(p);
    }
  }
  return probes;
}

Pair brought_over(const MapEquivalence& e, const Pair& b) {
  return {e.sign_u * (e.swapped ? b.v : b.u), e.sign_v * (e.swapped ? b.u : b.v)};
}

Jacobian brought_over(const MapEquivalence& e, const Jacobian& b) {
  const double su = e.sign_u, sv = e.sign_v;
  return e.swapped ? Jacobian{su * b.vx, su * b.vy, sv * b.ux, sv * b.uy}
                   : Jacobian{su * b.ux, su * b.uy, sv * b.vx, sv * b.vy};
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

MapEquivalence equivalence_of(const std::vector<Probe>& probes) {
  MapEquivalence best;
  best.gradient_mismatch = HUGE_VAL;
  double scale = 0;
  for (const Probe& p : probes) {
    scale += p.ja.ux * p.ja.ux + p.ja.uy * p.ja.uy + p.ja.vx * p.ja.vx + p.ja.vy * p.ja.vy;
  }
  for (int choice = 0; choice < 8; ++choice) {
    MapEquivalence trial;
    trial.swapped = (choice & 4) != 0;
    trial.sign_u = (choice & 1) != 0 ? -1 : 1;
    trial.sign_v = (choice & 2) != 0 ? -1 : 1;
    double sum = 0;
    for (const Probe& p : probes) {
      const Jacobian b = brought_over(trial, p.jb);
      sum += std::pow(b.ux - p.ja.ux, 2) + std::pow(b.uy - p.ja.uy, 2) +
             std::pow(b.vx - p.ja.vx, 2) + std::pow(b.vy - p.ja.vy, 2);
    }
    trial.gradient_mismatch = scale > 0 ? std::sqrt(sum / scale) : 0;
    if (trial.gradient_mismatch < best.gradient_mismatch) best = trial;
  }
  std::vector<double> du, dv;
  for (const Probe& p : probes) {
    const Pair b = brought_over(best, p.b);
    du.push_back(b.u - p.a.u);
    dv.push_back(b.v - p.a.v);
  }
  best.periods_u = std::round(median(du));
  best.periods_v = std::round(median(dv));
  return best;
}

class Accumulator {
 public:
  Accumulator(int width, int height, int border, MapError& error)
      : width_(width), height_(height), border_(border), error_(error) {
    error_.field_columns = std::clamp((width - 2 * border) / 8, 1, kFieldCells);
    error_.field_rows = std::clamp((height - 2 * border) / 8, 1, kFieldCells);
    error_.field.resize(static_cast<std::size_t>(error_.field_columns) *
                        static_cast<std::size_t>(error_.field_rows));
    lengths_.reserve(static_cast<std::size_t>(width - 2 * border) *
                     static_cast<std::size_t>(height - 2 * border));
  }

  void add(int x, int y, const Pair& a, const Pair& b_raw, const Jacobian& j) {
    const Pair b = brought_over(error_.equivalence, b_raw);
    double du = b.u - a.u - error_.equivalence.periods_u;
    double dv = b.v - a.v - error_.equivalence.periods_v;
    const double determinant = j.determinant();
    if (!std::isfinite(du + dv + 1 / determinant)) {
      ++error_.n_not_finite;
      return;
    }
    if (std::abs(du) > kSlip || std::abs(dv) > kSlip) {
      ++error_.n_slipped;
      if (std::abs(du) > kSlip) du -= std::round(du);
      if (std::abs(dv) > kSlip) dv -= std::round(dv);
    }
    const double dx = (j.vy * du - j.uy * dv) / determinant;
    const double dy = (j.ux * dv - j.vx * du) / determinant;
    const double squared = dx * dx + dy * dy;
    ++error_.n;
    sum_x_ += dx;
    sum_y_ += dy;
    squares_ += squared;
    // Columns of the inverse Jacobian: one period of u, one of v.
    period_u_ += std::hypot(j.vy, j.vx) / std::abs(determinant);
    period_v_ += std::hypot(j.uy, j.ux) / std::abs(determinant);
    lengths_.push_back(static_cast<float>(std::sqrt(squared)));
    FieldCell& cell = cell_of(x, y);
    ++cell.n;
    cell.dx_px += dx;
    cell.dy_px += dy;
    cell.rms_px += squared;
  }

  void finish() {
    for (int r = 0; r < error_.field_rows; ++r) {
      for (int c = 0; c < error_.field_columns; ++c) {
        FieldCell& cell = cell_at(c, r);
        cell.x_px = border_ + (c + 0.5) * (width_ - 2 * border_) / error_.field_columns - 0.5;
        cell.y_px = border_ + (r + 0.5) * (height_ - 2 * border_) / error_.field_rows - 0.5;
        if (cell.n == 0) continue;
        const auto n = static_cast<double>(cell.n);
        cell.dx_px /= n;
        cell.dy_px /= n;
        cell.rms_px = std::sqrt(cell.rms_px / n);
      }
    }
    if (error_.n == 0) return;
    const auto n = static_cast<double>(error_.n);
    error_.mean_x_px = sum_x_ / n;
    error_.mean_y_px = sum_y_ / n;
    error_.rms_px = std::sqrt(squares_ / n);
    error_.rms_without_mean_px =
        std::sqrt(std::max(0.0, squares_ / n - error_.mean_x_px * error_.mean_x_px -
                                    error_.mean_y_px * error_.mean_y_px));
    error_.period_u_px = period_u_ / n;
    error_.period_v_px = period_v_ / n;
    const auto at_rank = [this, n](double share) {
      const auto rank = static_cast<std::ptrdiff_t>(std::max(1.0, std::ceil(share * n))) - 1;
      std::nth_element(lengths_.begin(), lengths_.begin() + rank, lengths_.end());
      return double{lengths_[static_cast<std::size_t>(rank)]};
    };
    error_.median_px = at_rank(0.5);
    error_.p95_px = at_rank(0.95);
    error_.max_px = at_rank(1.0);
  }

 private:
  FieldCell& cell_at(int column, int row) {
    return error_
        .field[static_cast<std::size_t>(row) * static_cast<std::size_t>(error_.field_columns) +
               static_cast<std::size_t>(column)];
  }
  FieldCell& cell_of(int x, int y) {
    const int c = (x - border_) * error_.field_columns / (width_ - 2 * border_);
    const int r = (y - border_) * error_.field_rows / (height_ - 2 * border_);
    return cell_at(c, r);
  }

  int width_, height_, border_;
  MapError& error_;
  double sum_x_ = 0, sum_y_ = 0, squares_ = 0, period_u_ = 0, period_v_ = 0;
  std::vector<float> lengths_;
};

}  // namespace

MapError compare_maps(int width_px, int height_px, int border_px, const MapRows& a,
                      const MapRows& b) {
  CHECK(width_px > 0 && height_px > 0 && border_px >= 0);
  MapError error;
  if (2 * border_px >= std::min(width_px, height_px)) return error;
  error.equivalence = equivalence_of(probe(width_px, height_px, border_px, a, b));
  Accumulator accumulator(width_px, height_px, border_px, error);
  constexpr int kBandRows = 64;
  const auto row = 2 * static_cast<std::size_t>(width_px);
  std::vector<float> rows_a((kBandRows + 2) * row), rows_b(kBandRows * row);
  for (int first = border_px; first < height_px - border_px; first += kBandRows) {
    const int n = std::min(kBandRows, height_px - border_px - first);
    // One row more on either side where there is one, for the gradient.
    const int above = std::max(0, first - 1), below = std::min(height_px, first + n + 1);
    const auto part_a = std::span(rows_a).first(static_cast<std::size_t>(below - above) * row);
    const auto part_b = std::span(rows_b).first(static_cast<std::size_t>(n) * row);
    a(above, below - above, part_a);
    b(first, n, part_b);
    for (int y = first; y < first + n; ++y) {
      const int in_a = y - above;
      const int up = std::max(0, in_a - 1), down = std::min(below - above - 1, in_a + 1);
      for (int x = border_px; x < width_px - border_px; ++x) {
        accumulator.add(x, y, pair_at(part_a, width_px, in_a, x),
                        pair_at(part_b, width_px, y - first, x),
                        jacobian_at(part_a, width_px, in_a, up, down, x));
      }
    }
  }
  accumulator.finish();
  return error;
}

}  // namespace reseau::compare
