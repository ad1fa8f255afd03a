#include "capture/bench/stress_bench.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <utility>

#include <fmt/format.h>

#include "capture/bench/picture_score.h"
#include "capture/bench/registration_score.h"
#include "core/base/error.h"
#include "core/line/memory_line_source.h"

namespace reseau {
namespace {

// A map may be off by three times what it claims, and by what windows at the border of the light
// leave (reseau bench registration).
constexpr double kClaims = 3, kBorderPx = 0.03;
// Clear film has 1; what is larger was amplified.
constexpr double kLargestSample = 8;

bool all_finite(const std::vector<float>& rgb, double& largest) {
  for (const float sample : rgb) {
    if (!std::isfinite(sample)) return false;
    largest = std::max(largest, std::abs(static_cast<double>(sample)));
  }
  return true;
}

std::vector<float> picture_of(const LineSource& source, const Registration& registration,
                              ReconstructOptions options, int n_threads,
                              ReconstructionReport& report) {
  PictureInMemory picture;
  options.n_threads = n_threads;
  report = reconstruct(source, registration, options, picture, {}, {});
  return picture.rgb();
}

// line_error_px: of each line by itself, which no map follows and no claim is about.
void judge(const StressCase& test, const sim::SimulatedScan& scan, double line_error_px,
           const ReconstructOptions& options, StressResult& result) {
  const MemoryLineSource source(scan.format, scan.samples);
  const Registration registration = register_screen(source, {}, {}, {});
  if (!registration.found) {
    result.words = registration.reason;
    if (!result.words.empty()) result.outcome = StressOutcome::kRefused;
    return;
  }
  ReconstructionReport report;
  const std::vector<float> picture = picture_of(source, registration, options, 1, report);
  ReconstructionReport unread;
  result.same_bytes = picture == picture_of(source, registration, options, 5, unread);
  result.condition = report.unmix_condition;
  result.noise_gain = report.unmix_noise_gain;
  const bool finite = all_finite(picture, result.largest_sample);
  bool within = true;
  if (test.truth_holds) {
    const RegistrationScore score = compare_with_truth(scan, registration);
    result.off_px = score.lit_rms_px;
    result.claimed_px = score.sd_px;
    within = scan.truth.has_screen() &&
             result.off_px <= std::hypot(kClaims * result.claimed_px, line_error_px) + kBorderPx;
  }
  if (!finite) {
    result.words = "The picture has samples that are no numbers.";
  } else if (!within) {
    result.words = "The map is farther off than it says.";
  } else if (result.largest_sample > kLargestSample * std::max(1.0, 1 / options.white_level)) {
    result.words = "Something was amplified without a bound.";
  } else if (!result.same_bytes) {
    result.words = "The picture depends on the number of threads.";
  } else {
    result.outcome = StressOutcome::kAnswered;
  }
}

}  // namespace

StressResult run_stress_case(const StressCase& test) {
  StressResult result;
  try {
    const sim::SimSpec spec = sim::parse_sim_spec("ls5000?" + test.film);
    sim::SimulatedScan scan = sim::simulate_frame(spec);
    ReconstructOptions options;
    if (test.harm) test.harm({scan, options});
    judge(test, scan, spec.stage.jitter_px, options, result);
  } catch (const InputError& error) {
    result.outcome = StressOutcome::kRefused;
    result.words = error.what();
  } catch (const std::exception& error) {
    result.outcome = StressOutcome::kFailed;
    result.words = error.what();
  }
  return result;
}

}  // namespace reseau
