#include "drivers/sim/plain_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "drivers/sim/scan_renderer.h"

namespace reseau::sim {
namespace {

constexpr double kSmoothCells =
    0.8;  // standard deviation [cells] of a Gaussian that sums are exact for
constexpr int kLinesPerTask = 32;

// out[i] += sum of w[k] * in[k][i], four inputs at a time to spare memory traffic.
void accumulate(std::span<const float* const> in, std::span<const float> w, int n, float* out) {
  std::size_t k = 0;
  for (; k + 4 <= in.size(); k += 4) {
    const float *a = in[k], *b = in[k + 1], *c = in[k + 2], *d = in[k + 3];
    const float wa = w[k], wb = w[k + 1], wc = w[k + 2], wd = w[k + 3];
    for (int i = 0; i < n; ++i) out[i] += (wa * a[i] + wb * b[i]) + (wc * c[i] + wd * d[i]);
  }
  for (; k < in.size(); ++k) {
    const float* a = in[k];
    const float wa = w[k];
    for (int i = 0; i < n; ++i) out[i] += wa * a[i];
  }
}

}  // namespace

// Rows of cells, convolved and decimated along x, of the lines just behind and ahead.
struct PlainRenderer::RowCache {
  RowCache(int n_slots, int width_px)
      : slot_row(static_cast<std::size_t>(n_slots), INT64_MIN),
        slots(static_cast<std::size_t>(n_slots)) {
    for (auto& slot : slots) {
      slot.resize(static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(width_px));
    }
  }
  [[nodiscard]] std::size_t slot_of(std::int64_t cell_row) const {
    const auto n = static_cast<std::int64_t>(slots.size());
    return static_cast<std::size_t>(((cell_row % n) + n) % n);
  }
  std::vector<std::int64_t> slot_row;
  std::vector<std::vector<float>> slots;  // [channel][optical pixel]
  CellRow cells;
  std::vector<const float*> inputs;
};

PlainRenderer::Kernel PlainRenderer::make_kernel(double sigma_px, double aperture_px,
                                                 int cells_per_px, bool tents) {
  // Cells are exact means, so a box over whole cells is an exact integral; the Gaussian is summed
  // at the spacing of the cells, which converges faster than any power of it.
  // Tents spread the light by 1/12 more.
  const double variance = sigma_px * sigma_px * cells_per_px * cells_per_px;
  const double sigma = std::sqrt(tents ? variance - 1.0 / 12 : variance);
  const double aperture = aperture_px * cells_per_px;
  const int gauss_reach = static_cast<int>(std::ceil(4.5 * sigma));
  std::vector<double> gauss;
  for (int j = -gauss_reach; j <= gauss_reach; ++j) {
    gauss.push_back(j == 0 ? 1.0 : std::exp(-0.5 * j * j / (sigma * sigma)));
  }
  const int box_reach = static_cast<int>(std::ceil((aperture - cells_per_px) / 2 - 1e-9));
  std::vector<double> box;
  for (int j = -box_reach; j < cells_per_px + box_reach; ++j) {
    const double left = std::max<double>(j, (cells_per_px - aperture) / 2);
    const double right = std::min<double>(j + 1, (cells_per_px + aperture) / 2);
    box.push_back(std::max(0.0, right - left));
  }
  std::vector<double> product(gauss.size() + box.size() - 1, 0.0);
  double sum = 0;
  for (std::size_t g = 0; g < gauss.size(); ++g) {
    for (std::size_t b = 0; b < box.size(); ++b) {
      product[g + b] += gauss[g] * box[b];
      sum += gauss[g] * box[b];
    }
  }
  Kernel kernel;
  kernel.first_cell = -gauss_reach - box_reach;
  for (const double w : product) kernel.weights.push_back(static_cast<float>(w / sum));
  return kernel;
}

PlainRenderer::PlainRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                             const ScanWindow& window)
    : film_(std::move(film)),
      window_(window),
      cells_per_px_(cells_used(*film_, optics, window.pitch, false)),
      point_rows_(window.pitch >= 16),
      tents_(takes_tents(*film_, window.pitch) &&
             *std::ranges::min_element(optics.blur_px) * cells_per_px_ > kSmoothCells) {
  CHECK(film_ != nullptr && window.width_px > 0 && window.n_lines >= 0 && window.pitch >= 1);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const double sigma = point_rows_ ? 0.0 : optics.blur_px[c];
    kernels_[c] = make_kernel(sigma, point_rows_ ? 1.0 : optics.aperture_px, cells_per_px_, tents_);
    const Kernel& k = kernels_[c];
    const int past = k.first_cell + static_cast<int>(k.weights.size()) - cells_per_px_;
    const int cells = std::max(-k.first_cell, past);
    reach_px_ = std::max(reach_px_, (cells + cells_per_px_ - 1) / cells_per_px_);
  }
  const Film::Extent extent = film_->extent();
  const int n_optical = window.width_px * window.pitch;
  active_begin_ = std::clamp(extent.begin_px - window.x_px, 0, n_optical);
  n_active_ = std::clamp(extent.end_px - window.x_px, active_begin_, n_optical) - active_begin_;
}

