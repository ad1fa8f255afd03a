#include "calibration/edge/edge_checks.h"

#include <algorithm>
#include <cmath>

namespace reseau {
namespace {

double predicted(const PixelModel& model, const EdgePixel& pixel, double e) {
  const EdgeLevels& l = model.levels;
  const double v = pixel.along / model.line.half_length_px;
  const double a = pixel.distance / model.reach_px;
  const double dark = l.dark + l.dark_along * v + l.dark_across * a;
  const double bright = l.bright + l.bright_along * v + l.bright_across * a;
  return dark * (1 - e) + bright * e;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Distance in widths between 98 % and the last step before 100 % of a Gaussian edge.
double last_two_percent(double step) {
  double low = 2.054, high = 4.3;
  const double rest = std::clamp(0.5 * step, 1e-5, 0.019);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / 1.4142135623730951) > rest ? low : high) = middle;
  }
  return low - 2.054;
}

}  // namespace

std::size_t leave_out_strays(Span2D<const float> samples, std::span<unsigned char> used,
                             const PixelModel& model, const ProfileFunction& profile,
                             double tolerance, double near_px) {
  constexpr double kPerPx = 2;
  constexpr double kLimit = 4.7 * 1.4826;
  const double contrast = std::abs(model.levels.bright - model.levels.dark);
  const auto n_bins = static_cast<std::size_t>(2 * model.reach_px * kPerPx) + 2;
  struct Rest {
    double value;
    int x, y;
  };
  std::vector<std::vector<Rest>> bins(n_bins);
  std::vector<ProfilePoint> points;
  for_each_edge_pixel(samples, used, model, [&](std::span<const EdgePixel> row) {
    points.resize(row.size());
    profile(row, points);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const double at = (row[i].distance + model.reach_px) * kPerPx;
      bins[std::min(static_cast<std::size_t>(at), n_bins - 1)].push_back(
          {row[i].value - predicted(model, row[i], points[i].value), row[i].x, row[i].y});
    }
  });
  const int w = samples.width(), h = samples.height();
  std::vector<Rest> strays;
  std::vector<double> values;
  for (std::size_t b = 0; b < n_bins; ++b) {
    const std::vector<Rest>& bin = bins[b];
    if (bin.size() < 6) continue;
    const bool near = std::abs((double(b) + 0.5) / kPerPx - model.reach_px) < near_px;
    const double least = contrast * (near ? tolerance : std::max(2e-3, 0.1 * tolerance));
    values.clear();
    for (const Rest& r : bin) values.push_back(r.value);
    const double middle = median(values);
    for (double& v : values) v = std::abs(v - middle);
    // Few samples know their spread badly.
    const double few = 1 + 8 / double(bin.size());
    const double limit = std::max(kLimit * few * median(values), least);
    for (const Rest& r : bin) {
      if (std::abs(r.value - middle) > limit) strays.push_back(r);
    }
  }
  const auto index = [w](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
  };
  for (const Rest& r : strays) used[index(r.x, r.y)] = 0;
  // Around spots of several pixels, whose rims do not stand out.
  std::vector<std::size_t> rims;
  for (const Rest& r : strays) {
    int neighbours = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = r.x + dx, y = r.y + dy;
        if (x < 0 || y < 0 || x >= w || y >= h) continue;
        neighbours += used[index(x, y)] == 0 ? 1 : 0;
      }
    }
    if (neighbours < 3) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = r.x + dx, y = r.y + dy;
        if (x >= 0 && y >= 0 && x < w && y < h) rims.push_back(index(x, y));
      }
    }
  }
  for (const std::size_t i : rims) used[i] = 0;
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), 0));
}

