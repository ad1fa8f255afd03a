// What is known of a réseau while its lines arrive. Include from .cpp files of this folder only.
#pragma once

#include <optional>

#include "core/reconstruct/reconstruct.h"
#include "core/screen/live_map.h"

namespace reseau {

// Locks as soon as it can and then hands out a snapshot after every kSnapshotLines lines.
// Thread-bound. Has no part in the final map.
class LiveRegistration {
 public:
  // Source and options must outlive it.
  LiveRegistration(const LineSource& source, const RegisterOptions& options)
      : source_(source), options_(options) {}

  // Lines [0, n_lines) are committed.
  void advance(int n_lines);

 private:
  // Looks for the réseau in the newest lines.
  void try_to_lock(int n_lines);
  void fill_cells(int n_lines);
  void publish();

  const LineSource& source_;
  const RegisterOptions& options_;
  std::optional<LatticeSeed> seed_;
  std::optional<LiveMap> live_;
  std::array<double, 3> weights_{};
  int n_seen_ = 0, n_searched_ = 0, n_filled_ = 0, n_published_ = 0;
};

}  // namespace reseau
