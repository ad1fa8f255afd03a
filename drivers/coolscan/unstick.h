// Getting a unit that no longer does what it is told back to work, gently first.
#pragma once

#include <functional>
#include <string>

#include "core/base/clock.h"
#include "drivers/scsi/scsi_device.h"

namespace reseau::coolscan {

enum class Unstuck { kWasFine, kMended, kNeedsPowerSwitch };

// What was tried and what came of it, as it happens.
using UnstickLog = std::function<void(const std::string& tried, const std::string& result)>;

// Waits for a motion that is under way, ends a scan that was left open, lets the stage return to
// its origin, starts the unit anew. Each rung only when the one before did not help. Never throws
// for what the unit does or fails to do. Source: recovery that users of LS-50, LS-5000 and LS-9000
// units report as working.
[[nodiscard]] Unstuck unstick(ScsiDevice& scsi, Clock& clock, const UnstickLog& log);

}  // namespace reseau::coolscan
