#include "drivers/pieusb/pieusb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/pieusb/metering_pass.h"

namespace reseau::pieusb {
namespace {

using namespace std::chrono_literals;

// The lamp takes about 80 s.
constexpr Duration kWarmLamp = 180s;
constexpr Duration kIdle = 120s;

}  // namespace

Pieusb::Pieusb(std::unique_ptr<UsbTransport> usb, std::shared_ptr<Clock> clock, OpenAs open_as)
    : clock_(std::move(clock)),
      usb_(std::move(usb)),
      bridge_(*usb_, *clock_),
      unit_(bridge_, *clock_),
      open_as_(std::move(open_as)) {
  unit_.annotate("open");
  description_.inquiry = unit_.read_inquiry();
  const Model* const model = model_by_number(description_.inquiry.model_number);
  if (model == nullptr) {
    std::array<char, 8> number{};
    std::snprintf(number.data(), number.size(), "%02X",
                  static_cast<unsigned>(description_.inquiry.model_number));
    throw DeviceError(DeviceError::Kind::kProtocol,
                      "This is not a scanner that the program knows: \"" +
                          description_.inquiry.vendor + " " + description_.inquiry.product +
                          "\", model number " + number.data() + ".",
                      "INQUIRY");
  }
  description_.model = *model;
  description_.serial = usb_->identity().serial;
  description_.link =
      usb_->identity().max_packet_bytes >= 512 ? "USB, high speed" : "USB, full speed";
  unit_.set_model(*model, description_.inquiry.confirms_frame);
  unit_.wait_idle(kIdle);
  description_.film_present = !unit_.read_state().no_film;
  capabilities_ = capabilities_of(description_);
}

Pieusb::~Pieusb() { stop(); }

Negotiated Pieusb::negotiate(const ScanRequest& request) const {
  return pieusb::negotiate(request, description_);
}

void Pieusb::enter(ScanObserver& observer, ScanPhase phase, const std::string& detail) {
  unit_.annotate(detail);
  observer.phase(phase, detail);
}

bool Pieusb::start(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop) {
  CHECK(!pass_);
  try {
    if (prepare(plan, observer, stop)) return true;
  } catch (...) {
    this->stop();
    throw;
  }
  this->stop();
  return false;
}

bool Pieusb::prepare(const ScanPlan& plan, ScanObserver& observer, const std::stop_token& stop) {
  enter(observer, ScanPhase::kWarmUp, "waiting for the scanner");
  if (unit_.pass_open()) unit_.finish_pass();
  if (!unit_.wait_warm(kWarmLamp, stop) || !unit_.wait_idle(kIdle, stop)) return false;
  if (unit_.read_state().no_film) {
    throw DeviceError(DeviceError::Kind::kNoMedium, "No film is in the scanner. Put film in.",
                      "READ STATE");
  }
  memory_.calibration_info = unit_.read_calibration_info();
  memory_.gain = unit_.read_gain();
  if (plan.frame > 1 || capabilities_.n_frames > 1) {
    enter(observer, ScanPhase::kLoad, "moving to frame " + std::to_string(plan.frame));
    if (!unit_.move_to_frame(plan.frame - 1, stop)) return false;
  }
  if (plan.resolution_dpi > description_.model.native_dpi) {
    observer.note("Above " + std::to_string(description_.model.native_dpi) +
                  " dpi this scanner's odd and even columns do not lie on one line; prefer " +
                  std::to_string(description_.model.native_dpi) + " dpi.");
  }

  context_ = begin_context(capabilities_, open_as_);
  const std::optional<Exposures> exposures = settle_exposures(plan, observer, stop);
  if (!exposures || stop.stop_requested()) return false;
  enter(observer, ScanPhase::kScan, "scan");
  PassSpec spec = pass_of(plan, description_);
  spec.exposures = *exposures;
  pass_ = ScanPass::start(unit_, description_, memory_, spec, true, stop);
  if (!pass_) return false;
  format_ = plan.format;
  next_line_ = 0;
  tell_shading(pass_->shading(), observer);
  return true;
}

void Pieusb::tell_shading(const Shading& shading, ScanObserver& observer) const {
  if (!shading.corrects(0)) {
    observer.note("The scanner delivered no calibration; light and pixels are not evened out.");
    return;
  }
  if (shading.n_weak() > 0) {
    observer.note(std::to_string(shading.n_weak()) +
                  " columns of the sensor saw too little light in the calibration and took the "
                  "correction of their neighbours; dust on the calibration area does that.");
  }
  if (format_.plane_of(Channel::kInfrared) >= 0 && !shading.corrects(3)) {
    observer.note("The scanner calibrates no infrared; that channel is as the sensor saw it.");
  }
}

std::optional<Exposures> Pieusb::settle_exposures(const ScanPlan& plan, ScanObserver& observer,
                                                  const std::stop_token& stop) {
  Exposures exposures{};
  // The reference is fixed; what was last written is not in it.
  for (std::size_t i = 0; i < exposures.size(); ++i) exposures[i] = memory_.gain.exposure[i];
  if (plan.exposure.mode == ExposureRequest::Mode::kMeter) {
    const auto limit = [](double us) {
      return static_cast<std::uint32_t>(std::llround(us / kExposureStepUs));
    };
    const ExposureLimits limits{limit(capabilities_.exposure_min_us),
                                limit(capabilities_.exposure_max_us)};
    Metering metering(exposures, limits, plan.exposure.lock);
    const PassSpec coarse = coarse_pass_of(plan, description_);
    const auto found = settle(coarse, "exposure pass ", metering, observer, stop);
    if (!found) return std::nullopt;
    const Exposures most = metering.exposures();
    const auto fine = fine_pass_of(plan, description_, coarse, found->brightest_row);
    if (fine && !settle(*fine, "fine exposure pass ", metering, observer, stop)) {
      return std::nullopt;
    }
    // A few rows say how much brighter single elements of a screen are, never that more light is
    // good for the whole.
    exposures = metering.exposures();
    for (std::size_t i = 0; i < exposures.size(); ++i) {
      const double steps = std::min(exposures[i], most[i]) * plan.exposure.factor;
      exposures[i] =
          static_cast<std::uint32_t>(std::clamp<double>(std::round(steps), limits.min, limits.max));
    }
  } else {
    for (std::size_t i = 0; i < exposures.size(); ++i) {
      const std::optional<double>& us = plan.exposure.exposure_us[i];
      if (!us) continue;
      exposures[i] = static_cast<std::uint32_t>(
          std::clamp<long long>(std::llround(*us / kExposureStepUs), 1, kMaxExposure));
    }
  }
  for (std::size_t i = 0; i < (plan.infrared ? 4U : 3U); ++i) {
    context_.exposure_us[i] = exposures[i] * kExposureStepUs;
  }
  return exposures;
}

std::optional<Measurement> Pieusb::settle(PassSpec spec, const std::string& what,
                                          Metering& metering, ScanObserver& observer,
                                          const std::stop_token& stop) {
  return settle_metering(metering, observer, [&](const Exposures& exposures, int pass) {
    enter(observer, ScanPhase::kMeter, what + std::to_string(pass));
    spec.exposures = exposures;
    return measure(spec, stop);
  });
}

std::optional<Measurement> Pieusb::measure(const PassSpec& spec, const std::stop_token& stop) {
  std::optional<ScanPass> pass = ScanPass::start(unit_, description_, memory_, spec, false, stop);
  if (!pass) return std::nullopt;
  const int n_channels = spec.infrared ? 4 : 3;
  const auto width = static_cast<std::size_t>(spec.width_px);
  const std::size_t row_samples = static_cast<std::size_t>(n_channels) * width;
  LevelHistogram histogram(n_channels);
  Measurement measurement;
  std::vector<std::uint16_t> samples;
  RowTops tops(n_channels);
  while (const int n = pass->read(samples)) {
    for (int i = 0; i < n; ++i) {
      const auto row =
          std::span(samples).subspan(static_cast<std::size_t>(i) * row_samples, row_samples);
      histogram.add_line(row);
      tops.add_row(row);
    }
  }
  measurement.brightest_row = tops.brightest_row();
  for (int c = 0; c < n_channels; ++c) {
    measurement.levels[static_cast<std::size_t>(c)] = histogram.high_level(c);
  }
  unit_.wait_idle(kIdle);
  // Only here: what a pass has begun it has to end.
  if (stop.stop_requested()) return std::nullopt;
  return measurement;
}

ReadStatus Pieusb::read(LineBlock& block, Duration /*timeout*/) {
  if (!pass_) return ReadStatus::kEndOfScan;
  const int n = pass_->read(block.samples);
  if (n == 0) {
    pass_.reset();
    return ReadStatus::kEndOfScan;
  }
  block.first_line = next_line_;
  block.n_lines = n;
  block.width_px = format_.width_px;
  block.n_channels = format_.n_channels();
  next_line_ += n;
  return ReadStatus::kLines;
}

std::string Pieusb::stop_notice() const {
  if (!unit_.pass_open()) return {};
  return "This scanner hangs when a scan is broken off, so the rest of it is read and dropped; "
         "wait, "
         "and do not switch the scanner off.";
}

void Pieusb::stop() noexcept {
  pass_.reset();
  try {
    if (!unit_.pass_open()) return;
    unit_.annotate("stop");
    unit_.finish_pass();
    unit_.wait_idle(kIdle);
  } catch (const std::exception&) {
    // The next start() tries once more and tells.
  }
}

}  // namespace reseau::pieusb
