#include "drivers/sim/optical_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <numbers>
#include <thread>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "drivers/sim/cell_source.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/widest.h"

namespace reseau::sim {
namespace {

// Tasks that follow each other on a thread go on with the rows of cells that both need.
constexpr int kLinesPerTask = 32;
constexpr std::size_t kMostIdle = 8;
constexpr int kBatch = 4;           // lines that share one pass over the rows of cells
constexpr std::size_t kBlock = 64;  // cells that lie together in memory, row by row
constexpr int kFocusStepPx = 16;
constexpr int kPreviewPitch = 4;
// Cells of slack at both ends of the rows, for the padding of the tables.
constexpr std::size_t kSlack = 8;

// Eight floats, a notation both compilers have: two registers where processors have no wider ones.
using F8 = float __attribute__((vector_size(32)));

// A block of n weighted sums of rows, stride floats apart; weights: [row][4].
template <std::size_t n>
RESEAU_SIM_INLINE inline void sum_block(const float* rows, const std::vector<std::size_t>& slots,
                                        const float* weights, float* to, std::size_t stride) {
  for (std::size_t k = 0; k < kBlock; k += 16) {
    F8 low[n] = {}, high[n] = {};
    for (std::size_t t = 0; t < slots.size(); ++t) {
      const float* const p = rows + slots[t] + k;
      F8 v0, v1;
      std::memcpy(&v0, p, sizeof v0);
      std::memcpy(&v1, p + 8, sizeof v1);
      const float* const w = weights + 4 * t;
      for (std::size_t r = 0; r < n; ++r) {
        const F8 same{w[r], w[r], w[r], w[r], w[r], w[r], w[r], w[r]};
        low[r] += same * v0;
        high[r] += same * v1;
      }
    }
    for (std::size_t r = 0; r < n; ++r) {
      std::memcpy(to + r * stride + k, &low[r], sizeof low[r]);
      std::memcpy(to + r * stride + k + 8, &high[r], sizeof high[r]);
    }
  }
}

template <std::size_t n>
void block_sums(const float* rows, const std::vector<std::size_t>& slots, const float* weights,
                float* to, std::size_t stride) {
  widest([&]() RESEAU_SIM_INLINE { sum_block<n>(rows, slots, weights, to, stride); });
}

// A Gaussian as wide as the lens where it still transfers well, for previews.
OpticsSpec preview_optics(const OpticsSpec& optics) {
  constexpr double kPi = std::numbers::pi, kAt = 0.2;
  OpticsSpec preview = optics;
  for (std::size_t c = 0; c < kChannels; ++c) {
    const OpticalTransfer lens(optics, static_cast<int>(c));
    const double t = std::clamp(lens.sharp(kAt, 0, 0), 0.01, 1.0);
    const double sigma = std::sqrt(-std::log(t) / (2 * kPi * kPi * kAt * kAt));
    preview.blur_px[c] = std::max(sigma, 1.0);
    preview.f_number[c] = 0;
  }
  preview.aperture_px = 1;
  preview.aperture_y_px = 1;
  return preview;
}

}  // namespace

// A line on its way: where it looks and how far from focus it is.
struct OpticalRenderer::Line {
  double y = 0;            // nominal
  StageError error;        // of the line
  std::vector<float> sum;  // [component][cell + slack] after the pass along y
  std::size_t stride = 0;
  std::vector<std::size_t> slots;  // of the rows under it, in floats from a block's begin
  std::vector<float> weights;      // [row][four components]
};

// Where a channel of it looks along y: a place on the film.
double OpticalRenderer::looks_at(const Line& line, int channel) const {
  return line.y + line.error.y + optics_.shift_y_px[static_cast<std::size_t>(channel)];
}

struct OpticalRenderer::Work {
  Work(const OpticalRenderer& r, const std::shared_ptr<const Film>& film, const CellGrid& grid)
      : source(film, grid, r.first_px_, r.n_px_),
        n_cells(static_cast<std::size_t>(r.n_px_) * static_cast<std::size_t>(grid.per_px)),
        n_blocks((n_cells + kBlock - 1) / kBlock) {
    for (auto& row : fresh) row.resize(n_blocks * kBlock);
    if (r.far_) far.emplace_back(*r.far_);
    int rank = 0;
    for (const PsfFamily& family : r.families_) rank = std::max(rank, family.rank());
    lines.resize(kBatch);
    for (Line& line : lines) {
      line.stride = n_blocks * kBlock + 2 * kSlack;
      line.sum.assign(static_cast<std::size_t>((rank + 3) / 4 * 4) * line.stride, 0.0F);
    }
  }
  void reserve(std::size_t n) {
    if (n <= n_slots) return;
    n_slots = n + 8;
    slot_row.assign(n_slots, INT64_MIN);
    rows.resize(kChannels * n_blocks * n_slots * kBlock);
  }
  [[nodiscard]] std::size_t slot_of(std::int64_t row) const {
    const auto n = static_cast<std::int64_t>(n_slots);
    return static_cast<std::size_t>(((row % n) + n) % n);
  }

