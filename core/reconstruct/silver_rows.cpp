#include "core/reconstruct/silver_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/reconstruct/cubic_weights.h"

namespace reseau {
namespace {

constexpr std::array<Channel, 4> kChannels{Channel::kRed, Channel::kGreen, Channel::kBlue,
                                           Channel::kInfrared};
// Nothing on a film is brighter than this many times clear film; a tone curve may be.
constexpr float kMostSilver = 64;
// Interpolation beyond the border looks this far to the sides.
constexpr int kSampleReach = 2;
constexpr int kMostPeriods = 12;

// The shortest translation by whole periods that goes at least `depth` along `inward`.
Vec2 way_inside(const std::array<Vec2, 2>& period, Vec2 inward, double depth) {
  Vec2 best{};
  double least = 1e30;
  for (int b = -kMostPeriods; b <= kMostPeriods; ++b) {
    for (int a = -kMostPeriods; a <= kMostPeriods; ++a) {
      const Vec2 way = static_cast<double>(a) * period[0] + static_cast<double>(b) * period[1];
      const double in = dot(way, inward);
      if (in < depth) continue;
      const double cost = in + 2 * std::abs(cross(way, inward));
      if (cost < least) {
        least = cost;
        best = way;
      }
    }
  }
  return best;
}

}  // namespace

SilverRows::SilverRows(const SilverSettings& settings, int first, int end)
    : margin_(settings.margin_px +
              (settings.sharpener != nullptr ? settings.sharpener->reach_px() : 0)),
      top_(first - margin_),
      rows_(end - first + 2 * margin_),
      stride_(static_cast<std::size_t>(settings.source->format().width_px + 2 * margin_ + 3) / 4 *
              4),
      values_(stride_ * static_cast<std::size_t>(rows_) + 4) {
  read(settings, first, end);
  continue_beyond(settings);
  if (settings.sharpener == nullptr) return;
  // Rows far outside the last margin do not exist.
  const int y0 = std::max(top_, -margin_),
            y1 = std::min(top_ + rows_, settings.source->committed() + margin_);
  settings.sharpener->sharpen({&values_[static_cast<std::size_t>(y0 - top_) * stride_],
                               static_cast<std::ptrdiff_t>(stride_), -margin_, y0,
                               settings.source->format().width_px + 2 * margin_, y1 - y0});
}

void SilverRows::read(const SilverSettings& settings, int first, int end) {
  const LineFormat& format = settings.source->format();
  const auto width = static_cast<std::size_t>(format.width_px);
  const int from = std::max(0, top_), to = std::min(settings.source->committed(), top_ + rows_);
  // A few rows at a time: what is read stays in the cache until it is used.
  constexpr int kRowsAtOnce = 8;
  std::vector<std::uint16_t> raw(format.samples_per_line() * kRowsAtOnce);
  const auto scale = static_cast<float>(1 / settings.white_level);
  for (int row = from; row < to; row += kRowsAtOnce) {
    const int n = std::min(kRowsAtOnce, to - row);
    const std::span<std::uint16_t> lines(raw.data(),
                                         format.samples_per_line() * static_cast<std::size_t>(n));
    settings.source->read(row, n, lines);
    for (int y = row; y < row + n; ++y) {
      float* out = &values_[static_cast<std::size_t>(y - top_) * stride_ +
                            static_cast<std::size_t>(margin_)];
      std::fill_n(out, width, scale * static_cast<float>(settings.offset));
      for (std::size_t c = 0; c < 4; ++c) {
        const int plane = format.plane_of(kChannels[c]);
        if (plane < 0) continue;
        const std::uint16_t* in =
            lines.data() + (static_cast<std::size_t>(y - row) * format.channels.size() +
                            static_cast<std::size_t>(plane)) *
                               width;
        if (y >= first && y < end) {
          unsigned n_clipped = 0;
          for (std::size_t x = 0; x < width; ++x) n_clipped += in[x] == 65535 ? 1U : 0U;
          clipped_[c] += n_clipped;
        }
        if (settings.infrared != (c == 3)) continue;
        const float* table = settings.tone->table(static_cast<int>(c)).data();
        const float weight =
            scale * (settings.infrared ? 1.0F : static_cast<float>(settings.silver_from_rgb[c]));
        if (settings.tone->is_linear()) {
          const float per_count = weight / 65535.0F;
          for (std::size_t x = 0; x < width; ++x) out[x] += per_count * static_cast<float>(in[x]);
        } else {
          for (std::size_t x = 0; x < width; ++x) out[x] += weight * table[in[x]];
        }
      }
      for (std::size_t x = 0; x < width; ++x)
        out[x] = std::clamp(out[x], -kMostSilver, kMostSilver);
    }
  }
}

// Catmull-Rom among the pixels of columns [0, x_end) and rows [y_first, y_end).
float SilverRows::sample(Vec2 p, int x_end, int y_first, int y_end) const {
  const double fx = std::floor(p.x), fy = std::floor(p.y);
  const auto wx = cubic_weights(static_cast<float>(p.x - fx)),
             wy = cubic_weights(static_cast<float>(p.y - fy));
  float sum = 0;
  for (int b = 0; b < 4; ++b) {
    const int y = std::clamp(static_cast<int>(fy) + b - 1, y_first, y_end - 1);
    for (int a = 0; a < 4; ++a) {
      const int x = std::clamp(static_cast<int>(fx) + a - 1, 0, x_end - 1);
      sum += wy[static_cast<std::size_t>(b)] * wx[static_cast<std::size_t>(a)] * *at(x, y);
    }
  }
  return sum;
}

void SilverRows::continue_beyond(const SilverSettings& settings) {
  const int width = settings.source->format().width_px, height = settings.source->committed();
  const int y_first = std::max(0, top_), y_end = std::min(height, top_ + rows_);
  const auto write = [this](int x, int y) {
    return &values_[static_cast<std::size_t>(y - top_) * stride_ +
                    static_cast<std::size_t>(x + margin_)];
  };
  std::vector<Vec2> from_left, from_right, from_above, from_below;
  for (int d = 1; d <= margin_; ++d) {
    const double depth = d + kSampleReach;
    from_left.push_back(way_inside(settings.period_px, {1, 0}, depth));
    from_right.push_back(way_inside(settings.period_px, {-1, 0}, depth));
    from_above.push_back(way_inside(settings.period_px, {0, 1}, depth));
    from_below.push_back(way_inside(settings.period_px, {0, -1}, depth));
  }
  const auto value = [&](int x, int y) {
    Vec2 p{static_cast<double>(x), static_cast<double>(y)};
    if (x < 0) p = p + from_left[static_cast<std::size_t>(-x - 1)];
    if (x >= width) p = p + from_right[static_cast<std::size_t>(x - width)];
    if (y < 0) p = p + from_above[static_cast<std::size_t>(-y - 1)];
    if (y >= height) p = p + from_below[static_cast<std::size_t>(y - height)];
    // In a corner that way may lead out at a side.
    const auto inside = [&](Vec2 q) {
      return q.x >= 1 && q.y >= 1 && q.x <= width - 2 && q.y <= height - 2;
    };
    if (!inside(p)) {
      const Vec2 here{static_cast<double>(x), static_cast<double>(y)};
      double least = 1e30;
      for (int j = -kMostPeriods; j <= kMostPeriods; ++j) {
        for (int i = -kMostPeriods; i <= kMostPeriods; ++i) {
          const Vec2 way = static_cast<double>(i) * settings.period_px[0] +
                           static_cast<double>(j) * settings.period_px[1];
          if (dot(way, way) >= least || !inside(here + way)) continue;
          least = dot(way, way);
          p = here + way;
        }
      }
    }
    return sample(p, width, y_first, y_end);
  };
  for (int y = top_; y < top_ + rows_; ++y) {
    const bool inside = y >= 0 && y < height;
    // Rows far outside the last margin do not exist.
    if (y < -margin_ || y >= height + margin_) continue;
    for (int x = -margin_; x < (inside ? 0 : width + margin_); ++x) *write(x, y) = value(x, y);
    if (!inside) continue;
    for (int x = width; x < width + margin_; ++x) *write(x, y) = value(x, y);
  }
}

}  // namespace reseau
