// How a Coolscan's exposures are found.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "drivers/coolscan/coolscan.h"
#include "drivers/coolscan/metering_pass.h"
#include "drivers/coolscan/window.h"

namespace reseau::coolscan {

Exposures Coolscan::white_balance() {
  Exposures exposures{};
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    constexpr std::size_t kReplyBytes = kDataHeadBytes + 4;
    const std::optional<Bytes> data = unit_.read_data(DataType::kWhiteBalanceExposure, kColours[i]);
    if (data && data->size() >= kReplyBytes) {
      exposures[i] = static_cast<std::uint32_t>(load_be(*data, kDataHeadBytes, 4));
    } else if (const std::optional<Window> window = unit_.get_window(kColours[i])) {
      exposures[i] = window->exposure_10ns;
    }
  }
  return exposures;
}

std::optional<Exposures> Coolscan::settle_exposures(const ScanPlan& plan, ScanObserver& observer,
                                                    const std::stop_token& stop) {
  const WindowPage& windows = description_.windows;
  // What GET WINDOW returns is the last scan's: repeated metering would multiply.
  Exposures exposures = white_balance();
  if (plan.exposure.mode == ExposureRequest::Mode::kMeter) {
    Metering metering(exposures, {windows.exposure_min_10ns, windows.exposure_max_10ns},
                      plan.exposure.lock);
    // An overview is taken with the unit's own exposures, as Nikon Scan does.
    if (!plan.overview && !meter(plan, metering, observer, stop)) return std::nullopt;
    metering.multiply(plan.exposure.factor);
    exposures = metering.exposures();
    exposures[3] = std::max<std::uint32_t>(
        1, static_cast<std::uint32_t>(exposures[3] * description_.errata.infrared_factor));
  } else {
    for (std::size_t i = 0; i < exposures.size(); ++i) {
      const std::optional<double>& us = plan.exposure.exposure_us[i];
      if (us) exposures[i] = static_cast<std::uint32_t>(std::llround(*us * k10nsPerUs));
    }
  }
  for (std::size_t i = 0; i < (plan.infrared ? 4U : 3U); ++i) {
    context_.exposure_us[i] = exposures[i] / k10nsPerUs;
  }
  return exposures;
}

bool Coolscan::meter(const ScanPlan& plan, Metering& metering, ScanObserver& observer,
                     const std::stop_token& stop) {
  const PassSpec coarse = coarse_pass_of(plan, description_.addresses);
  const auto found = settle(coarse, "exposure pass ", metering, observer, stop);
  if (!found) return false;
  const std::optional<PassSpec> fine = fine_pass_of(plan, coarse, found->brightest_row);
  return !fine || settle(*fine, "fine exposure pass ", metering, observer, stop).has_value();
}

std::optional<Measurement> Coolscan::settle(PassSpec spec, const std::string& what,
                                            Metering& metering, ScanObserver& observer,
                                            const std::stop_token& stop) {
  return settle_metering(metering, observer, [&](const Exposures& exposures, int pass) {
    enter(observer, ScanPhase::kMeter, what + std::to_string(pass));
    spec.exposures = exposures;
    return measure(spec, stop);
  });
}

std::optional<Measurement> Coolscan::measure(const PassSpec& spec, const std::stop_token& stop) {
  ScanPass pass(unit_, spec, pass_rules(), curves_);
  const int n_channels = spec.infrared ? 4 : 3;
  const auto line_samples =
      static_cast<std::size_t>(n_channels) * static_cast<std::size_t>(spec.crop_width_px);
  const auto visible_samples = 3 * static_cast<std::ptrdiff_t>(spec.crop_width_px);
  LevelHistogram histogram(n_channels);
  Measurement measurement;
  std::vector<std::uint16_t> samples;
  std::uint64_t brightest = 0;
  int line_number = 0;
  while (unit_.scan_open()) {
    if (stop.stop_requested()) return std::nullopt;
    const int n = pass.read(samples);
    for (int i = 0; i < n; ++i, ++line_number) {
      const auto line =
          std::span(samples).subspan(static_cast<std::size_t>(i) * line_samples, line_samples);
      histogram.add_line(line);
      const std::uint64_t light =
          std::accumulate(line.begin(), line.begin() + visible_samples, std::uint64_t{0});
      if (light <= brightest) continue;
      brightest = light;
      measurement.brightest_row = line_number;
    }
  }
  for (int c = 0; c < n_channels; ++c) {
    measurement.levels[static_cast<std::size_t>(c)] = histogram.high_level(c);
  }
  unit_.wait_ready(kColdStart);
  return measurement;
}

}  // namespace reseau::coolscan