void PlainRenderer::make_row(std::int64_t cell_row, RowCache& cache) const {
  const std::size_t slot = cache.slot_of(cell_row);
  if (cache.slot_row[slot] == cell_row) return;
  cache.slot_row[slot] = cell_row;
  const double y = window_.y_px + (window_.pitch - 1) / 2.0 +
                   (static_cast<double>(cell_row) + 0.5) / cells_per_px_ - 0.5;
  const int begin = window_.x_px + active_begin_;
  const int first = floor_to_block(begin - reach_px_);
  const int end = floor_to_block(begin + n_active_ + reach_px_ + kBlockPx - 1);
  cache.cells.set_tents(tents_);
  film_->cells(y, first, end - first, cells_per_px_, cache.cells);

  std::vector<float>& row = cache.slots[slot];
  std::ranges::fill(row, 0.0F);
  for (int c = 0; c < kChannels; ++c) {
    const Kernel& kernel = kernels_[static_cast<std::size_t>(c)];
    cache.inputs.clear();
    for (int k = 0; k < static_cast<int>(kernel.weights.size()); ++k) {
      const int cell = kernel.first_cell + k + reach_px_ * cells_per_px_;
      const int pixel = begin - first - reach_px_ + cell / cells_per_px_;
      cache.inputs.push_back(cache.cells.phase(c, cell % cells_per_px_) + pixel);
    }
    accumulate(cache.inputs, kernel.weights, n_active_, row.data() + c * n_active_);
  }
}

void PlainRenderer::convolve_rows(int first_line, int n_lines, std::span<float> out) const {
  const int n_optical = window_.width_px * window_.pitch;
  const int n_slots = (2 * reach_px_ + 1) * cells_per_px_;
  RowCache cache(n_slots, n_active_);
  std::vector<float> line(static_cast<std::size_t>(n_optical));
  const auto width = static_cast<std::size_t>(window_.width_px);
  const float per_pitch = 1.0F / static_cast<float>(window_.pitch);
  std::vector<const float*> inputs;
  float* to = out.data();
  for (int l = first_line; l < first_line + n_lines; ++l) {
    const std::int64_t base = static_cast<std::int64_t>(l) * window_.step() * cells_per_px_;
    for (int c = 0; c < kChannels; ++c) {
      const Kernel& kernel = kernels_[static_cast<std::size_t>(c)];
      inputs.clear();
      for (int k = 0; k < static_cast<int>(kernel.weights.size()); ++k) {
        const std::int64_t cell_row = base + kernel.first_cell + k;
        make_row(cell_row, cache);
        inputs.push_back(cache.slots[cache.slot_of(cell_row)].data() + c * n_active_);
      }
      float* target = window_.pitch == 1 ? to : line.data();
      std::fill_n(target, n_optical, 0.0F);
      accumulate(inputs, kernel.weights, n_active_, target + active_begin_);
      if (window_.pitch > 1) {
        for (std::size_t i = 0; i < width; ++i) {
          float sum = 0;
          for (int k = 0; k < window_.pitch; ++k) {
            sum += line[i * static_cast<std::size_t>(window_.pitch) + static_cast<std::size_t>(k)];
          }
          to[i] = sum * per_pitch;
        }
      }
      to += width;
    }
  }
}

void PlainRenderer::transmittance(int first_line, int n_lines, std::span<float> out) const {
  const std::size_t per_line =
      static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(window_.width_px);
  CHECK(first_line >= 0 && n_lines >= 0 && first_line + n_lines <= window_.n_lines);
  CHECK(out.size() == per_line * static_cast<std::size_t>(n_lines));
  const int n_tasks = (n_lines + kLinesPerTask - 1) / kLinesPerTask;
  parallel_for(n_tasks, [&](int task) {
    const int begin = task * kLinesPerTask, n = std::min(kLinesPerTask, n_lines - begin);
    convolve_rows(first_line + begin, n,
                  out.subspan(per_line * static_cast<std::size_t>(begin),
                              per_line * static_cast<std::size_t>(n)));
  });
}

}  // namespace reseau::sim
