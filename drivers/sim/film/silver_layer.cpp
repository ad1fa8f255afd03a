#include "drivers/sim/film/silver_layer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "drivers/sim/film.h"
#include "drivers/sim/film/element_response.h"
#include "drivers/sim/film/light_rows.h"

namespace reseau::sim {
namespace {

constexpr int kMostParts = 4, kPartsOfTents = 3;  // of a cell, along each side

// Luminance of Rec. 601, as black-and-white film without a filter roughly sees it.
constexpr std::array<float, 3> kLuminance{0.30F, 0.59F, 0.11F};

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

// Rows of areas at the grid of cells, painted for the exposure and kept until they are asked for.
struct SilverLayer::Painted {
  std::uint64_t id = 0;
  CellRange cells;
  std::vector<std::int64_t> row_in_slot;
  std::vector<PlaneRow> slots;
};

// Rows of parts of tents, summed along x: neighbouring rows of cells have some in common.
struct SilverLayer::Parts {
  std::uint64_t id = 0;
  CellRange cells;
  std::array<std::int64_t, 8> row_in_slot{};
  std::array<std::vector<float>, 8> slots;
  std::vector<float> fine;
};

SilverLayer::Painted& SilverLayer::painted_of_thread() {
  thread_local Painted painted;
  return painted;
}

SilverLayer::SilverLayer(const FilmSpec& spec, const FilmStrip& strip,
                         const ElementPainter* painter)
    : strip_(strip),
      painter_(painter),
      taking_(make_taking(spec.emulsion.ideal_taking)),
      light_px_(spec.emulsion.spread_um / spec.frame.pixel_um),
      silver_px_(spec.emulsion.silver_spread_um / spec.frame.pixel_um),
      reach_px_(kReach * (light_px_ + silver_px_)),
      id_(next_id()) {
  if (!spreads()) return;
  before_.reset(new SilverLayer(Before{this}));
  if (painter == nullptr || !strip.has_fine_detail()) return;
  constexpr int kPlaces = 9;
  for (int j = 0; j < kPlaces; ++j) {
    const double y = (spec.frame.height_px - 1.0) * j / (kPlaces - 1);
    for (int px = 0; px < spec.frame.width_px; px += kBlockPx) {
      finest_ = std::max(finest_, strip.finest_cy_per_px(y, px - 0.5, px + kBlockPx - 0.5));
    }
  }
}

SilverLayer::SilverLayer(const Before& before)
    : strip_(before.layer->strip_),
      painter_(before.layer->painter_),
      taking_(before.layer->taking_),
      light_px_(0),
      silver_px_(0),
      reach_px_(before.layer->reach_px_),
      id_(before.layer->id_),
      curved_(before.layer->light_px_ == 0),
      keeps_(true) {}

const PlaneRow& SilverLayer::painted(double y, const CellRange& cells) const {
  Painted& rows = painted_of_thread();
  // As far ahead and behind as spreads reach and light rows look.
  const auto n_slots = static_cast<std::int64_t>(std::ceil(2 * reach_px_ * cells.per_px)) + 12;
  if (rows.id != id_ || rows.cells != cells || std::ssize(rows.slots) != n_slots) {
    rows.id = id_;
    rows.cells = cells;
    rows.row_in_slot.assign(static_cast<std::size_t>(n_slots), INT64_MIN);
    rows.slots.resize(static_cast<std::size_t>(n_slots));
  }
  const std::int64_t j = std::llround((y + 0.5) * cells.per_px - 0.5);
  const auto slot = static_cast<std::size_t>((j % n_slots + n_slots) % n_slots);
  if (rows.row_in_slot[slot] != j) {
    painter_->areas(y, cells.first_px, cells.n_px, cells.per_px, rows.slots[slot], cells.tents);
    rows.row_in_slot[slot] = j;
  }
  return rows.slots[slot];
}

void SilverLayer::areas(double y, const CellRange& cells, PlaneRow& out) const {
  if (keeps_) {
    out = painted(y, cells);
    return;
  }
  const Painted& rows = painted_of_thread();
  const double at = (y + 0.5) * cells.per_px - 0.5;
  const std::int64_t j = std::llround(at);
  const auto n_slots = static_cast<std::int64_t>(rows.slots.size());
  const int skip = cells.first_px - rows.cells.first_px;
  if (spreads() && rows.id == id_ && rows.cells.per_px == cells.per_px &&
      rows.cells.tents == cells.tents && skip >= 0 && skip + cells.n_px <= rows.cells.n_px &&
      std::abs(static_cast<double>(j) - at) < 1e-6) {
    const auto slot = static_cast<std::size_t>((j % n_slots + n_slots) % n_slots);
    if (rows.row_in_slot[slot] == j) {
      const auto n_planes = static_cast<int>(painter_->sets().size());
      out.resize(cells.first_px, cells.n_px, cells.per_px, n_planes);
      for (int k = 0; k < n_planes; ++k) {
        for (int s = 0; s < cells.per_px; ++s) {
          std::copy_n(rows.slots[slot].phase(k, s) + skip, cells.n_px, out.phase(k, s));
        }
      }
      return;
    }
  }
  painter_->areas(y, cells.first_px, cells.n_px, cells.per_px, out, cells.tents);
}

void SilverLayer::exposure_behind_sets(double y, const CellRange& cells, PlaneRow& out) const {
  const auto& [first_px, n_px, per_px, tents] = cells;
  // Exposures behind red, green and blue, cell by cell in the order of the place.
  thread_local std::vector<float> scratch;
  const auto n = static_cast<std::size_t>(n_px) * static_cast<std::size_t>(per_px);
  scratch.resize(3 * n);
  const std::array<float*, 3> rgb{scratch.data(), scratch.data() + n, scratch.data() + 2 * n};
  const double x0 = first_px + cell_offset_px(0, per_px), side = 1.0 / per_px;
  strip_.exposure_cells(y, x0, side, {{rgb[0], n}, {rgb[1], n}, {rgb[2], n}},
                        tents && strip_.has_fine_detail());
  const std::size_t n_planes = painter_ == nullptr ? 1 : painter_->sets().size();
  out.resize(first_px, n_px, per_px, static_cast<int>(n_planes));
  for (std::size_t k = 0; k < n_planes; ++k) {
    std::array<float, 3> weight = kLuminance;
    if (painter_ != nullptr) {
      const auto set = static_cast<std::size_t>(painter_->sets()[k]);
      weight.fill(0.0F);
      const bool all = set == 0;
      const int count = all ? 3 : static_cast<int>((set & 1) + (set >> 1 & 1) + (set >> 2 & 1));
      for (std::size_t dye = 0; dye < 3 && set != kOpaque; ++dye) {
        if (all || (set >> dye & 1) != 0) {
          weight[dye] = static_cast<float>(taking_.gain[set] / count);
        }
      }
    }
    const bool single = painter_ != nullptr && std::ranges::count(weight, 0.0F) == 2;
    const auto own = static_cast<std::size_t>(std::ranges::max_element(weight) - weight.begin());
    for (int s = 0; s < per_px; ++s) {
      float* const to = out.phase(static_cast<int>(k), s);
      const auto step = static_cast<std::size_t>(per_px), px = static_cast<std::size_t>(n_px);
      const float *const r = rgb[0] + s, *const g = rgb[1] + s, *const b = rgb[2] + s;
      if (single) {
        const float* const from = rgb[own] + s;
        for (std::size_t i = 0; i < px; ++i) to[i] = from[i * step];
        continue;
      }
      for (std::size_t i = 0; i < px; ++i) {
        to[i] = weight[0] * r[i * step] + weight[1] * g[i * step] + weight[2] * b[i * step];
      }
    }
  }
}

void SilverLayer::behind_sets(double y, const CellRange& cells, PlaneRow& out) const {
  exposure_behind_sets(y, cells, out);
  if (!curved_) return;
  const std::size_t n_planes = painter_ == nullptr ? 1 : painter_->sets().size();
  const bool identity = strip_.hd_curve().is_identity();
  for (std::size_t k = 0; k < n_planes; ++k) {
    const std::span<float> plane(out.plane(static_cast<int>(k)), out.plane_size());
    strip_.hd_curve().apply(plane);
    // More light than white needs cannot make the film clearer than clear.
    if (identity) {
      for (float& t : plane) t = std::min(t, 1.0F);
    }
  }
}

int SilverLayer::parts_of(const CellRange& cells) const {
  // Steps lie within cells of any size.
  const int steps_at = strip_.has_steps() ? FilmStrip::kWholeCellsAt : cells.per_px;
  const auto too_fine = [&](int parts) {
    return finest_ * FilmStrip::kWholeCellsAt > FilmStrip::kWholeCells * steps_at * parts;
  };
  if (cells.per_px <= 2) return 1;
  if (cells.tents) return too_fine(1) ? kPartsOfTents : 1;
  int parts = 1;
  while (parts < kMostParts && too_fine(parts)) parts *= 2;
  return parts;
}

void SilverLayer::exposure_row(double y, const CellRange& cells, std::vector<float>& out) const {
  const int parts = parts_of(cells);
  if (parts == 1) {
    exposure_as_is(y, cells, out);
    return;
  }
  if (cells.tents) {
    exposure_of_tents(y, cells, parts, out);
    return;
  }
  // What lies behind an element changes within the cell: means of its parts.
  thread_local std::vector<float> fine;
  const std::size_t n = cells.size();
  const auto n_parts = static_cast<std::size_t>(parts);
  const auto share = static_cast<float>(1.0 / (parts * parts));
  const CellRange finer{cells.first_px, cells.n_px, cells.per_px * parts};
  out.assign(n, 0.0F);
  for (int j = 0; j < parts; ++j) {
    const double at = y + ((j + 0.5) / parts - 0.5) / cells.per_px;
    exposure_as_is(at, finer, fine);
    for (std::size_t i = 0; i < n; ++i) {
      float sum = 0;
      for (std::size_t k = 0; k < n_parts; ++k) sum += fine[i * n_parts + k];
      out[i] += share * sum;
    }
  }
}

// A tent is a sum of tents of a third of its side, weights 1 2 3 2 1.
void SilverLayer::exposure_of_tents(double y, const CellRange& cells, int parts,
                                    std::vector<float>& out) const {
  thread_local Parts rows;
  if (rows.id != id_ || rows.cells != cells) {
    rows.id = id_;
    rows.cells = cells;
    rows.row_in_slot.fill(INT64_MIN);
  }
  const CellRange finer{cells.first_px, cells.n_px, cells.per_px * parts, true};
  const auto n = static_cast<std::int64_t>(cells.size());
  const auto weight = [parts](int k) {
    return static_cast<float>(parts - std::abs(k)) / static_cast<float>(parts * parts);
  };
  const std::int64_t middle =
      std::llround((y + 0.5) * cells.per_px - 0.5) * parts + (parts - 1) / 2;
  out.assign(cells.size(), 0.0F);
  for (int j = 1 - parts; j < parts; ++j) {
    const std::int64_t row = middle + j;
    const auto slot = static_cast<std::size_t>(row & 7);
    std::vector<float>& joined = rows.slots[slot];
    if (rows.row_in_slot[slot] != row) {
      rows.row_in_slot[slot] = row;
      const double at = (static_cast<double>(row) + 0.5) / finer.per_px - 0.5;
      exposure_as_is(at, finer, rows.fine);
      joined.assign(cells.size(), 0.0F);
      const std::int64_t last = n * parts - 1;
      for (std::int64_t i = 0; i < n; ++i) {
        for (int k = 1 - parts; k < parts; ++k) {
          const std::int64_t part = i * parts + (parts - 1) / 2 + k;
          joined[static_cast<std::size_t>(i)] +=
              weight(k) *
              rows.fine[static_cast<std::size_t>(std::clamp<std::int64_t>(part, 0, last))];
        }
      }
    }
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight(j) * joined[i];
  }
}

void SilverLayer::exposure_as_is(double y, const CellRange& cells, std::vector<float>& out) const {
  thread_local LightRows rows;
  const FilmLayers film{strip_, painter_, *before_, nullptr, nullptr, false, id_};
  const PlaneRow& light = rows.row(film, y, cells, false);
  const auto n = static_cast<std::size_t>(cells.n_px), per = static_cast<std::size_t>(cells.per_px);
  out.assign(n * per, 0.0F);
  const std::size_t n_planes = painter_ == nullptr ? 1 : painter_->sets().size();
  for (std::size_t k = 0; k < n_planes; ++k) {
    for (std::size_t s = 0; s < per; ++s) {
      const float* const from = light.phase(static_cast<int>(k), static_cast<int>(s));
      for (std::size_t i = 0; i < n; ++i) out[i * per + s] += from[i];
    }
  }
}

}  // namespace reseau::sim