ClipFinding find_clipping(Span2D<const float> samples, const PixelModel& model,
                          const EdgeOptions& options, double width_px, double noise) {
  // Both sides are looked at the same way, the dark one upside down.
  double lowest = 1e300, highest = -1e300, n = 0;
  for_each_edge_pixel(samples, {}, model, [&](std::span<const EdgePixel> row) {
    for (const EdgePixel& p : row) {
      lowest = std::min(lowest, p.value);
      highest = std::max(highest, p.value);
      n += 1;
    }
  });
  ClipFinding out;
  if (n == 0 || !(highest > lowest)) return out;
  const double contrast = highest - lowest;
  const double quantum = std::max(options.quantum, 2e-4 * contrast);
  struct Side {
    double at = 0, near = 0, plateau = 0, spread = 0;
  };
  Side sides[2];
  const double half = 0.5 * quantum;
  for_each_edge_pixel(samples, {}, model, [&](std::span<const EdgePixel> row) {
    for (const EdgePixel& p : row) {
      const bool bright = p.distance > 0;
      Side& s = sides[bright ? 1 : 0];
      const double below = bright ? highest - p.value : p.value - lowest;
      const bool exactly = below <= 1e-7 * contrast;
      if (exactly) s.at += 1;
      if (!exactly && below < 0.02 * contrast) s.near += 1;
      if (std::abs(p.distance) > 4 * width_px + 1) {
        s.plateau += 1;
        if (!exactly) s.spread += below > 2 * half ? 1 : 0;
      }
    }
  });
  const double length = 2 * model.line.half_length_px;
  const double usual = width_px * last_two_percent(quantum / contrast);
  for (int i = 0; i < 2; ++i) {
    const Side& s = sides[i];
    const double share = s.at / n;
    out.share = std::max(out.share, share);
    if (share < 0.0025 || s.at < 4) continue;
    const double end = i == 1 ? options.highest : options.lowest;
    const double value = i == 1 ? highest : lowest;
    const bool at_end = std::isfinite(end) && std::abs(value - end) <= half;
    // Noise whose one side is cut off: many at the very end, many well away from it.
    const bool noisy = noise > 1.2 * quantum;
    const bool one_sided =
        noisy && s.plateau > 0 && s.spread > 0.05 * s.plateau && s.at > 0.01 * s.plateau;
    // All of it beyond the end: one side without noise, though the other has some.
    const bool silent = noisy && s.plateau > 0 && s.at > 0.3 * s.plateau;
    // Without noise the approach to a plateau is gradual.
    const bool sudden =
        s.near / length < 0.5 * usual && (at_end || s.near < 0.5 * sides[1 - i].near);
    if (one_sided || silent || (noisy ? at_end : sudden)) out.clipped = true;
  }
  return out;
}

double uneven_share(Span2D<const float> samples, const PixelModel& model,
                    const ProfileFunction& profile, double tolerance, double noise) {
  const int longest = std::max(samples.width(), samples.height());
  const int size = std::max(4, (longest + 39) / 40);
  const auto across = static_cast<std::size_t>((samples.width() + size - 1) / size);
  const auto down = static_cast<std::size_t>((samples.height() + size - 1) / size);
  struct Cell {
    double n = 0, sum = 0;
  };
  std::vector<Cell> cells(across * down);
  std::vector<ProfilePoint> points;
  for_each_edge_pixel(samples, {}, model, [&](std::span<const EdgePixel> row) {
    points.resize(row.size());
    profile(row, points);
    for (std::size_t i = 0; i < row.size(); ++i) {
      Cell& cell = cells[static_cast<std::size_t>(row[i].y / size) * across +
                         static_cast<std::size_t>(row[i].x / size)];
      cell.n += 1;
      cell.sum += row[i].value - predicted(model, row[i], points[i].value);
    }
  });
  const double contrast = std::abs(model.levels.bright - model.levels.dark);
  double n = 0, off = 0;
  for (const Cell& cell : cells) {
    if (cell.n < 4) continue;
    n += cell.n;
    const double limit = tolerance * contrast + 5 * noise / std::sqrt(cell.n);
    if (std::abs(cell.sum / cell.n) > limit) off += cell.n;
  }
  return n > 0 ? off / n : 1;
}

double other_level_share(Span2D<const float> samples, const PixelModel& model, double near_px,
                         double noise) {
  constexpr double kOther = 0.4, kMostPixels = 2e4;
  const double contrast = std::abs(model.levels.bright - model.levels.dark);
  const double limit = std::max(kOther * contrast, 6 * noise);
  const LineFrame frame(model.line);
  const int w = samples.width(), h = samples.height();
  const int step = std::max(1, static_cast<int>(std::sqrt(double(w) * double(h) / kMostPixels)));
  double all = 0, other = 0;
  for (int y = 0; y < h; y += step) {
    for (int x = 0; x < w; x += step) {
      const double value = static_cast<double>(samples(x, y));
      if (!std::isfinite(value)) continue;
      all += 1;
      const double d = frame.at(x, y).distance;
      if (std::abs(d) < near_px) continue;
      if (std::abs(value - (d < 0 ? model.levels.dark : model.levels.bright)) > limit) other += 1;
    }
  }
  return all > 0 ? other / all : 0;
}

}  // namespace reseau
