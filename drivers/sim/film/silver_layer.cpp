#include "drivers/sim/film/silver_layer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "drivers/sim/film.h"
#include "drivers/sim/film/element_response.h"

namespace reseau::sim {
namespace {

constexpr int kMostParts = 4;   // of a cell, along each side
constexpr double kReach = 4.0;  // of a Gaussian, in standard deviations

// Luminance of Rec. 601, as black-and-white film without a filter roughly sees it.
constexpr std::array<float, 3> kLuminance{0.30F, 0.59F, 0.11F};

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

// Weights of samples first … for the value at `at`, samples at whole numbers.
struct GaussWeights {
  std::int64_t first = 0;
  std::vector<float> w;
  GaussWeights(double at, double sigma) {
    first = static_cast<std::int64_t>(std::ceil(at - kReach * sigma));
    const auto last = static_cast<std::int64_t>(std::floor(at + kReach * sigma));
    double sum = 0;
    std::vector<double> weights;
    for (std::int64_t j = first; j <= last; ++j) {
      const double t = (static_cast<double>(j) - at) / sigma;
      weights.push_back(std::exp(-0.5 * t * t));
      sum += weights.back();
    }
    for (const double v : weights) w.push_back(static_cast<float>(v / sum));
  }
};

}  // namespace

// Rows of a stage, blurred along x, of the cells just behind and ahead.
struct SilverLayer::Ring {
  std::uint64_t id = 0;
  int first_px = 0, n_px = 0, per_px = 0;
  std::vector<std::int64_t> row_in_slot;
  std::vector<std::vector<float>> slots;
  std::vector<float> source;

  void prepare(std::uint64_t layer, int first, int n, int per, std::size_t n_slots) {
    if (id == layer && first_px == first && n_px == n && per_px == per && slots.size() == n_slots) {
      return;
    }
    id = layer;
    first_px = first;
    n_px = n;
    per_px = per;
    row_in_slot.assign(n_slots, INT64_MIN);
    slots.assign(n_slots, {});
  }
};

// Rows of areas at the grid of cells, painted for the exposure and kept until they are asked for.
struct SilverLayer::Painted {
  std::uint64_t id = 0;
  int first_px = 0, n_px = 0, per_px = 0;
  std::vector<std::int64_t> row_in_slot;
  std::vector<PlaneRow> slots;
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
  if (!spreads() || painter == nullptr || !strip.has_fine_detail()) return;
  constexpr int kPlaces = 9;
  for (int j = 0; j < kPlaces; ++j) {
    const double y = (spec.frame.height_px - 1.0) * j / (kPlaces - 1);
    for (int px = 0; px < spec.frame.width_px; px += kBlockPx) {
      finest_ = std::max(finest_, strip.finest_cy_per_px(y, px - 0.5, px + kBlockPx - 0.5));
    }
  }
}

const PlaneRow* SilverLayer::painted(double y, int first_px, int n_px, int per_px) const {
  if (painter_ == nullptr) return nullptr;
  Painted& rows = painted_of_thread();
  const auto n_slots = static_cast<std::int64_t>(std::ceil(2 * reach_px_ * per_px)) + 4;
  if (rows.id != id_ || rows.first_px != first_px || rows.n_px != n_px || rows.per_px != per_px ||
      std::ssize(rows.slots) != n_slots) {
    rows.id = id_;
    rows.first_px = first_px;
    rows.n_px = n_px;
    rows.per_px = per_px;
    rows.row_in_slot.assign(static_cast<std::size_t>(n_slots), INT64_MIN);
    rows.slots.resize(static_cast<std::size_t>(n_slots));
  }
  const std::int64_t j = std::llround((y + 0.5) * per_px - 0.5);
  const auto slot = static_cast<std::size_t>((j % n_slots + n_slots) % n_slots);
  if (rows.row_in_slot[slot] != j) {
    painter_->areas(y, first_px, n_px, per_px, rows.slots[slot]);
    rows.row_in_slot[slot] = j;
  }
  return &rows.slots[slot];
}

void SilverLayer::areas(double y, int first_px, int n_px, int per_px, PlaneRow& out,
                        bool tents) const {
  const Painted& rows = painted_of_thread();
  const double at = (y + 0.5) * per_px - 0.5;
  const std::int64_t j = std::llround(at);
  const auto n_slots = static_cast<std::int64_t>(rows.slots.size());
  const int skip = first_px - rows.first_px;
  if (spreads() && rows.id == id_ && rows.per_px == per_px && skip >= 0 &&
      skip + n_px <= rows.n_px && static_cast<double>(j) == at) {
    const auto slot = static_cast<std::size_t>((j % n_slots + n_slots) % n_slots);
    if (rows.row_in_slot[slot] == j) {
      const auto n_planes = static_cast<int>(painter_->sets().size());
      out.resize(first_px, n_px, per_px, n_planes);
      for (int k = 0; k < n_planes; ++k) {
        for (int s = 0; s < per_px; ++s) {
          std::copy_n(rows.slots[slot].phase(k, s) + skip, n_px, out.phase(k, s));
        }
      }
      return;
    }
  }
  painter_->areas(y, first_px, n_px, per_px, out, tents);
}

void SilverLayer::exposure_behind_sets(double y, int first_px, int n_px, int per_px, PlaneRow& out,
                                       bool tents) const {
  // Exposures behind red, green and blue, cell by cell in the order of the place.
  thread_local std::vector<float> scratch;
  const auto n = static_cast<std::size_t>(n_px) * static_cast<std::size_t>(per_px);
  scratch.resize(3 * n);
  const std::array<float*, 3> rgb{scratch.data(), scratch.data() + n, scratch.data() + 2 * n};
  const double x0 = first_px + cell_offset_px(0, per_px), side = 1.0 / per_px;
  const auto expose = [&](double to_y, double to_x, const std::array<float*, 3>& to) {
    strip_.exposure_cells(y + to_y, x0 + to_x, side, {{to[0], n}, {to[1], n}, {to[2], n}});
  };
  if (tents && strip_.has_fine_detail()) {
    // A tent is the mean of the even cells around: of four, by Gauss's rule.
    const double off = side * std::sqrt(1.0 / 12);
    thread_local std::vector<float> even;
    even.resize(3 * n);
    std::ranges::fill(scratch, 0.0F);
    for (const double down : {-off, off}) {
      for (const double across : {-off, off}) {
        expose(down, across, {even.data(), even.data() + n, even.data() + 2 * n});
        for (std::size_t i = 0; i < 3 * n; ++i) scratch[i] += 0.25F * even[i];
      }
    }
  } else {
    expose(0, 0, rgb);
  }
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
      float* to = out.phase(static_cast<int>(k), s);
      for (std::size_t i = 0; i < static_cast<std::size_t>(n_px); ++i) {
        const std::size_t at = i * static_cast<std::size_t>(per_px) + static_cast<std::size_t>(s);
        to[i] = single ? rgb[own][at]
                       : weight[0] * rgb[0][at] + weight[1] * rgb[1][at] + weight[2] * rgb[2][at];
      }
    }
  }
}

