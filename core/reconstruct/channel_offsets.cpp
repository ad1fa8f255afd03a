#include "core/reconstruct/channel_offsets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/line/line_format.h"
#include "core/reconstruct/channel_registration.h"
#include "core/reconstruct/measure_tiles.h"
#include "core/screen/screen_tile.h"

namespace reseau {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kRounds = 6;
constexpr std::size_t kFewestTiles = 8, kTilesOfGrowth = 24;
// Deviation [px] from which a channel is not called told.
constexpr double kNotTold_px = 0.1;
// Of any shift, before the picture is seen: no more than a weak one.
constexpr double kBelieved_px = 3;
constexpr double kMapErrs_px = 0.2;  // from place to place, at most some
constexpr double kCalm = 0.3;        // of the middling tile's unexplained rest
constexpr double kEven = 1e-6;
constexpr const char* kNoInfrared = "The scan has no infrared.";
// Error of a harmonic, of the light, that all tiles share: what pictures of simulated films leave.
constexpr double kModelShare = 1e-4;

// How the phase [rad] of each harmonic in a tile depends on the shift in the middle of the frame
// and its growth along x and along y, of x and of y each.
using Rows = Eigen::Matrix<double, kTileAmplitudes - 1, 6>;

Rows rows_of(const Registration& registration, Vec2 at, Vec2 frame_px) {
  const double x = 2 * at.x / frame_px.x - 1, y = 2 * at.y / frame_px.y - 1;
  const std::array<double, 3> basis{1, x, y};
  Rows out;
  for (Eigen::Index h = 0; h < out.rows(); ++h) {
    const HarmonicIndex i = kTileHarmonics[static_cast<std::size_t>(h)];
    const Vec2 f = static_cast<double>(i.u) * registration.lattice_cy_per_px[0] +
                   static_cast<double>(i.v) * registration.lattice_cy_per_px[1];
    for (Eigen::Index b = 0; b < 3; ++b) {
      out(h, 2 * b) = kTurn * f.x * basis[static_cast<std::size_t>(b)];
      out(h, 2 * b + 1) = kTurn * f.y * basis[static_cast<std::size_t>(b)];
    }
  }
  return out;
}

// Green's own shift from the map, then of the others from green, six each.
struct FoundShifts {
  Eigen::VectorXd p;
  Eigen::VectorXd variance;  // by how the tiles scatter
  Eigen::VectorXd least;     // by their noise alone: infinite where nothing is told
};

// Of one tile: what every harmonic of every channel says. The odd part of a harmonic is its even
// part times the phase, and what the picture's silver holds at that frequency, which is the same in
// all channels but for their light, and goes out.
struct TileSums {
  Eigen::MatrixXd a;
  Eigen::VectorXd g;
  // Column (harmonic, channel): g if the odd part there were larger by the channel's light.
  Eigen::MatrixXd by_light;
  double left = 0;  // what remains unexplained, over its expectation by the noise of pixels
};

TileSums sums_of(const ScreenTile& tile, const Rows& rows, std::span<const std::size_t> channels,
                 Eigen::Index n, const Eigen::VectorXd& p) {
  const auto n_channels = static_cast<Eigen::Index>(channels.size());
  // Last, where the map errs in this tile, which all channels share.
  const Eigen::Index size = n * n_channels;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(size + 2, size + 2);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size + 2);
  Eigen::MatrixXd by_light = Eigen::MatrixXd::Zero(size + 2, n_channels * rows.rows());
  double squares = 0;
  a.bottomRightCorner<2, 2>().diagonal().setConstant(1 / (kMapErrs_px * kMapErrs_px));
  for (Eigen::Index h = 0; h < rows.rows(); ++h) {
    const Eigen::RowVectorXd row = rows.row(h).head(n);
    const auto i = static_cast<std::size_t>(h + 1);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n_channels, size + 2);
    Eigen::VectorXd odd(n_channels), light(n_channels);
    for (Eigen::Index k = 0; k < n_channels; ++k) {
      const std::size_t c = channels[static_cast<std::size_t>(k)];
      double phase = row.dot(p.head(n));
      if (k > 0) phase += row.dot(p.segment(k * n, n));
      const double mean = tile.amplitude[c][0];
      const double weight = 1 / std::sqrt(tile.variance[c] / tile.n_effective +
                                          kModelShare * kModelShare * mean * mean + 1e-14);
      const std::complex<double> z = weight *
                                     std::complex<double>(tile.amplitude[c][i], tile.odd[c][i]) *
                                     std::polar(1.0, -phase);
      jacobian.row(k).head(n) = z.real() * row;
      if (k > 0) jacobian.row(k).segment(k * n, n) = z.real() * row;
      jacobian.row(k).tail<2>() = z.real() * row.head<2>();
      odd[k] = z.imag();
      light[k] = weight * mean;
    }
    const Eigen::VectorXd own_light = light;
    light.normalize();
    jacobian -= light * (light.transpose() * jacobian);
    odd -= light * light.dot(odd);
    a += jacobian.transpose() * jacobian;
    g += jacobian.transpose() * odd;
    squares += odd.squaredNorm();
    by_light.middleCols(h * n_channels, n_channels) = jacobian.transpose() * own_light.asDiagonal();
  }
  const Eigen::Matrix2d own = a.bottomRightCorner<2, 2>().inverse();
  const Eigen::MatrixXd across = a.topRightCorner(size, 2) * own;
  return {a.topLeftCorner(size, size) - across * a.bottomLeftCorner(2, size),
          g.head(size) - across * g.tail<2>(),
          by_light.topRows(size) - across * by_light.bottomRows(2),
          (squares - g.tail<2>().dot(own * g.tail<2>())) /
              static_cast<double>(rows.rows() * (n_channels - 1) - 2)};
}

