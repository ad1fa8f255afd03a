#pragma once

#include <memory>
#include <string>

#include "drivers/pieusb/pieusb.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/virtual_clock.h"
#include "tests/replay/simulated_scan.h"

namespace reseau {

inline std::unique_ptr<pieusb::Pieusb> open_pie(std::unique_ptr<UsbTransport> usb) {
  return std::make_unique<pieusb::Pieusb>(std::move(usb), std::make_shared<VirtualClock>(),
                                          OpenAs{"sim:test", "2026-11-24T00:00:00Z"});
}

inline std::unique_ptr<pieusb::Pieusb> open_pie(const std::string& name) {
  return open_pie(sim::open_simulated_unit(name));
}

// Every simulated model of the family.
inline constexpr const char* kPieUnits[] = {
    "sim:crystalscan3600", "sim:crystalscan7200", "sim:proscan7200", "sim:proscan10t",
    "sim:digitdia5000",    "sim:digitdia6000",    "sim:rps7200"};

}  // namespace reseau
