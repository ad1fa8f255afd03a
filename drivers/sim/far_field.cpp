#include "drivers/sim/far_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "drivers/sim/spline_weights.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

constexpr int kBandRows = 16;
constexpr int kSlitCells = 40;  // the lit slit is 1 mm high: 160 optical px
constexpr double kReachSigmas = 4.5;
// A cell of the map is four pairs of pixels with weights 1 3 3 1, which leaves hardly anything of
// the detail that the map's pitch would mistake for coarse structure. Weight per pixel of its own
// cell's pixels and of the two next to them:
constexpr float kInner = 3.0F / 16, kOuter = 1.0F / 16;
struct Weighted {
  const float* from;
  float weight;
};

// Adds them in their order, eight in one pass.
void add_weighted(const std::vector<Weighted>& rows, std::size_t n, float* to) {
  constexpr std::size_t kAtOnce = 8;
  for (std::size_t first = 0; first < rows.size(); first += kAtOnce) {
    const float* from[kAtOnce];
    float w[kAtOnce];
    const std::size_t n_rows = std::min(kAtOnce, rows.size() - first);
    for (std::size_t k = 0; k < n_rows; ++k) {
      from[k] = rows[first + k].from;
      w[k] = rows[first + k].weight;
    }
    widest([&]() RESEAU_SIM_INLINE {
      float* __restrict const out = to;
      if (n_rows == kAtOnce) {
        const float *const p0 = from[0], *const p1 = from[1], *const p2 = from[2],
                           *const p3 = from[3], *const p4 = from[4], *const p5 = from[5],
                           *const p6 = from[6], *const p7 = from[7];
        const float w0 = w[0], w1 = w[1], w2 = w[2], w3 = w[3], w4 = w[4], w5 = w[5], w6 = w[6],
                    w7 = w[7];
        for (std::size_t i = 0; i < n; ++i) {
          float sum = out[i] + w0 * p0[i];
          sum += w1 * p1[i];
          sum += w2 * p2[i];
          sum += w3 * p3[i];
          sum += w4 * p4[i];
          sum += w5 * p5[i];
          sum += w6 * p6[i];
          out[i] = sum + w7 * p7[i];
        }
        return;
      }
      for (std::size_t k = 0; k < n_rows; ++k) {
        const float* const row = from[k];
        const float by = w[k];
        for (std::size_t i = 0; i < n; ++i) out[i] += by * row[i];
      }
    });
  }
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

// Second and fourth cumulant of what makes a cell of the map (a pixel, a pair of them 1 px apart,
// three pairs 2 px apart) and of the cubic B-spline that reads it, in cells.
constexpr double kPx = 1.0 / FarField::kCellPx;
constexpr double kMapVariance = (1.0 / 12 + 1.0 / 4 + 3) * kPx * kPx + 4.0 / 12;
constexpr double kMapFourth = -(1.0 / 120 + 1.0 / 8 + 6) * kPx * kPx * kPx * kPx - 4.0 / 120;

// Weights of the map's cells from the middle outwards that, with these, make a Gaussian.
std::vector<float> half_gaussian(double sigma_px) {
  const double wanted = sigma_px * kPx, sigma = std::sqrt(wanted * wanted - kMapVariance);
  const int reach = static_cast<int>(std::ceil(kReachSigmas * sigma));
  const double fourth = -kMapFourth / (24 * sigma * sigma * sigma * sigma);
  std::vector<double> w;
  w.reserve(static_cast<std::size_t>(reach) + 1);
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    const double t2 = i * i / (sigma * sigma);
    w.push_back(std::exp(-0.5 * t2) * (1 + fourth * ((t2 - 6) * t2 + 3)));
    sum += (i == 0 ? 1 : 2) * w.back();
  }
  std::vector<float> weights;
  weights.reserve(w.size());
  for (const double v : w) weights.push_back(static_cast<float>(v / sum));
  return weights;
}

// Weights of the four cells around a place, as the map is kept.
std::array<float, 4> cell_weights(double f) {
  const std::array<double, 4> w = spline_weights(f);
  return {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2]),
          static_cast<float>(w[3])};
}

// Place on the map, in cells; cell k covers pixels 4 k to 4 k + 3.
double cells_from_px(double px) { return (px + 0.5) / FarField::kCellPx - 0.5; }

}  // namespace

