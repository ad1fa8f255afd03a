#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "drivers/pieusb/plan.h"
#include "drivers/pieusb/scan_pass.h"

namespace reseau::pieusb {

// The pass that a plan asks for; exposures are left at 0.
[[nodiscard]] PassSpec pass_of(const ScanPlan& plan, const UnitDescription& unit);

// A quick pass over the inside of the same area with the same colours: bare light at the edge of a
// picture would poison the metering, and an infrared pass has other light than one without.
[[nodiscard]] PassSpec coarse_pass_of(const ScanPlan& plan, const UnitDescription& unit);

// A few rows of the scan itself around a row of the coarse pass: a coarse pixel averages over the
// elements of a colour screen. Absent when the coarse pass is as fine as the scan.
[[nodiscard]] std::optional<PassSpec> fine_pass_of(const ScanPlan& plan,
                                                   const UnitDescription& unit,
                                                   const PassSpec& coarse, int coarse_row);

// Finds the row where all colours come nearest to the brightest of the pass, each for itself.
class RowTops {
 public:
  explicit RowTops(int n_channels) : n_channels_(static_cast<std::size_t>(n_channels)) {}
  // [channel][pixel]
  void add_row(std::span<const std::uint16_t> row);
  // 0 before any row.
  [[nodiscard]] int brightest_row() const;

 private:
  std::size_t n_channels_;
  std::vector<std::uint16_t> tops_;  // [row][channel]: what one sample in twenty reaches
  std::vector<std::uint16_t> sorted_;
};

}  // namespace reseau::pieusb
