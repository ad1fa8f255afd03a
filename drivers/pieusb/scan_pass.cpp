#include "drivers/pieusb/scan_pass.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::pieusb {
namespace {

// The first READ of a calibration, and every one where the number of lines is not known.
constexpr int kFirstCalibrationLines = 4;
// Far above the 160 that have been seen.
constexpr int kMostCalibrationLines = 2000;
// Below full width: where an RPS 7200 calibrates, on the clear part of its gate.
constexpr int kOwnPassTopPx = 3431;

PassSetup setup_of(const PassSpec& spec, const Model& model, const GainReference& gain,
                   std::uint16_t quality) {
  PassSetup setup;
  setup.frame = spec.frame;
  setup.mode = {spec.dpi, spec.infrared, spec.depth_bits, quality};
  for (std::size_t c = 0; c < spec.exposures.size(); ++c) {
    setup.gain.exposure[c] = static_cast<std::uint16_t>(
        std::clamp<std::uint32_t>(spec.exposures[c], 1, std::uint32_t{kMaxExposure}));
  }
  setup.gain.offset = gain.offset;
  setup.gain.gain = gain.gain;
  setup.gain.light = static_cast<std::uint8_t>(model.dialect.light);
  setup.gain.infrared = spec.infrared;
  return setup;
}

std::uint16_t with(std::uint16_t quality, Quality more) {
  return static_cast<std::uint16_t>(quality | static_cast<std::uint16_t>(more));
}

// Lines of the calibration that the unit has just begun to deliver.
Bytes calibration_lines(Unit& unit, const CalibrationInfo& info, bool count_known) {
  Bytes lines;
  int most = kFirstCalibrationLines;
  while (true) {
    const ByteView some = unit.read_calibration_lines(most);
    if (some.empty()) return lines;
    lines.insert(lines.end(), some.begin(), some.end());
    if (!count_known || most != kFirstCalibrationLines) continue;
    unit.wait_idle(std::chrono::seconds(120));
    most = info.n_lines;
  }
}

// A pass that delivers nothing but calibration lines.
void calibrate(Unit& unit, const UnitDescription& description, PassMemory& memory,
               const PassSpec& spec, const std::stop_token& stop) {
  PassSpec own = spec;
  const Inquiry& inquiry = description.inquiry;
  own.frame = {inquiry.area.x0, inquiry.area.y0 + std::min(kOwnPassTopPx, inquiry.max_height_px),
               inquiry.area.x0 + inquiry.max_width_px - 1, inquiry.area.y0 + inquiry.max_height_px};
  own.dpi = description.model.native_dpi;
  own.infrared = false;
  for (std::size_t c = 0; c < own.exposures.size(); ++c) {
    own.exposures[c] = memory.gain.exposure[c];
  }
  unit.set_up(setup_of(own, description.model, memory.gain,
                       static_cast<std::uint16_t>(Quality::kCalibrateNow)));
  unit.expect_calibration_pass(kMostCalibrationLines);
  if (unit.start_scan(stop) == Unit::Started::kStopped) return;
  const Bytes lines = calibration_lines(unit, memory.calibration_info, false);
  memory.held = HeldReference{reference_of(lines, memory.calibration_info.width_px), own.exposures};
}

DeviceError wrong_size(const ScanParameters& parameters, const PassSpec& spec) {
  return {DeviceError::Kind::kProtocol,
          "The scanner delivers another size than it was asked for. Choose another resolution or "
          "area.",
          "asked " + std::to_string(spec.width_px) + " x " + std::to_string(spec.n_lines) +
              ", granted " + std::to_string(parameters.width_px) + " x " +
              std::to_string(parameters.n_lines) + ", " + std::to_string(parameters.line_bytes) +
              " bytes per line"};
}

}  // namespace

ScanPass::ScanPass(Unit& unit, const PassSpec& spec, int wire_width_px, int wire_lines)
    : unit_(&unit),
      width_px_(spec.width_px),
      n_channels_(spec.infrared ? 4 : 3),
      rows_left_(spec.n_lines),
      sorter_(wire_width_px, wire_lines, n_channels_, spec.depth_bits == 8 ? 1 : 2) {}

