// Exception types of the program. Outcomes that a caller must handle are values, never exceptions;
// a failed environment (disk, permission) is std::system_error; a bug is CHECK (check.h).
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace reseau {

// What a person gave us (a file, an option, a profile) cannot be used. `what()` is a whole sentence
// that names the source and says what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A device failed: unplugged, stalled, silent, or it reported a hardware error. `what()` is a whole
// sentence for the person at the bench; `detail()` holds what a maintainer needs (operation, CDB,
// sense, bytes transferred).
class DeviceError : public std::runtime_error {
 public:
  enum class Kind {
    kDisconnected,  // the unit is no longer there
    kTimeout,       // no answer before the deadline
    kStall,         // the endpoint halted
    kProtocol,      // an answer that the protocol does not allow
    kRefused,       // the unit refused a command (sense key 05)
    kHardware,      // the unit reported a hardware or medium error (sense keys 03, 04, 0B)
    kNoMedium,      // no film
    kBusy,          // another program holds the unit
  };

  DeviceError(Kind kind, const std::string& sentence, std::string detail)
      : std::runtime_error(sentence), kind_(kind), detail_(std::move(detail)) {}

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] const std::string& detail() const { return detail_; }

 private:
  Kind kind_;
  std::string detail_;
};

}  // namespace reseau
