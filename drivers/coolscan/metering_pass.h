#pragma once

#include <optional>

#include "drivers/coolscan/pages.h"
#include "drivers/coolscan/scan_pass.h"
#include "drivers/scan_plan.h"

namespace reseau::coolscan {

// The pass that a plan asks for.
[[nodiscard]] PassSpec pass_of(const ScanPlan& plan, const AddressPage& addresses,
                               const Exposures& exposures);

// A quick pass over the inside of the same area, at the resolution that Nikon Scan meters with.
// Exposures are left at 0. Bare light at the edge of a picture would poison the metering.
[[nodiscard]] PassSpec coarse_pass_of(const ScanPlan& plan, const AddressPage& addresses);

// A few lines of the scan itself around a line of the coarse pass. A coarse pixel averages over the
// elements of a colour screen; a pixel of the scan may lie within one and be several times
// brighter. Absent when the coarse pass is as fine as the scan.
[[nodiscard]] std::optional<PassSpec> fine_pass_of(const ScanPlan& plan, const PassSpec& coarse,
                                                   int coarse_line);

}  // namespace reseau::coolscan