std::optional<ScanPass> ScanPass::start(Unit& unit, const UnitDescription& description,
                                        PassMemory& memory, const PassSpec& spec,
                                        bool fresh_calibration, const std::stop_token& stop) {
  const Dialect& dialect = description.model.dialect;
  unit.set_calibration_shape(
      memory.calibration_info.n_lines,
      kTagBytes + 2 * static_cast<std::size_t>(memory.calibration_info.width_px));
  if (dialect.calibrates_in_own_pass && !memory.held) {
    calibrate(unit, description, memory, spec, stop);
    if (!memory.held) return std::nullopt;
  }
  const bool skip = memory.held && (dialect.calibrates_in_own_pass || !fresh_calibration ||
                                    memory.held->exposures == spec.exposures);
  std::uint16_t quality = skip ? with(0, Quality::kSkipShading) : std::uint16_t{0};
  if (spec.infrared) quality = with(quality, Quality::kFastInfrared);
  if (stop.stop_requested()) return std::nullopt;
  unit.set_up(setup_of(spec, description.model, memory.gain, quality));
  std::vector<int> used;
  const int mask_px = memory.calibration_info.width_px;
  if (dialect.mask_before_scan) used = unit.read_mask(mask_px);
  Unit::Started started = unit.start_scan(stop);
  if (started == Unit::Started::kCalibrationFirst && dialect.calibrates_in_own_pass) {
    // It forgot its calibration: switched off and on in between.
    calibrate(unit, description, memory, spec, stop);
    unit.set_up(setup_of(spec, description.model, memory.gain, quality));
    used = unit.read_mask(mask_px);
    started = unit.start_scan(stop);
    if (started == Unit::Started::kCalibrationFirst) {
      throw DeviceError(DeviceError::Kind::kHardware,
                        "The scanner does not keep its calibration. Switch it off, wait ten "
                        "seconds, switch it on again and repeat the scan.",
                        "06/82/00 after a calibration");
    }
  }
  if (started == Unit::Started::kStopped) return std::nullopt;
  if (started == Unit::Started::kCalibrationFirst) {
    const Bytes lines = calibration_lines(unit, memory.calibration_info, true);
    memory.held = HeldReference{reference_of(lines, mask_px), spec.exposures};
    unit.wait_idle(std::chrono::seconds(120));
  }
  if (!dialect.mask_before_scan) used = unit.read_mask(mask_px);
  const ScanParameters parameters = unit.read_parameters();
  unit.expect_image(parameters.n_lines * (spec.infrared ? 4 : 3),
                    static_cast<std::size_t>(parameters.line_bytes) + kTagBytes);
  const int sample_bytes = spec.depth_bits == 8 ? 1 : 2;
  if (parameters.width_px < spec.width_px || parameters.n_lines < spec.n_lines ||
      parameters.line_bytes != parameters.width_px * sample_bytes) {
    throw wrong_size(parameters, spec);
  }
  ScanPass pass(unit, spec, parameters.width_px, parameters.n_lines);
  if (memory.held) pass.shading_ = Shading(memory.held->reference, used, parameters.width_px);
  return pass;
}

int ScanPass::read(std::vector<std::uint16_t>& samples) {
  if (rows_left_ == 0) {
    // Surplus lines do not stay behind in the unit.
    unit_->finish_pass();
    return 0;
  }
  while (sorter_.rows_ready() == 0) {
    const ByteView lines = unit_->read_image_lines();
    if (lines.empty()) {
      throw DeviceError(DeviceError::Kind::kProtocol,
                        "The scanner ended the scan " + std::to_string(rows_left_) +
                            " lines too early. The lines before are kept. Scan again.",
                        "READ");
    }
    for (std::size_t at = 0; at < lines.size(); at += sorter_.line_bytes()) {
      sorter_.add(lines.subspan(at, sorter_.line_bytes()));
    }
  }
  const int n = std::min(sorter_.rows_ready(), rows_left_);
  const auto wanted = static_cast<std::size_t>(width_px_);
  const auto planes = static_cast<std::size_t>(n_channels_);
  const std::size_t needed = static_cast<std::size_t>(n) * planes * wanted;
  if (samples.size() < needed) samples.resize(needed);
  auto to = samples.begin();
  for (int i = 0; i < n; ++i) {
    std::vector<std::uint16_t> row = sorter_.take();
    shading_.apply(row, n_channels_);
    const std::size_t width = row.size() / planes;
    for (std::size_t c = 0; c < planes; ++c) {
      const auto from = row.begin() + static_cast<std::ptrdiff_t>(c * width);
      to = std::copy(from, from + width_px_, to);
    }
  }
  rows_left_ -= n;
  return n;
}

}  // namespace reseau::pieusb
