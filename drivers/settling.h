// What the drivers of the families do alike while a scan begins.
#pragma once

#include <functional>
#include <optional>

#include "core/line/capture_context.h"
#include "drivers/metering.h"
#include "drivers/open_as.h"
#include "drivers/scanner.h"

namespace reseau {

// What one metering pass found.
struct Measurement {
  Levels levels;
  int brightest_row = 0;  // where a finer pass finds the most light
};

// Measures again with better exposures until they settle, six times at most; then a note says so.
// `measure` takes a pass, from 1; absent when it was stopped, and so is the result.
[[nodiscard]] std::optional<Measurement> settle_metering(
    Metering& metering, ScanObserver& observer,
    const std::function<std::optional<Measurement>(const Exposures& exposures, int pass)>& measure);

// Of a scan that begins now, without exposures and focus.
[[nodiscard]] CaptureContext begin_context(const Capabilities& capabilities, const OpenAs& open_as);

}  // namespace reseau
