#include "core/reconstruct/live_registration.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/base/parallel.h"
#include "core/reconstruct/registration_summary.h"
#include "core/screen/linear_rows.h"

namespace reseau {
namespace {

// Lines in which a réseau is looked for at first, and again where it was not found.
constexpr int kLockLines = 256;
constexpr int kBandLines = 32;  // read at once; whole cells
// A map that leaves more is not handed out [px].
constexpr double kMostResidualPx = 0.4;
constexpr int kFewestSamples = 12;

}  // namespace

void LiveRegistration::advance(int n_lines) {
  const int height = source_.format().n_lines;
  // Step by step, so that what a snapshot says does not depend on how lines arrive.
  while (n_seen_ < n_lines) {
    const int next = std::min(height, n_seen_ + kSnapshotLines);
    if (next > n_lines) return;
    n_seen_ = next;
    if (!live_) try_to_lock(n_seen_);
    if (!live_) continue;
    fill_cells(n_seen_);
    live_->advance(n_seen_);
    publish();
  }
}

void LiveRegistration::try_to_lock(int n_lines) {
  if (n_lines - n_searched_ < std::min(kLockLines, source_.format().n_lines)) return;
  LinearReader reader(source_, options_.tone);
  LinearRows rows;
  reader.read(n_searched_, n_lines - n_searched_, rows);
  n_searched_ = n_lines;
  const LatticeSearch found = find_lattice(rows, reader.has_infrared());
  if (!found.found || !silver_weights(found.seed.response, weights_)) return;
  seed_ = found.seed;
  live_.emplace(source_.format().width_px, source_.format().n_lines, found.seed);
}

void LiveRegistration::fill_cells(int n_lines) {
  const int first = n_filled_;
  // Whole cells only, but for the end of the frame.
  const int end = n_lines == source_.format().n_lines ? n_lines : n_lines / kBandLines * kBandLines;
  parallel_for((end - first + kBandLines - 1) / kBandLines, [&](int band) {
    LinearReader reader(source_, options_.tone);
    reader.set_silver_from_rgb(weights_);
    LinearRows rows;
    const int at = first + band * kBandLines;
    reader.read(at, std::min(kBandLines, end - at), rows);
    live_->cells().accumulate(rows);
  });
  n_filled_ = std::max(n_filled_, end);
}

void LiveRegistration::publish() {
  const bool holds = live_->n_samples() >= kFewestSamples && live_->residual_px() < kMostResidualPx;
  if (live_->n_lines() <= n_published_ || !holds) return;
  n_published_ = live_->n_lines();
  auto snapshot = std::make_shared<RegistrationSnapshot>();
  snapshot->n_lines = live_->n_lines();
  Registration& so_far = snapshot->registration;
  so_far.found = true;
  so_far.map = live_->map();
  so_far.lines_alone = seed_->layout == ScreenLayout::kLines;
  so_far.residual_px = live_->residual_px();
  so_far.n_windows = live_->n_samples();
  so_far.explained = seed_->explained;
  so_far.confidence = seed_->confidence;
  so_far.none_probability = 1 - std::min(seed_->confidence, 1 - 1e-6);
  so_far.response = seed_->response;
  so_far.silver_from_rgb = weights_;
  static_cast<void>(describe_lattice(so_far, source_.format(), snapshot->n_lines));
  describe_names(so_far, *seed_);
  options_.on_snapshot(std::move(snapshot));
}

}  // namespace reseau