FarField::FarField(std::shared_ptr<const Film> film, FarFieldSpec spec)
    : film_(std::move(film)), spec_(std::move(spec)) {
  for (std::size_t c = 0; c < kChannels; ++c) {
    for (const WideGaussian& g : spec_.wide[c]) {
      // Equal widths share the work.
      Kernel kernel;
      kernel.x = half_gaussian(g.sigma_x_px);
      kernel.y = half_gaussian(g.sigma_y_px);
      auto same = std::ranges::find_if(
          kernels_, [&](const Kernel& k) { return k.x == kernel.x && k.y == kernel.y; });
      if (same == kernels_.end()) same = kernels_.insert(kernels_.end(), std::move(kernel));
      same->amplitude[c] += static_cast<float>(g.amplitude);
      const auto longest = std::max(same->x.size(), same->y.size());
      reach_cells_ = std::max(reach_cells_, static_cast<int>(longest) - 1);
    }
  }
  if (spec_.flare > 0) reach_cells_ = std::max(reach_cells_, kSlitCells / 2);
  if (is_empty()) return;
  read_first_ = floor_div(spec_.begin_px, kCellPx) - 2;
  n_read_ = static_cast<int>(floor_div(spec_.end_px, kCellPx) + 3 - read_first_);
  std::int64_t last = read_first_ + n_read_ + reach_cells_;
  first_ = read_first_ - reach_cells_;
  if (spec_.flare > 0) {
    first_ = std::min(first_, floor_div(spec_.field_begin_px, kCellPx));
    last = std::max(last, floor_div(spec_.field_end_px, kCellPx) + 1);
  }
  n_cells_ = static_cast<int>(last - first_);
}

std::shared_ptr<const std::vector<float>> FarField::make_band(std::int64_t index) const {
  const auto n = static_cast<std::size_t>(n_cells_);
  auto band = std::make_shared<std::vector<float>>(kBandRows * kChannels * n, 0.0F);
  const Film::Extent extent = film_->extent();
  // Film pixels under the map; beyond the film's extent the holder is opaque.
  const std::int64_t begin = std::max<std::int64_t>(first_ * kCellPx, extent.begin_px);
  const std::int64_t end = std::min<std::int64_t>((first_ + n_cells_) * kCellPx, extent.end_px);
  if (begin >= end) return band;
  const auto block_begin = static_cast<int>(floor_div(begin, kBlockPx) * kBlockPx);
  const auto block_end = static_cast<int>(floor_div(end + kBlockPx - 1, kBlockPx) * kBlockPx);
  CellRow cells;
  std::vector<float> row(n + 2);  // with one cell to spare at both ends
  static_assert(kCellPx == 4);
  for (int line = -2; line < kBandRows * kCellPx + 2; ++line) {
    const std::int64_t y = index * kBandRows * kCellPx + line;
    film_->cells(static_cast<double>(y), block_begin, block_end - block_begin, 1, cells);
    const std::int64_t own = floor_div(line, kCellPx), next = own + (line & 2) - 1;
    for (int c = 0; c < kChannels; ++c) {
      const float* from = cells.phase(c, 0) - block_begin;
      std::ranges::fill(row, 0.0F);
      for (std::int64_t x = begin; x < end; ++x) {
        const std::int64_t cell = floor_div(x, kCellPx) - first_ + 1;
        row[static_cast<std::size_t>(cell)] += kInner * from[x];
        row[static_cast<std::size_t>(cell + (x & 2) - 1)] += kOuter * from[x];
      }
      const auto add = [&](std::int64_t to_row, float weight) {
        if (to_row < 0 || to_row >= kBandRows) return;
        float* to =
            band->data() +
            (static_cast<std::size_t>(to_row) * kChannels + static_cast<std::size_t>(c)) * n;
        for (std::size_t i = 0; i < n; ++i) to[i] += weight * row[i + 1];
      };
      add(own, kInner);
      add(next, kOuter);
    }
  }
  return band;
}

std::shared_ptr<const std::vector<float>> FarField::band(std::int64_t index) const {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = bands_.find(index); found != bands_.end()) return found->second;
  }
  auto made = make_band(index);  // a band made twice at the same time is the same
  const std::scoped_lock lock(mutex_);
  // Readers hold what they use; what lies far behind is made again if it is ever asked for.
  const std::size_t keep = 2 * static_cast<std::size_t>(reach_cells_) / kBandRows + 16;
  while (bands_.size() >= keep) {
    const bool lowest = index - bands_.begin()->first > std::prev(bands_.end())->first - index;
    bands_.erase(lowest ? bands_.begin() : std::prev(bands_.end()));
  }
  return bands_.emplace(index, std::move(made)).first->second;
}

FarField::Reader::Reader(const FarField& field) : field_(field), rows_(8) {
  for (Row& row : rows_) {
    for (auto& v : row.values) v.resize(static_cast<std::size_t>(field.n_read_));
  }
}

