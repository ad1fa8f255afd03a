// What a unit of this family says of a command, for people.
#pragma once

#include <string>

#include "core/base/error.h"
#include "drivers/scsi/sense.h"

namespace reseau::pieusb {

// Stands for a check condition whose reason got lost on the way; sense is never read twice.
inline constexpr Sense kUnknownSense{.key = 0x0F};

[[nodiscard]] inline bool warming_up(const Sense& s) { return s.is(2, 4, 1); }
// In a READ; otherwise an unknown command.
[[nodiscard]] inline bool no_more_lines(const Sense& s) { return s.is(5, 0x20, 0); }
// "Calibration disable not granted": lines for shading come first.
[[nodiscard]] inline bool must_calibrate(const Sense& s) { return s.is(6, 0x82, 0); }
[[nodiscard]] inline bool power_on(const Sense& s) { return s.is(6, 0x29, 0); }

// A whole sentence for the person at the bench, with the code in brackets.
[[nodiscard]] std::string pie_sentence(const Sense& sense);
// The error that stands for it. `operation` goes into detail().
[[nodiscard]] DeviceError pie_error(const Sense& sense, const std::string& operation);

}  // namespace reseau::pieusb
