// A window of a film, lines at a time: the samples of a scan in as little memory as a few lines
// need.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/line/line_format.h"
#include "drivers/sim/scan_renderer.h"
#include "drivers/sim/sim_spec.h"

namespace reseau::sim {

// Immutable; lines() is thread-safe and uses all cores.
class WindowRender {
 public:
  // Throws InputError when the window is empty.
  WindowRender(const SimSpec& spec, const ScanWindow& window);

  [[nodiscard]] const LineFormat& format() const { return format_; }  // red, green, blue, infrared
  // How many lines at a time keep all cores busy: more where they are short.
  [[nodiscard]] int band_lines() const;
  // Lines first_line … first_line + n_lines as [line][channel][pixel], full scale 65535 whatever
  // the bits. A sample does not depend on how the window is cut into calls.
  void lines(int first_line, int n_lines, std::span<std::uint16_t> out) const;

 private:
  SimSpec spec_;
  ScanWindow window_;
  ScanRenderer renderer_;
  LineFormat format_;
};

}  // namespace reseau::sim