  CellSource source;
  std::size_t n_cells, n_blocks, n_slots = 0;
  std::vector<std::int64_t> slot_row;
  std::vector<float> rows;  // [channel][block][slot][cell of the block]
  std::array<std::vector<float>, kChannels> fresh;
  std::vector<FarField::Reader> far;  // one or none
  std::vector<Line> lines;
  std::vector<float> tables;  // per focus, for the fraction of a cell of this line
  std::vector<float> focus;   // index among the tables, per pixel
  std::vector<double> x;
  std::vector<float> optical;
  int next_line = 0;  // the one after the last that was rendered
  std::thread::id of_thread;
};

// What tasks leave behind for those that follow.
struct OpticalRenderer::Pool {
  // That of the lines before, else one that this thread left, else none.
  std::unique_ptr<Work> take(int first_line) {
    const std::scoped_lock lock(mutex);
    auto found = std::ranges::find(idle, first_line, [](const auto& w) { return w->next_line; });
    if (found == idle.end()) {
      found = std::ranges::find(idle, std::this_thread::get_id(),
                                [](const auto& w) { return w->of_thread; });
    }
    if (found == idle.end()) return nullptr;
    std::unique_ptr<Work> work = std::move(*found);
    idle.erase(found);
    return work;
  }
  void give(std::unique_ptr<Work> work) {
    const std::scoped_lock lock(mutex);
    if (idle.size() >= kMostIdle) idle.erase(idle.begin());
    idle.push_back(std::move(work));
  }