void SilverLayer::behind_sets(double y, int first_px, int n_px, int per_px, PlaneRow& out,
                              bool tents) const {
  exposure_behind_sets(y, first_px, n_px, per_px, out, tents);
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

int SilverLayer::parts_of(int per_px) const {
  int parts = 1;
  while (parts < kMostParts &&
         finest_ * FilmStrip::kWholeCellsAt > FilmStrip::kWholeCells * per_px * parts)
    parts *= 2;
  return per_px > 2 ? parts : 1;
}

void SilverLayer::exposure_row(double y, int first_px, int n_px, int per_px,
                               std::vector<float>& out) const {
  const int parts = parts_of(per_px);
  const bool curve_first = light_px_ == 0;
  if (parts == 1) {
    exposure_as_is(y, first_px, n_px, per_px, painted(y, first_px, n_px, per_px), out);
    if (curve_first) apply_curve(out);
    return;
  }
  // What lies behind an element changes within the cell: means of its parts.
  thread_local std::vector<float> fine;
  thread_local PlaneRow areas;
  const auto n = static_cast<std::size_t>(n_px) * static_cast<std::size_t>(per_px);
  const auto n_parts = static_cast<std::size_t>(parts);
  const auto share = static_cast<float>(1.0 / (parts * parts));
  out.assign(n, 0.0F);
  for (int j = 0; j < parts; ++j) {
    const double at = y + ((j + 0.5) / parts - 0.5) / per_px;
    if (painter_ != nullptr) painter_->areas(at, first_px, n_px, per_px * parts, areas);
    exposure_as_is(at, first_px, n_px, per_px * parts, painter_ == nullptr ? nullptr : &areas,
                   fine);
    if (curve_first) apply_curve(fine);
    for (std::size_t i = 0; i < n; ++i) {
      float sum = 0;
      for (std::size_t k = 0; k < n_parts; ++k) sum += fine[i * n_parts + k];
      out[i] += share * sum;
    }
  }
}

void SilverLayer::exposure_as_is(double y, int first_px, int n_px, int per_px,
                                 const PlaneRow* areas, std::vector<float>& out) const {
  thread_local PlaneRow exposure;
  exposure_behind_sets(y, first_px, n_px, per_px, exposure);
  const auto n = static_cast<std::size_t>(n_px), per = static_cast<std::size_t>(per_px);
  out.assign(n * per, 0.0F);
  const std::size_t n_planes = painter_ == nullptr ? 1 : painter_->sets().size();
  for (std::size_t k = 0; k < n_planes; ++k) {
    for (std::size_t s = 0; s < per; ++s) {
      const float* e = exposure.phase(static_cast<int>(k), static_cast<int>(s));
      const float* a =
          areas == nullptr ? nullptr : areas->phase(static_cast<int>(k), static_cast<int>(s));
      for (std::size_t i = 0; i < n; ++i) {
        out[i * per + s] += a == nullptr ? e[i] : a[i] * e[i];
      }
    }
  }
}

void SilverLayer::apply_curve(std::vector<float>& exposure) const {
  strip_.hd_curve().apply(exposure);
  if (strip_.hd_curve().is_identity()) {
    for (float& t : exposure) t = std::min(t, 1.0F);
  }
}

void SilverLayer::silver_row(double y, int first_px, int n_px, int per_px,
                             std::vector<float>& out) const {
  if (light_px_ > 0) {
    blurred(Stage::kExposure, light_px_, y, first_px, n_px, per_px, out);
    apply_curve(out);
  } else {
    exposure_row(y, first_px, n_px, per_px, out);
  }
}

void SilverLayer::blurred(Stage stage, double sigma_px, double y, int first_px, int n_px,
                          int per_px, std::vector<float>& out) const {
  const double sigma = sigma_px * per_px;
  const auto reach = static_cast<int>(std::ceil(kReach * sigma));
  const int margin_px = (reach / per_px / kBlockPx + 1) * kBlockPx;
  const auto margin = static_cast<std::size_t>(margin_px) * static_cast<std::size_t>(per_px);
  const auto n = static_cast<std::size_t>(n_px) * static_cast<std::size_t>(per_px);

  thread_local std::array<Ring, 2> rings;
  Ring& ring = rings[stage == Stage::kExposure ? 0 : 1];
  const auto n_slots = static_cast<std::size_t>(2) * static_cast<std::size_t>(reach) + 2;
  ring.prepare(id_, first_px, n_px, per_px, n_slots);

  // Row j of the grid is centred at y = (j + 0.5) / per_px - 0.5.
  const GaussWeights down((y + 0.5) * per_px - 0.5, sigma);
  const GaussWeights across(0, sigma);
  out.assign(n, 0.0F);
  for (std::size_t k = 0; k < down.w.size(); ++k) {
    const std::int64_t j = down.first + static_cast<std::int64_t>(k);
    const auto slot = static_cast<std::size_t>(
        (j % static_cast<std::int64_t>(n_slots) + static_cast<std::int64_t>(n_slots)) %
        static_cast<std::int64_t>(n_slots));
    if (ring.row_in_slot[slot] != j) {
      const double row_y = (static_cast<double>(j) + 0.5) / per_px - 0.5;
      const int first = first_px - margin_px, width = n_px + 2 * margin_px;
      std::vector<float>& source = ring.source;
      if (stage == Stage::kExposure) {
        exposure_row(row_y, first, width, per_px, source);
      } else {
        silver_row(row_y, first, width, per_px, source);
      }
      std::vector<float>& row = ring.slots[slot];
      row.assign(n, 0.0F);
      for (std::size_t t = 0; t < across.w.size(); ++t) {
        const float w = across.w[t];
        const float* from = source.data() + static_cast<std::ptrdiff_t>(margin) + across.first +
                            static_cast<std::ptrdiff_t>(t);
        for (std::size_t i = 0; i < n; ++i) row[i] += w * from[i];
      }
      ring.row_in_slot[slot] = j;
    }
    const float w = down.w[k];
    const float* from = ring.slots[slot].data();
    for (std::size_t i = 0; i < n; ++i) out[i] += w * from[i];
  }
}

void SilverLayer::field(double y, int first_px, int n_px, int per_px, PlaneRow& out) const {
  thread_local std::vector<float> row;
  if (silver_px_ > 0) {
    blurred(Stage::kSilver, silver_px_, y, first_px, n_px, per_px, row);
  } else {
    silver_row(y, first_px, n_px, per_px, row);
  }
  out.resize(first_px, n_px, per_px, 1);
  for (int s = 0; s < per_px; ++s) {
    float* to = out.phase(0, s);
    const float* from = row.data() + s;
    for (int i = 0; i < n_px; ++i) to[i] = from[i * per_px];
  }
}

}  // namespace reseau::sim
