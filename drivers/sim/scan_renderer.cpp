#include "drivers/sim/scan_renderer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "drivers/sim/optical_renderer.h"
#include "drivers/sim/optical_transfer.h"
#include "drivers/sim/plain_renderer.h"

namespace reseau::sim {

ScanRenderer::ScanRenderer(std::shared_ptr<const Film> film, const OpticsSpec& optics,
                           const ScanWindow& window, const ScanGeometry& geometry)
    : window_(window) {
  CHECK(film != nullptr && window.width_px > 0 && window.n_lines >= 0 && window.pitch >= 1);
  if (is_plain(optics) && geometry.is_perfect()) {
    renderer_ = std::make_unique<PlainRenderer>(std::move(film), optics, window);
  } else {
    renderer_ = std::make_unique<OpticalRenderer>(std::move(film), optics, window, geometry);
  }
}

void ScanRenderer::transmittance(int first_line, int n_lines, std::span<float> out) const {
  CHECK(first_line >= 0 && n_lines >= 0 && first_line + n_lines <= window_.n_lines);
  CHECK(out.size() == static_cast<std::size_t>(kChannels) *
                          static_cast<std::size_t>(window_.width_px) *
                          static_cast<std::size_t>(n_lines));
  renderer_->transmittance(first_line, n_lines, out);
}

namespace {

// Largest error of a sample by cells of 1 / n px on an edge between 0 and 1 that runs at this angle
// to the grid: the second-order term of a step along the borders of cells, 0.242 / (12 s^2 n^2) for
// a Gaussian of s px, is averaged over the phases that the edge passes through within the spread
// function. A round edge passes through phases as the square of the way.
double edge_error(double spread_px2, int n, const Film::Edges& edges, bool tents) {
  constexpr double kPi = std::numbers::pi;
  if (edges.scene_contrast > 0) {
    Film::Edges scene, film = edges;
    scene.off_axes_deg = edges.scene_off_axes_deg;
    scene.contrast = edges.scene_contrast;
    film.scene_contrast = 0;
    return std::max(edge_error(spread_px2, n, scene, tents),
                    edge_error(spread_px2, n, film, tents));
  }
  // Tents leave the third-order term alone.
  if (tents) return edges.contrast * 0.399 * 0.00802 / std::pow(spread_px2 * n * n, 1.5);
  const double phases = n * std::tan(edges.off_axes_deg * kPi / 180);  // cycles per px along it
  double share = std::exp(-2 * kPi * kPi * spread_px2 * phases * phases);
  if (edges.radius_px > 0) {
    const double turns = 2 * kPi * n * spread_px2 / edges.radius_px;
    share = std::max(share, std::pow(1 + turns * turns, -0.25));
  }
  return edges.contrast * 0.242 / (12 * spread_px2 * n * n) * share;
}

// Variance of the Gaussian that transfers as much where edges and cells meet as the sharpest
// channel does along its sharper axis.
double transferred_spread_px2(const std::vector<OpticalTransfer>& transfers) {
  constexpr double kPi = std::numbers::pi, kAt = 0.35;  // c/px
  double most = 0;
  for (const OpticalTransfer& t : transfers) {
    most = std::max({most, std::abs(t(kAt, 0, 0)), std::abs(t(0, kAt, 0))});
  }
  return -std::log(std::clamp(most, 1e-6, 0.99)) / (2 * kPi * kPi * kAt * kAt);
}

}  // namespace

// What a rendering may err by, as far as it can be said beforehand.
constexpr double kFullError = 1e-4;

bool takes_tents(const Film& film, int pitch) {
  const Film::Edges edges = film.edges();
  return pitch < 4 && edges.tents && edges.off_axes_deg < Film::Edges::kNearAxesDeg;
}

int cells_used(const Film& film, const OpticsSpec& optics, int pitch, bool full) {
  if (pitch >= 4) return 1;
  if (optics.cells_per_px > 0) {
    return full || pitch == 1 ? optics.cells_per_px : std::min(optics.cells_per_px, 2);
  }
  Film::Edges edges = film.edges();
  const bool tents = takes_tents(film, pitch);
  const bool fine = edges.contrast > 0.5 || edges.scene_contrast > 0 || edges.grainy;
  const bool hard = edges.spreads || (tents && fine);
  const int fewest = std::max(edges.fewest_cells, tents ? edges.fewest_tents : 0);
  if (!full) {
    if (pitch > 1) return 2;
    constexpr int kMostPlain = 8;
    // The sharpest channel decides: its Gaussian and its apertures.
    const double aperture_y = optics.aperture_y_px > 0 ? optics.aperture_y_px : optics.aperture_px;
    const double sharpest = *std::ranges::min_element(optics.blur_px);
    const double aperture = std::min(optics.aperture_px, aperture_y);
    const double spread_px2 = sharpest * sharpest + aperture * aperture / 12;
    int cells = hard || fine || fewest > 6 ? kMostPlain : 6;
    while (cells < kMostPlain && edge_error(spread_px2, cells, edges, tents) > kFullError)
      cells += 2;
    return std::max(cells, edges.fewest_plain);
  }
  std::vector<OpticalTransfer> transfers;
  transfers.reserve(kChannels);
  for (int c = 0; c < kChannels; ++c) transfers.emplace_back(optics, c);
  // As few as keep the error below half of 1e-4 of a sample, and let pairs be joined.
  constexpr int kFewest = 6, kFewestForSteps = 8, kMost = 12, kAligned = 16, kMostAligned = 24;
  const double spread_px2 = transferred_spread_px2(transfers);
  int cells = std::max(hard ? kFewestForSteps : kFewest, fewest);
  while (cells < kMost && choose_grid(cells, transfers).per_px == cells) cells += 2;
  if (cells == kFewest && edge_error(spread_px2, cells, edges, tents) > kFullError / 2) cells = 8;
  while (cells < kAligned && edge_error(spread_px2, cells, edges, tents) > kFullError) cells *= 2;
  if (cells < kMostAligned && edge_error(spread_px2, cells, edges, tents) > kFullError) {
    cells = kMostAligned;
  }
  return cells;
}

namespace {

struct Piece {
  int x = 0, y = 0;  // its first pixel and line
};
constexpr int kPieceWidth = 16, kPieceLines = 4;

// Spread evenly over a window, never in step with a lattice: multiples of the golden ratio along x.
std::vector<Piece> even_pieces(int n, int room_px, int room_lines) {
  std::vector<Piece> pieces;
  for (int k = 0; k < n; ++k) {
    const double across = std::fmod(0.5 + k * 0.6180339887498949, 1.0);
    pieces.push_back(
        {static_cast<int>(across * room_px), static_cast<int>((k + 0.5) / n * room_lines)});
  }
  return pieces;
}

// Where the film changes most from pixel to pixel in a few rows of the window, of the rows the
// steepest.
std::vector<Piece> steep_pieces(const Film& film, const ScanWindow& window, int n, int room_px,
                                int room_lines) {
  struct Steep {
    float slope = 0;
    Piece piece;
  };
  const int n_rows = 8 * n;
  const int first = floor_to_block(window.x_px);
  const int n_px = floor_to_block(window.x_px + window.width_px + kBlockPx - 1) - first;
  std::vector<Steep> rows;
  rows.reserve(static_cast<std::size_t>(n_rows));
  CellRow cells;
  for (int k = 0; k < n_rows; ++k) {
    const int line = static_cast<int>((k + 0.5) / n_rows * (window.n_lines - 1));
    film.cells(window.optical_y(line), first, n_px, 2, cells);
    Steep most;
    for (int c = 0; c < kChannels; ++c) {
      const float *const left = cells.phase(c, 0), *const right = cells.phase(c, 1);
      for (int i = std::max(1, window.x_px - first); i < window.x_px - first + window.width_px;
           ++i) {
        const float slope = std::abs(right[i] - left[i - 1]);
        if (slope <= most.slope) continue;
        most = {slope,
                {std::clamp(i - (window.x_px - first) - kPieceWidth / 2, 0, room_px),
                 std::clamp(line - kPieceLines / 2, 0, room_lines)}};
      }
    }
    rows.push_back(most);
  }
  std::ranges::stable_sort(rows, std::ranges::greater(), &Steep::slope);
  std::vector<Piece> pieces;
  pieces.reserve(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) pieces.push_back(rows[static_cast<std::size_t>(k)].piece);
  return pieces;
}

}  // namespace

RenderError estimate_error(const std::shared_ptr<const Film>& film, const OpticsSpec& optics,
                           const ScanWindow& window, const ScanGeometry& geometry, int n_pieces) {
  CHECK(n_pieces >= 1 && window.width_px >= 1 && window.n_lines >= 1);
  OpticsSpec finer = optics;
  RenderError error;
  error.cells_per_px =
      cells_used(*film, optics, window.pitch, !is_plain(optics) || !geometry.is_perfect());
  finer.cells_per_px = 2 * error.cells_per_px;
  // What joining costs is part of the error: the finer rendering joins one time less.
  finer.fewest_cells_per_px = 6;
  const int width_px = std::min(kPieceWidth, window.width_px);
  const int n_lines = std::min(kPieceLines, window.n_lines);
  const int room_px = window.width_px - width_px, room_lines = window.n_lines - n_lines;
  std::vector<Piece> pieces = even_pieces(n_pieces, room_px, room_lines);
  if (window.pitch == 1 && n_pieces > 1) {
    const std::vector<Piece> steep =
        steep_pieces(*film, window, (n_pieces + 1) / 3, room_px, room_lines);
    pieces.insert(pieces.end(), steep.begin(), steep.end());
  }
  double squares = 0;
  std::vector<float> a, b;
  for (const Piece& at : pieces) {
    ScanWindow piece = window;
    piece.width_px = width_px;
    piece.n_lines = n_lines;
    piece.x_px += window.pitch * at.x;
    piece.y_px += window.step() * at.y;
    a.resize(static_cast<std::size_t>(piece.width_px) * static_cast<std::size_t>(piece.n_lines) *
             kChannels);
    b.resize(a.size());
    ScanRenderer(film, optics, piece, geometry).transmittance(0, piece.n_lines, a);
    ScanRenderer(film, finer, piece, geometry).transmittance(0, piece.n_lines, b);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double difference = 4.0 / 3.0 * (static_cast<double>(a[i]) - b[i]);
      squares += difference * difference;
      error.largest = std::max(error.largest, std::abs(difference));
    }
    error.n_samples += static_cast<int>(a.size());
  }
  error.rms = std::sqrt(squares / error.n_samples);
  // Few samples seldom hold the worst.
  constexpr double kLargestOverRms = 8;
  constexpr double kTables = 1e-5;  // of spread functions, which finer cells do not show
  error.largest = std::max(error.largest, kLargestOverRms * error.rms) + kTables;
  return error;
}

}  // namespace reseau::sim
