#include "core/screen/hypothesis_tiles.h"

#include <algorithm>

namespace reseau {
namespace {

TileView view_of(const ScreenTile& tile) {
  TileView view;
  for (std::size_t c = 0; c < 4; ++c) {
    view.mean[c] = tile.amplitude[c][0];
    view.total[c] = tile.variance[c];
    for (std::size_t h = 0; h + 1 < kTileAmplitudes; ++h) {
      // a cos + b sin = Re((a - i b) e^(i t)); the coefficient of e^(i t) is half of that.
      view.harmonic[c][h] = {tile.amplitude[c][h + 1], -tile.odd[c][h + 1]};
      view.total[c] += 2 * std::norm(view.harmonic[c][h]);
    }
  }
  return view;
}

}  // namespace

std::vector<TileEntry> measure_entries(const LinearRows& rows,
                                       const std::vector<TileCorner>& corners,
                                       const std::vector<Carriers>& tile_carriers, int tile_size) {
  std::vector<TileEntry> entries;
  for (std::size_t t = 0; t < corners.size(); ++t) {
    // A tile is a small frame of its own; phases refer to its corner.
    LinearRows cut;
    cut.first = 0;
    cut.n = tile_size;
    cut.width_px = tile_size;
    cut.grey = rows.grey;
    for (std::size_t c = 0; c < 4; ++c) {
      cut.plane[c].resize(static_cast<std::size_t>(tile_size) *
                          static_cast<std::size_t>(tile_size));
      for (int y = 0; y < tile_size; ++y) {
        std::copy_n(rows.row(static_cast<int>(c), corners[t].y + y) + corners[t].x, tile_size,
                    cut.plane[c].begin() + static_cast<std::ptrdiff_t>(y) * tile_size);
      }
    }
    const Carriers& f = tile_carriers[t];
    const ScreenTile tile =
        measure_screen_tile(cut, 0, tile_size, ScreenMap({f.u.x, f.u.y, f.v.x, f.v.y}, {}));
    if (tile.used) entries.push_back({view_of(tile), t});
  }
  return entries;
}

Eigen::Vector3d element_response(const std::vector<Eigen::Vector4d>& lights, bool infrared) {
  if (infrared) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double norm = 0;
    for (const Eigen::Vector4d& x : lights) {
      sum += x(3) * x.head<3>();
      norm += x(3) * x(3);
    }
    return sum / std::max(norm, 1e-30);
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double brightest = 0;
  for (const Eigen::Vector4d& x : lights) {
    scatter += x.head<3>() * x.head<3>().transpose();
    brightest = std::max(brightest, x.head<3>().norm());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  const Eigen::Vector3d direction = eigen.eigenvectors().col(2);
  return (direction.sum() < 0 ? -brightest : brightest) * direction;
}

Eigen::Vector3d mean_light(const std::vector<Eigen::Vector4d>& lights) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector4d& x : lights) sum += x.head<3>();
  return sum / std::max(sum(1), 1e-30);
}

Cast cast_of(const std::vector<TileEntry>& entries) {
  Cast cast{Eigen::Vector3d::Zero()};
  for (const TileEntry& entry : entries) {
    for (int c = 0; c < 3; ++c)
      cast.inverse_mean(c) += entry.view.mean[static_cast<std::size_t>(c)];
  }
  cast.inverse_mean = cast.inverse_mean.cwiseMax(1e-9).cwiseInverse();
  return cast;
}

}  // namespace reseau
