#include "drivers/sim/scan_renderer.h"

#include <algorithm>
#include <cmath>
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
  constexpr double kNearAxes = 12;
  const Film::Edges edges = film.edges();
  return pitch < 4 && edges.tents && edges.off_axes_deg < kNearAxes;
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
  if (edge_error(spread_px2, cells, edges, tents) > kFullError) cells = kMostAligned;
  return cells;
}

RenderError estimate_error(const std::shared_ptr<const Film>& film, const OpticsSpec& optics,
                           const ScanWindow& window, const ScanGeometry& geometry, int n_pieces) {
  CHECK(n_pieces >= 1 && window.width_px >= 1 && window.n_lines >= 1);
  constexpr int kWidth = 16, kLines = 4;
  OpticsSpec finer = optics;
  RenderError error;
  error.cells_per_px =
      cells_used(*film, optics, window.pitch, !is_plain(optics) || !geometry.is_perfect());
  finer.cells_per_px = 2 * error.cells_per_px;
  // What joining costs is part of the error: the finer rendering joins one time less.
  finer.fewest_cells_per_px = 6;
  double squares = 0;
  std::vector<float> a, b;
  for (int k = 0; k < n_pieces; ++k) {
    // Spread evenly, never in step with a lattice: multiples of the golden ratio along x.
    const double across = std::fmod(0.5 + k * 0.6180339887498949, 1.0);
    ScanWindow piece = window;
    piece.width_px = std::min(kWidth, window.width_px);
    piece.n_lines = std::min(kLines, window.n_lines);
    piece.x_px += window.pitch * static_cast<int>(across * (window.width_px - piece.width_px));
    piece.y_px +=
        window.step() * static_cast<int>((k + 0.5) / n_pieces * (window.n_lines - piece.n_lines));
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
