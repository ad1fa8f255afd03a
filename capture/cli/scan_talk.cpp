#include "capture/cli/scan_talk.h"

#include <array>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace reseau::cli {

namespace {

const char* phase_word(ScanPhase phase) {
  switch (phase) {
    case ScanPhase::kWarmUp:
      return "warm-up";
    case ScanPhase::kLoad:
      return "load";
    case ScanPhase::kFocus:
      return "focus";
    case ScanPhase::kMeter:
      return "meter";
    case ScanPhase::kScan:
      return "scan";
  }
  return "scan";
}

}  // namespace

void ScanTalk::phase(ScanPhase phase, const std::string& detail) {
  // began() opens this phase, when exposure and focus are known.
  if (phase == ScanPhase::kScan) return;
  reporter_.phase(phase_word(phase), detail);
}

void ScanTalk::note(const std::string& sentence) { reporter_.note(sentence); }

void ScanTalk::began(const LineFormat& format, const CaptureContext& context) {
  bytes_per_line_ = static_cast<double>(format.samples_per_line() * sizeof(std::uint16_t));
  constexpr std::array kNames{"red", "green", "blue", "infrared"};
  std::string settled;
  nlohmann::ordered_json exposure = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (!context.exposure_us[i]) continue;
    settled += fmt::format("{}{} {:.0f} us", settled.empty() ? "exposure " : ", ", kNames[i],
                           *context.exposure_us[i]);
    exposure[kNames[i]] = *context.exposure_us[i];
  }
  nlohmann::ordered_json fields = {{"rows", format.n_lines}, {"exposure_us", exposure}};
  if (context.focus_position) {
    settled += fmt::format("{}focus {}", settled.empty() ? "" : "; ", *context.focus_position);
    fields["focus_position"] = *context.focus_position;
  }
  reporter_.event("settled", fields);
  reporter_.phase("scan", settled);
  if (page_ != nullptr) page_->set_phase("scanning");
}

void ScanTalk::progress(int lines_read, int lines_committed, int n_lines) {
  static_cast<void>(lines_read);
  // What is safe on disk is what counts.
  reporter_.progress("scan", {static_cast<double>(lines_committed), static_cast<double>(n_lines),
                              "lines", lines_committed * bytes_per_line_});
  if (page_ != nullptr) page_->set_lines(lines_committed, n_lines);
}

double master_bytes(const LineFormat& format) {
  return static_cast<double>(format.samples_per_line()) * format.n_lines * sizeof(std::uint16_t);
}

std::string plan_line(const ScanPlan& plan, const std::string& place) {
  return fmt::format("1 frame · {} dpi · {} · {} bit · {} × {} px · {} · to {}",
                     plan.resolution_dpi, plan.infrared ? "RGB+IR" : "RGB", plan.depth_bits,
                     plan.format.width_px, plan.format.n_lines,
                     human_bytes(master_bytes(plan.format)), place);
}

std::string device_line(const Capabilities& c) {
  std::string text = c.make.empty() ? c.model : c.make + " " + c.model;
  if (!c.firmware.empty()) text += " " + c.firmware;
  if (!c.serial.empty()) text += ", serial " + c.serial;
  if (!c.adapter.empty()) text += ", " + c.adapter;
  if (!c.link.empty()) text += ", " + c.link;
  return text;
}

std::string adjustment_line(const Adjustment& a) {
  return fmt::format("{}: {} instead of {}, because {}.", a.field, a.granted, a.asked, a.why);
}

}  // namespace reseau::cli