const float* FarField::Reader::mean_row(std::int64_t index, int channel) {
  const std::int64_t band = floor_div(index, kBandRows);
  auto found = bands_.find(band);
  if (found == bands_.end()) found = bands_.emplace(band, field_.band(band)).first;
  const auto row = static_cast<std::size_t>(index - band * kBandRows);
  return found->second->data() + (row * kChannels + static_cast<std::size_t>(channel)) *
                                     static_cast<std::size_t>(field_.n_cells_);
}

const FarField::Reader::Row& FarField::Reader::row(std::int64_t index) {
  const auto n_rows = static_cast<std::int64_t>(rows_.size());
  Row& row = rows_[static_cast<std::size_t>(((index % n_rows) + n_rows) % n_rows)];
  if (row.index == index) return row;
  row.index = index;
  // Bands out of reach are given back.
  const std::int64_t margin = field_.reach_cells_ + 2 * kBandRows;
  std::erase_if(bands_, [&](const auto& band) {
    return band.first * kBandRows < index - margin || band.first * kBandRows > index + margin;
  });
  std::vector<Weighted> weighted;
  for (int c = 0; c < kChannels; ++c) {
    const auto ch = static_cast<std::size_t>(c);
    std::vector<float>& out = row.values[ch];
    std::ranges::fill(out, 0.0F);
    for (const Kernel& kernel : field_.kernels_) {
      if (kernel.amplitude[ch] == 0) continue;
      const auto reach_x = static_cast<std::int64_t>(kernel.x.size()) - 1;
      const auto reach_y = static_cast<std::int64_t>(kernel.y.size()) - 1;
      const auto n = static_cast<std::size_t>(field_.n_read_ + 2 * reach_x);
      const std::int64_t skip = field_.read_first_ - reach_x - field_.first_;
      column_.assign(n, 0.0F);
      weighted.clear();
      for (std::int64_t k = -reach_y; k <= reach_y; ++k) {
        const float w = kernel.amplitude[ch] * kernel.y[static_cast<std::size_t>(std::abs(k))];
        weighted.push_back({mean_row(index + k, c) + skip, w});
      }
      add_weighted(weighted, n, column_.data());
      weighted.clear();
      for (std::int64_t k = -reach_x; k <= reach_x; ++k) {
        weighted.push_back(
            {column_.data() + reach_x + k, kernel.x[static_cast<std::size_t>(std::abs(k))]});
      }
      add_weighted(weighted, out.size(), out.data());
    }
    if (field_.spec_.flare > 0) {
      const std::int64_t begin = floor_div(field_.spec_.field_begin_px, kCellPx) - field_.first_;
      const std::int64_t end = floor_div(field_.spec_.field_end_px, kCellPx) - field_.first_;
      double sum = 0;
      for (int k = -kSlitCells / 2; k < kSlitCells / 2; ++k) {
        const float* from = mean_row(index + k, c);
        for (std::int64_t i = begin; i < end; ++i) sum += from[i];
      }
      const double n = static_cast<double>(std::max<std::int64_t>(end - begin, 1)) * kSlitCells;
      row.slit[ch] = static_cast<float>(sum / n);
    }
  }
  return row;
}

void FarField::Reader::add(int channel, double y, std::span<const double> x, std::span<float> out) {
  CHECK(x.size() == out.size());
  if (field_.kernels_.empty()) return;
  const double at_y = cells_from_px(y);
  const auto base_y = static_cast<std::int64_t>(std::floor(at_y));
  const std::array<float, 4> w_y = cell_weights(at_y - std::floor(at_y));
  blended_.assign(static_cast<std::size_t>(field_.n_read_), 0.0F);
  for (std::size_t k = 0; k < 4; ++k) {
    const std::vector<float>& from =
        row(base_y - 1 + static_cast<std::int64_t>(k)).values[static_cast<std::size_t>(channel)];
    for (std::size_t i = 0; i < blended_.size(); ++i) blended_[i] += w_y[k] * from[i];
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double at = cells_from_px(x[i]) - static_cast<double>(field_.read_first_);
    const double below = std::floor(at);
    const std::array<float, 4> w = cell_weights(at - below);
    const float* v = blended_.data() + static_cast<std::ptrdiff_t>(below) - 1;
    out[i] += (w[0] * v[0] + w[1] * v[1]) + (w[2] * v[2] + w[3] * v[3]);
  }
}

float FarField::Reader::slit_mean(int channel, double y) {
  const double at = cells_from_px(y), below = std::floor(at);
  const auto index = static_cast<std::int64_t>(below);
  const auto c = static_cast<std::size_t>(channel), t = static_cast<std::size_t>(0);
  const float upper = row(index).slit[c + t], lower = row(index + 1).slit[c];
  return upper + static_cast<float>(at - below) * (lower - upper);
}

}  // namespace reseau::sim