FoundShifts find_shifts(const std::vector<const ScreenTile*>& tiles, const std::vector<Rows>& rows,
                        std::span<const std::size_t> channels, Eigen::Index n) {
  const auto size = n * static_cast<Eigen::Index>(channels.size());
  FoundShifts out;
  out.p = Eigen::VectorXd::Zero(size);
  const Eigen::MatrixXd believed =
      Eigen::MatrixXd::Identity(size, size) / (kBelieved_px * kBelieved_px);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<TileSums> sums;
    std::vector<double> left;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      sums.push_back(sums_of(*tiles[t], rows[t], channels, n, out.p));
      left.push_back(sums.back().left);
    }
    // Busy tiles count less, calm ones up to a limit more.
    const auto middle = left.begin() + static_cast<std::ptrdiff_t>(left.size() / 2);
    std::nth_element(left.begin(), middle, left.end());
    const double least = std::max(kCalm * *middle, 1e-12);
    Eigen::MatrixXd a = believed;
    Eigen::VectorXd g = -believed * out.p;
    for (TileSums& one : sums) {
      const double weight = 1 / std::max(one.left, least);
      one.a *= weight;
      one.g *= weight;
      a += one.a;
      g += one.g;
    }
    const Eigen::LDLT<Eigen::MatrixXd> solver(a);
    out.p += solver.solve(g);
    if (round + 1 < kRounds) continue;
    out.least = solver.solve(Eigen::MatrixXd::Identity(size, size)).diagonal();
    // Jackknife: what comes out without each tile.
    out.variance = Eigen::VectorXd::Zero(size);
    Eigen::MatrixXd by_light = Eigen::MatrixXd::Zero(size, sums.front().by_light.cols());
    for (const TileSums& one : sums) {
      by_light += one.by_light / std::max(one.left, least);
      out.variance += Eigen::LDLT<Eigen::MatrixXd>(a - one.a).solve(one.g).cwiseAbs2();
    }
    // And what all of them share.
    out.variance += kModelShare * kModelShare * solver.solve(by_light).rowwise().squaredNorm();
  }
  return out;
}

bool lies_evenly(const ScreenPattern& pattern) {
  for (int color = 0; color < 3; ++color) {
    for (const HarmonicIndex h : kTileHarmonics) {
      if (std::abs(pattern.fourier(color, h.u, h.v).imag()) > kEven) return false;
    }
  }
  return true;
}

