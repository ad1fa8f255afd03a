#include "drivers/sim/film/make_film.h"

#include <algorithm>

#include "drivers/sim/dufay_film.h"
#include "drivers/sim/film/screen_film.h"

namespace reseau::sim {
namespace {

// Nothing in the light path.
class NoFilm final : public Film {
 public:
  [[nodiscard]] Extent extent() const override {
    constexpr int kFar = 1 << 28;
    return {-kFar, kFar};
  }
  void cells(double /*y*/, int first_px, int n_px, int per_px, CellRow& out) const override {
    out.resize(first_px, n_px, per_px);
    for (int c = 0; c < kChannels; ++c) {
      for (int s = 0; s < per_px; ++s) std::fill_n(out.phase(c, s), n_px, 1.0F);
    }
  }
};

}  // namespace

std::unique_ptr<Film> make_film(const FilmSpec& spec) {
  if (spec.kind == FilmKind::kEmpty) return std::make_unique<NoFilm>();
  if (DufayFilm::can_render(spec)) return std::make_unique<DufayFilm>(spec);
  return std::make_unique<ScreenFilm>(spec);
}

}  // namespace reseau::sim
