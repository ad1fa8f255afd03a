#include "drivers/settling.h"

#include <string>

#include "drivers/utc_time.h"

namespace reseau {

std::optional<Measurement> settle_metering(
    Metering& metering, ScanObserver& observer,
    const std::function<std::optional<Measurement>(const Exposures&, int)>& measure) {
  constexpr int kMostPasses = 6;
  std::optional<Measurement> measurement;
  for (int pass = 1; pass <= kMostPasses; ++pass) {
    measurement = measure(metering.exposures(), pass);
    if (!measurement || metering.improve(measurement->levels)) return measurement;
  }
  observer.note("The exposure did not settle after " + std::to_string(kMostPasses) +
                " passes; bright parts may be cut off. Give the exposures as numbers.");
  return measurement;
}

CaptureContext begin_context(const Capabilities& capabilities, const OpenAs& open_as) {
  CaptureContext context;
  context.device_name = open_as.device_name;
  context.make = capabilities.make;
  context.model = capabilities.model;
  context.firmware = capabilities.firmware;
  context.serial = capabilities.serial;
  context.holder = capabilities.adapter;
  context.started_at_utc = open_as.started_at_utc.empty() ? utc_now() : open_as.started_at_utc;
  return context;
}

}  // namespace reseau