ChannelOffset offset_of(const Eigen::VectorXd& p, const Eigen::VectorXd& variance) {
  const Eigen::VectorXd sd = variance.cwiseSqrt();
  ChannelOffset out{{p[0], p[1]}, {sd[0], sd[1]}, {}};
  if (p.size() == 6) {
    out.growth = ChannelOffset::Growth{{p[2], p[3]}, {sd[2], sd[3]}, {p[4], p[5]}, {sd[4], sd[5]}};
  }
  return out;
}

ChannelOffsets told_nothing(const char* why, bool infrared) {
  ChannelOffsets out;
  for (const std::size_t c : {0U, 2U, 3U}) out.reason[c] = why;
  if (!infrared) out.reason[3] = kNoInfrared;
  return out;
}

// A sentence where shares and shift cannot be told apart; none where they can. pattern: once it is
// known.
const char* why_not(const Registration& registration, const ScreenPattern* pattern) {
  if (registration.lines_alone) {
    return "Lines alone do not repeat along themselves, and across them the share of each line in "
           "a channel looks like a shift.";
  }
  if (registration.identity == "unknown") return "The scan shows no colours.";
  if (pattern != nullptr && !lies_evenly(*pattern)) {
    return "The elements of this screen do not lie evenly about one point: their shares in a "
           "channel look like a shift.";
  }
  return nullptr;
}

}  // namespace

ChannelOffsets channel_offsets(const MeasuredTiles& measured, const Registration& registration,
                               const ScreenPattern& pattern, bool infrared, Vec2 frame_px) {
  ChannelOffsets out;
  if (const char* why = why_not(registration, &pattern)) return told_nothing(why, infrared);
  std::vector<const ScreenTile*> tiles;
  std::vector<Rows> rows;
  for (std::size_t t = 0; t < measured.tiles.size(); ++t) {
    if (!measured.tiles[t].used) continue;
    tiles.push_back(&measured.tiles[t]);
    rows.push_back(rows_of(registration, measured.middles[t], frame_px));
  }
  out.tiles = static_cast<int>(tiles.size());
  if (tiles.size() < kFewestTiles) {
    ChannelOffsets few = told_nothing(
        "Too little of the frame shows the réseau: fewer than eight tiles of it.", infrared);
    few.tiles = out.tiles;
    return few;
  }
  const Eigen::Index n = tiles.size() < kTilesOfGrowth ? 2 : 6;
  std::vector<std::size_t> channels{1, 0, 2};
  if (infrared) channels.push_back(3);
  const FoundShifts found = find_shifts(tiles, rows, channels, n);
  for (std::size_t k = 1; k < channels.size(); ++k) {
    const std::size_t c = channels[k];
    const auto first = static_cast<Eigen::Index>(k) * n;
    const ChannelOffset offset =
        offset_of(found.p.segment(first, n), found.variance.segment(first, n));
    const double least = std::sqrt(found.least.segment(first, 2).maxCoeff());
    if (std::max({offset.sd_px.x, offset.sd_px.y, least}) < kNotTold_px &&
        norm(offset.at_px) < kBelieved_px) {
      out.from_green[c] = offset;
    } else {
      out.reason[c] = "This channel shows too little of the réseau in this picture.";
    }
  }
  if (!infrared) out.reason[3] = kNoInfrared;
  return out;
}

ChannelOffsets measure_channel_offsets(const LineSource& source, const Registration& registration,
                                       const ToneCurves& tone, const std::stop_token& stop) {
  const bool infrared = source.format().plane_of(Channel::kInfrared) >= 0;
  if (const char* why = why_not(registration, nullptr)) return told_nothing(why, infrared);
  const MeasuredTiles measured = measure_tiles(source, registration, tone, stop);
  const PrintedScreen printed = printed_screen(registration.screen);
  return channel_offsets(
      measured, registration, printed.pattern(printed.usual), infrared,
      {static_cast<double>(source.format().width_px), static_cast<double>(source.committed())});
}

}  // namespace reseau
