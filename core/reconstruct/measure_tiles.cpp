#include "core/reconstruct/measure_tiles.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/base/parallel.h"
#include "core/line/line_format.h"
#include "core/screen/linear_rows.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

constexpr int kTilesAcross = 14;

struct TilePlace {
  int x, y;
};

std::vector<TilePlace> tile_places(int width, int height, int size) {
  std::vector<TilePlace> places;
  const int nx = std::clamp(width / size, 1, kTilesAcross);
  const int ny = std::clamp(height / size, 1, kTilesAcross);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const long long x = nx > 1 ? static_cast<long long>(i) * (width - size) / (nx - 1) : 0;
      const long long y = ny > 1 ? static_cast<long long>(j) * (height - size) / (ny - 1) : 0;
      places.push_back({static_cast<int>(x), static_cast<int>(y)});
    }
  }
  return places;
}

}  // namespace

MeasuredTiles measure_tiles(const LineSource& source, const Registration& registration,
                            const ToneCurves& tone, const std::stop_token& stop) {
  const LineFormat& format = source.format();
  const double period = std::max(registration.period_px[0], registration.period_px[1]);
  const int size = std::min(
      {std::max(64, static_cast<int>(std::ceil(6 * period))), format.width_px, source.committed()});
  const std::vector<TilePlace> places = tile_places(format.width_px, source.committed(), size);
  std::vector<ScreenTile> tiles(places.size());
  std::vector<std::size_t> row_starts;  // tiles of one row share their lines
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i == 0 || places[i].y != places[i - 1].y) row_starts.push_back(i);
  }
  parallel_for(static_cast<int>(row_starts.size()), [&](int row) {
    const auto r = static_cast<std::size_t>(row);
    if (stop.stop_requested()) return;
    LinearReader reader(source, tone);
    LinearRows rows;
    const std::size_t end = r + 1 < row_starts.size() ? row_starts[r + 1] : places.size();
    reader.read(places[row_starts[r]].y, size, rows);
    for (std::size_t i = row_starts[r]; i < end; ++i) {
      tiles[i] = measure_screen_tile(rows, places[i].x, size, registration.map);
    }
  });
  std::vector<Vec2> middles;
  middles.reserve(places.size());
  for (const TilePlace& place : places)
    middles.push_back({place.x + 0.5 * (size - 1), place.y + 0.5 * (size - 1)});
  return {std::move(tiles), std::move(middles)};
}

}  // namespace reseau
