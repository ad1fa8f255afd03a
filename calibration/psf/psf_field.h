// The optics of a unit over its frame: every parameter of fit_psf as a surface, from edges all over
// the frame. Pure, reentrant, the same result for the same input and any number of threads.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "calibration/edge/optics.h"
#include "calibration/profile/records.h"
#include "calibration/psf/psf_fit.h"
#include "core/geometry/vec2.h"

namespace reseau {

// `places`: of each edge, -1 to 1 over the frame. `shared`: fit_psf of some of them, ok; the
// surfaces start there. Where focus settings are known, best focus of every channel is a quadratic
// surface (a plane with fewer than eight edges of a channel, a constant with fewer than five); else
// the Gaussian variance is, or the defocus where it explains the edges better. Other parameters
// bend where the edges ask for it (BIC). Deviations grow where edges lie off the surfaces by more
// than they claim. Nothing when the edges have no profile, or when it was stopped.
[[nodiscard]] std::optional<PsfFieldRecord> fit_psf_field(std::span<const PsfEdge> edges,
                                                          std::span<const Vec2> places,
                                                          const PsfFit& shared,
                                                          const std::function<bool()>& stop = {});

// Optics of a channel (0 to 3) at a place, at record.focus where it has one.
[[nodiscard]] EdgeOptics field_optics(const PsfFieldRecord& record, int channel, double x,
                                      double y);
// Where the transfer there falls to one half along a normal, with the deviation that the surfaces
// give. Nothing where it does not, or where the record has no such channel.
[[nodiscard]] std::optional<Measured> field_mtf50(const PsfFieldRecord& record, int channel,
                                                  const NormalCosines& normal, double x, double y);

}  // namespace reseau
