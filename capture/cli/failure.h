// Every error that reaches a person has a sentence, an exit code and, where there is one, a thing
// to try.
#pragma once

#include <exception>
#include <stdexcept>
#include <string>

#include "capture/cli/exit_code.h"

namespace reseau::cli {

class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string& sentence, std::string remedy = {},
          std::string detail = {});

  [[nodiscard]] ExitCode code() const { return code_; }
  // What to do, a sentence; may be empty when the message says it.
  [[nodiscard]] const std::string& remedy() const { return remedy_; }
  // For maintainers: operation, sense; may be empty.
  [[nodiscard]] const std::string& detail() const { return detail_; }

 private:
  ExitCode code_;
  std::string remedy_;
  std::string detail_;
};

// What the program was doing decides what a failed system call means.
enum class Doing {
  kReadingOptions,  // InputError is usage
  kOpeningDevice,   // EACCES is access denied, anything else is the device
  kReadingInput,    // a file we were given
  kWorking,         // a system error is the output's
  kWriting,         // as kWorking, and an InputError is a name that is taken
};

// Any exception as a Failure. A Failure stays what it is.
[[nodiscard]] Failure describe(const std::exception_ptr& error, Doing doing);

// Runs f; an exception leaves as a Failure.
template <typename F>
decltype(auto) as_failure(Doing doing, F&& f) {
  try {
    return f();
  } catch (...) {
    throw describe(std::current_exception(), doing);
  }
}

}  // namespace reseau::cli
