// Dust, scratches, bubbles, stains and faded places.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/sim/film_spec.h"
#include "drivers/sim/spline_noise.h"

namespace reseau::sim {

// What lies on the film is drawn by lot over the whole strip, from the seed. Positions are film
// pixels. Immutable, thread-safe.
class Damage {
 public:
  explicit Damage(const FilmSpec& spec);

  // What harms a cell: neutral transmittance of dust, bubbles and base scratches (1 = none), and
  // the fraction of the cell whose silver a scratch has taken away (0 = none).
  struct Local {
    std::span<float> transmittance, bared;
  };
  [[nodiscard]] bool has_local() const { return !marks_.empty(); }
  // At film positions (x0 + i * step_px, y); step_px may be negative. False when the row is whole;
  // then nothing was written.
  [[nodiscard]] bool local(double y, double x0, double step_px, const Local& out) const;

  [[nodiscard]] bool has_faded() const { return spec_.faded_areas > 0; }
  [[nodiscard]] bool has_stains() const { return spec_.stains > 0; }
  // 0 … the spec's depth, smooth over hundreds of pixels.
  void faded(double y, double x0, std::span<float> out) const;  // at film x0 + i
  void stained(double y, double x0, std::span<float> out) const;

  // Share of a full stain that red, green, blue and infrared light lose.
  static constexpr std::array<float, 4> kStain{0.10F, 0.45F, 1.0F, 0.0F};
  // Fading of the dyes where `faded` is 1.
  static constexpr double kWorstFade = 0.9;

 private:
  enum class Kind { kDust, kHair, kBubble, kBaseScratch, kEmulsionScratch };
  struct Mark {
    Kind kind;
    double x, y;         // centre [px]
    double half_height;  // rows that it can touch: y ± half_height
    double a, b, angle;  // half axes; ring; width
    double strength;
  };
  void draw(const Mark& mark, double y, double x0, double step_px, const Local& out) const;
  void throw_lots(const FilmSpec& spec);

  DamageSpec spec_;
  std::vector<Mark> marks_;
  // Marks by bands of rows.
  double first_y_ = 0;
  std::vector<std::vector<std::uint32_t>> bands_;
  SplineNoise fade_map_, stain_map_, wander_;
};

}  // namespace reseau::sim
