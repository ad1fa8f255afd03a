// What the parts of mtf_bench share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/edge/measure_edge.h"
#include "tests/support/edge_renderer.h"

namespace reseau::bench {

// Which bars, and whether on as many pictures as they ask for or on few.
struct Bars {
  int first = 1, last = 14;
  bool full = false;
  [[nodiscard]] bool holds(int bar) const { return first <= bar && bar <= last; }
};

// One row of the table.
void tell(int bar, const std::string& what, const std::string& wanted, const std::string& measured,
          bool kept);

[[nodiscard]] test::EdgePicture usual(double angle, double length = 100, double noise = 0,
                                      std::uint32_t seed = 1);
[[nodiscard]] EdgeMeasurement measure(const test::EdgePicture& p, const test::Transfer2D& t,
                                      bool clips = false);
// Of MTF50, in per cent; not finite where there is none.
[[nodiscard]] double error_percent(const EdgeMeasurement& m, const test::EdgePicture& p,
                                   const test::Transfer2D& t);

// Of many pictures.
struct Errors {
  double sum = 0, squares = 0, most = 0, of_curve = 0;
  int n = 0, refused = 0;
  void add(double e);
  void add(const test::EdgePicture& p, const test::Transfer2D& t);
  [[nodiscard]] double mean() const;
  [[nodiscard]] double rms() const;
  [[nodiscard]] double sd() const;
};

// Bars 1 and 2; 3 to 6; 7, 8 and 10; 9; 11; 12; 14.
void noise_free(const Bars& bars);
void noisy(const Bars& bars);
void hard(const Bars& bars);
void refusals(const Bars& bars);
void real_scans();
void times();
void odd_input();

}  // namespace reseau::bench
