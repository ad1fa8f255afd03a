// Names of devices to scanners. An explicit list, no static registration.
//   usb:04b0:4002[:serial]   a unit on the bus
//   sim:ls5000[?key=value&…]  a simulated unit with a simulated film (drivers/sim/README.md)
//   sg:/dev/sg2              a FireWire or SCSI unit behind the kernel's sg driver
//   replay:FILE.pcapng       a recorded session
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/scanner.h"

namespace reseau {

struct DeviceEntry {
  std::string name;         // to be given to open_scanner
  std::string description;  // "Nikon LS-5000 ED, USB"
  bool simulated = false;
  // Empty when the unit can be opened; otherwise a sentence: what is missing and what mends it.
  std::string problem;
};

// Units on the bus, then the simulated models. Opens nothing. Never throws for a missing bus.
[[nodiscard]] std::vector<DeviceEntry> list_devices();

struct OpenOptions {
  std::filesystem::path record_to;  // empty = no recording
  std::string record_comment;       // kept at the head of the recording (the request as JSON)
  // replay: only: times the recorded speed; 0: nobody waits.
  double replay_speed = 0;
  // replay: only: "stall@120", timeout, short, disconnect at that transfer; empty: none.
  std::string replay_fault = {};
};

struct OpenedScanner {
  std::unique_ptr<Scanner> scanner;
  // replay: only: what the recording says of itself.
  std::string recorded_comment;
  std::string recorded_at_utc;
};

// Throws InputError for a name that cannot be understood, DeviceError or std::system_error when the
// unit cannot be opened, each a sentence that says what to do.
[[nodiscard]] OpenedScanner open_scanner(const std::string& name, const OpenOptions& options);

enum class UnstickReport { kWasFine, kMended, kNeedsPowerSwitch };
// What was tried and what came of it, as it happens.
using UnstickTalk = std::function<void(const std::string& tried, const std::string& result)>;
// Gets a unit that no longer does what it is told back to work, gently first. Throws what
// open_scanner throws when the unit cannot even be opened.
[[nodiscard]] UnstickReport unstick_device(const std::string& name, const UnstickTalk& talk);

// One thing that `reseau doctor` looked at.
struct Finding {
  enum class Level { kOk, kWarning, kProblem };
  Level level = Level::kOk;
  std::string what;    // "permission on /dev/bus/usb/001/004"
  std::string detail;  // what was seen
  std::string remedy;  // the exact command or action; empty when nothing is to be done
};

// Everything about devices that can keep a scan from starting: bus, units, permissions, udev rule,
// who else holds the unit. Needs no root, changes nothing.
[[nodiscard]] std::vector<Finding> diagnose_devices();

}  // namespace reseau