  std::mutex mutex;
  std::vector<std::unique_ptr<Work>> idle;
};

OpticalRenderer::~OpticalRenderer() = default;

void OpticalRenderer::set_focus_range(double& low, double& high) const {
  constexpr int kSteps = 48;
  low = high = focus_.common_um(window_.optical_x(0), window_.optical_y(0));
  for (int j = 0; j <= kSteps; ++j) {
    const double y = window_.optical_y(static_cast<double>(window_.n_lines - 1) * j / kSteps);
    for (int i = 0; i <= kSteps; ++i) {
      const double x = window_.optical_x(static_cast<double>(window_.width_px - 1) * i / kSteps);
      const double z = focus_.common_um(x, y);
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  // The film may bulge between the places asked.
  const double margin = 0.05 * (high - low);
  low -= margin;
  high += margin;
}

OpticalRenderer::OpticalRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                                 const ScanWindow& window, const ScanGeometry& geometry)
    : film_(std::move(film)),
      optics_(window.pitch >= kPreviewPitch ? preview_optics(optics) : optics),
      window_(window),
      geometry_(geometry),
      focus_(film_, optics_, geometry_),
      pool_(std::make_unique<Pool>()) {
  std::vector<OpticalTransfer> transfers;
  transfers.reserve(kChannels);
  for (int c = 0; c < kChannels; ++c) transfers.emplace_back(optics_, c);
  grid_ = choose_grid(cells_used(*film_, optics, window.pitch, true), transfers,
                      optics.fewest_cells_per_px);
  grid_.tents = takes_tents(*film_, window.pitch);
  double low = 0, high = 0;
  set_focus_range(low, high);
  FarFieldSpec far;
  for (int c = 0; c < kChannels; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double shift = focus_.chromatic_um(c);
    families_.emplace_back(transfers[k], grid_, low + shift, high + shift);
    focus_varies_ = focus_varies_ || families_.back().n_focus() > 1;
    reach_cells_ = std::max(reach_cells_, families_.back().reach_cells());
    far.wide[k] = wide_gaussians(transfers[k]);
  }

  const Film::Extent extent = film_->extent();
  const int n_optical = window.width_px * window.pitch;
  active_begin_ = std::clamp(extent.begin_px - window.x_px, 0, n_optical);
  n_active_ = std::clamp(extent.end_px - window.x_px, active_begin_, n_optical) - active_begin_;
  double leftmost = window.x_px + active_begin_, rightmost = leftmost;
  for (int c = 0; c < kChannels; ++c) {
    const auto k = static_cast<std::size_t>(c);
    regular_x_ = regular_x_ && optics_.distortion == 0 && optics_.stretch_px[k] == 0;
    for (int i = 0; i < n_active_; ++i) {
      x_place_[k].push_back(geometry_.through_lens(c, window.x_px + active_begin_ + i));
      leftmost = std::min(leftmost, x_place_[k].back());
      rightmost = std::max(rightmost, x_place_[k].back());
    }
  }
  const double sideways = geometry_.largest().x + 1;
  const int reach_px = reach_cells_ / grid_.per_px + 3;
  first_px_ = floor_to_block(static_cast<int>(std::floor(leftmost - sideways)) - reach_px);
  n_px_ = floor_to_block(static_cast<int>(std::ceil(rightmost + sideways)) + reach_px + kBlockPx) -
          first_px_;
  far.flare = optics_.flare;
  far.begin_px = static_cast<int>(std::floor(leftmost - sideways));
  far.end_px = static_cast<int>(std::ceil(rightmost + sideways));
  far.field_end_px = std::max(geometry_.field_px(), 1);
  far_ = std::make_unique<FarField>(film_, std::move(far));
  if (far_->is_empty()) far_.reset();
}

void OpticalRenderer::load_rows(std::int64_t first, std::int64_t last, Work& work) const {
  work.reserve(static_cast<std::size_t>(last - first + 1));
  for (std::int64_t j = first; j <= last; ++j) {
    const std::size_t slot = work.slot_of(j);
    if (work.slot_row[slot] == j) continue;
    work.slot_row[slot] = j;
    work.source.read(j, {work.fresh[0], work.fresh[1], work.fresh[2], work.fresh[3]});
    for (std::size_t c = 0; c < kChannels; ++c) {
      for (std::size_t block = 0; block < work.n_blocks; ++block) {
        std::memcpy(work.rows.data() + ((c * work.n_blocks + block) * work.n_slots + slot) * kBlock,
                    work.fresh[c].data() + block * kBlock, kBlock * sizeof(float));
      }
    }
  }
}

void OpticalRenderer::sum_along_y(int n_lines, int channel, Work& work) const {
  const PsfFamily& family = families_[static_cast<std::size_t>(channel)];
  const float* const rows =
      work.rows.data() + static_cast<std::size_t>(channel) * work.n_blocks * work.n_slots * kBlock;
  // Four components at a time.
  for (int group = 0; group < family.rank(); group += 4) {
    const int n_group = std::min(4, family.rank() - group);
    int reach = 0;
    for (int r = 0; r < n_group; ++r) reach = std::max(reach, family.reach_cells(group + r));
    const std::size_t n_taps = 2 * static_cast<std::size_t>(reach) + 2;
    for (int b = 0; b < n_lines; ++b) {
      Line& line = work.lines[static_cast<std::size_t>(b)];
      const double at = (looks_at(line, channel) + 0.5) * grid_.per_px - 0.5;
      const auto base = static_cast<std::int64_t>(std::floor(at));
      line.slots.resize(n_taps);
      line.weights.assign(4 * n_taps, 0.0F);
      for (std::size_t t = 0; t < n_taps; ++t) {
        const std::int64_t row = base - reach + static_cast<std::int64_t>(t);
        line.slots[t] = work.slot_of(row) * kBlock;
        for (int r = 0; r < n_group; ++r) {
          const double w = family.along_y(group + r, static_cast<double>(row) - at);
          line.weights[4 * t + static_cast<std::size_t>(r)] = static_cast<float>(w);
        }
      }
    }
    // The lines of a batch read almost the same rows: block by block those stay close by.
    for (std::size_t block = 0; block < work.n_blocks; ++block) {
      const float* const from = rows + block * work.n_slots * kBlock;
      for (int b = 0; b < n_lines; ++b) {
        Line& line = work.lines[static_cast<std::size_t>(b)];
        float* const to = line.sum.data() + static_cast<std::size_t>(group) * line.stride + kSlack +
                          block * kBlock;
        const auto sums = n_group == 1   ? block_sums<1>
                          : n_group == 2 ? block_sums<2>
                          : n_group == 3 ? block_sums<3>
                                         : block_sums<4>;
        sums(from, line.slots, line.weights.data(), to, line.stride);
      }
    }
  }
}

namespace {

// Sum over components and cells of n blended tables times the sums along y. begin: cell of the
// first weight of component r is begin - reach of r.
template <int n>
RESEAU_SIM_INLINE inline float blended_dot(const PsfFamily& family, const float* sums,
                                           std::size_t stride, std::size_t begin,
                                           const std::array<const float*, 4>& tables,
                                           const std::array<float, 4>& share) {
  F8 sum{}, by[n];
  for (std::size_t k = 0; k < n; ++k) {
    by[k] = F8{} + share[k];
  }
  for (int r = 0; r < family.rank(); ++r) {
    const float* const v = sums + static_cast<std::size_t>(r) * stride + begin -
                           static_cast<std::size_t>(family.reach_cells(r));
    const std::size_t offset = family.offset(r);
    const auto taps = static_cast<std::size_t>(family.taps(r));
    const auto part = [&](std::size_t t, std::size_t bytes) RESEAU_SIM_INLINE {
      F8 w{}, of{};
      std::memcpy(&of, v + t, bytes);
      for (std::size_t k = 0; k < n; ++k) {
        F8 table{};
        std::memcpy(&table, tables[k] + offset + t, bytes);
        w = k == 0 ? by[k] * table : w + by[k] * table;
      }
      sum += w * of;
    };
    std::size_t t = 0;
    for (; t + 8 <= taps; t += 8) part(t, sizeof(F8));
    if (t < taps) part(t, sizeof(F8) / 2);
  }
  const float a = sum[0] + sum[4], b = sum[1] + sum[5], c = sum[2] + sum[6], d = sum[3] + sum[7];
  return (a + b) + (c + d);
}

}  // namespace

void OpticalRenderer::sum_along_x(const Line& line, int channel, Work& work,
                                  std::span<float> out) const {
  const auto c = static_cast<std::size_t>(channel);
  const PsfFamily& family = families_[c];
  const bool flat = family.n_focus() == 1;
  const auto n = static_cast<std::size_t>(n_active_);
  work.x.resize(n);
  for (std::size_t i = 0; i < n; ++i) work.x[i] = x_place_[c][i] + line.error.x;
  if (!flat) {
    // Height and field change slowly: between places 16 pixels apart they are straight.
    const double y = line.y + line.error.y;
    work.focus.resize(n);
    const auto index_at = [&](int px) {
      return family.focus_index(focus_.defocus_um(channel, px, y));
    };
    int at = floor_to_block(window_.x_px + active_begin_);
    double left = index_at(at), right = index_at(at + kFocusStepPx);
    for (std::size_t i = 0; i < n; ++i) {
      const int px = window_.x_px + active_begin_ + static_cast<int>(i);
      if (px >= at + kFocusStepPx) {
        at += kFocusStepPx;
        left = right;
        right = index_at(at + kFocusStepPx);
      }
      const double t = static_cast<double>(px - at) / kFocusStepPx;
      work.focus[i] = static_cast<float>(left + t * (right - left));
    }
  }
  const auto cell_of = [&](double x) { return (x + 0.5 - first_px_) * grid_.per_px - 0.5; };
  const std::size_t size = family.table_size();
  const auto n_focus = static_cast<std::size_t>(family.n_focus());
  if (regular_x_ && n > 0) {
    // One fraction of a cell for the whole line.
    const double first = cell_of(work.x[0]), fraction = first - std::floor(first);
    const double at = fraction * PsfFamily::kPhases;
    const int phase = std::min(static_cast<int>(at), PsfFamily::kPhases - 1);
    const auto t = static_cast<float>(at - phase);
    work.tables.resize(n_focus * size);
    for (std::size_t k = 0; k < n_focus; ++k) {
      const float* a = family.table(static_cast<int>(k), phase);
      const float* b = family.table(static_cast<int>(k), phase + 1);
      float* to = work.tables.data() + k * size;
      for (std::size_t j = 0; j < size; ++j) to[j] = a[j] + t * (b[j] - a[j]);
    }
  }
  const float* const sums = line.sum.data();
  const auto first_cell =
      regular_x_ && n > 0 ? static_cast<std::size_t>(std::floor(cell_of(work.x[0]))) : 0;
  const auto at_pixel = [&](std::size_t i) RESEAU_SIM_INLINE {
    std::array<const float*, 4> tables{};
    std::array<float, 4> share{1, 0, 0, 0};
    int focus = 0;
    float f = 0;
    if (!flat) {
      focus = std::min(static_cast<int>(work.focus[i]), family.n_focus() - 2);
      f = work.focus[i] - static_cast<float>(focus);
    }
    if (regular_x_) {
      const std::size_t begin = first_cell + i * static_cast<std::size_t>(grid_.per_px) + kSlack;
      tables[0] = work.tables.data() + static_cast<std::size_t>(focus) * size;
      if (flat) {
        out[i] = blended_dot<1>(family, sums, line.stride, begin, tables, share);
      } else {
        tables[1] = tables[0] + size;
        share = {1 - f, f, 0, 0};
        out[i] = blended_dot<2>(family, sums, line.stride, begin, tables, share);
      }
      return;
    }
    const double at = cell_of(work.x[i]), below = std::floor(at);
    const double at_phase = (at - below) * PsfFamily::kPhases;
    const int phase = std::min(static_cast<int>(at_phase), PsfFamily::kPhases - 1);
    const auto t = static_cast<float>(at_phase - phase);
    const std::size_t begin = static_cast<std::size_t>(below) + kSlack;
    tables[0] = family.table(focus, phase);
    tables[1] = family.table(focus, phase + 1);
    if (flat) {
      share = {1 - t, t, 0, 0};
      out[i] = blended_dot<2>(family, sums, line.stride, begin, tables, share);
    } else {
      tables[2] = family.table(focus + 1, phase);
      tables[3] = family.table(focus + 1, phase + 1);
      share = {(1 - t) * (1 - f), t * (1 - f), (1 - t) * f, t * f};
      out[i] = blended_dot<4>(family, sums, line.stride, begin, tables, share);
    }
  };
  widest([&]() RESEAU_SIM_INLINE {
    for (std::size_t i = 0; i < n; ++i) at_pixel(i);
  });
}

void OpticalRenderer::render(int first_line, int n_lines, std::span<float> out) const {
  std::unique_ptr<Work> taken = pool_->take(first_line);
  if (taken == nullptr) taken = std::make_unique<Work>(*this, film_, grid_);
  Work& work = *taken;
  const auto width = static_cast<std::size_t>(window_.width_px);
  const auto pitch = static_cast<std::size_t>(window_.pitch);
  work.optical.resize(pitch == 1 ? 0 : width * pitch);
  for (int batch = 0; batch < n_lines; batch += kBatch) {
    const int n_batch = std::min(kBatch, n_lines - batch);
    double top = 0, bottom = 0;
    for (int b = 0; b < n_batch; ++b) {
      Line& line = work.lines[static_cast<std::size_t>(b)];
      line.y = window_.optical_y(first_line + batch + b);
      line.error = geometry_.line_error(line.y);
      for (int c = 0; c < kChannels; ++c) {
        const double y = looks_at(line, c);
        top = b == 0 && c == 0 ? y : std::min(top, y);
        bottom = b == 0 && c == 0 ? y : std::max(bottom, y);
      }
    }
    const auto row_of = [&](double y) {
      return static_cast<std::int64_t>(std::floor((y + 0.5) * grid_.per_px - 0.5));
    };
    load_rows(row_of(top) - reach_cells_, row_of(bottom) + reach_cells_ + 1, work);
    for (int c = 0; c < kChannels; ++c) {
      sum_along_y(n_batch, c, work);
      for (int b = 0; b < n_batch; ++b) {
        const Line& line = work.lines[static_cast<std::size_t>(b)];
        const std::size_t at =
            (static_cast<std::size_t>(batch + b) * kChannels + static_cast<std::size_t>(c)) * width;
        const std::span<float> target =
            pitch == 1 ? out.subspan(at, width) : std::span<float>(work.optical);
        std::ranges::fill(target, 0.0F);
        const std::span<float> active = target.subspan(static_cast<std::size_t>(active_begin_),
                                                       static_cast<std::size_t>(n_active_));
        sum_along_x(line, c, work, active);
        if (!work.far.empty()) {
          const double y = looks_at(line, c);
          work.far[0].add(c, y, work.x, active);
          if (optics_.flare > 0) {
            const auto g = static_cast<float>(optics_.flare);
            const float veil = g * work.far[0].slit_mean(c, y);
            for (float& v : active) v = (1 - g) * v + veil;
          }
        }
        if (pitch == 1) continue;
        for (std::size_t i = 0; i < width; ++i) {
          float sum = 0;
          for (std::size_t k = 0; k < pitch; ++k) sum += work.optical[i * pitch + k];
          out[at + i] = sum / static_cast<float>(pitch);
        }
      }
    }
  }
  work.next_line = first_line + n_lines;
  work.of_thread = std::this_thread::get_id();
  pool_->give(std::move(taken));
}

void OpticalRenderer::transmittance(int first_line, int n_lines, std::span<float> out) const {
  const std::size_t per_line =
      static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(window_.width_px);
  const int n_tasks = (n_lines + kLinesPerTask - 1) / kLinesPerTask;
  parallel_for(n_tasks, [&](int task) {
    const int first = task * kLinesPerTask, n = std::min(kLinesPerTask, n_lines - first);
    render(first_line + first, n,
           out.subspan(per_line * static_cast<std::size_t>(first),
                       per_line * static_cast<std::size_t>(n)));
  });
}

}  // namespace reseau::sim
