#include "capture/cli/failure.h"

#include <new>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace reseau::cli {

Failure::Failure(ExitCode code, const std::string& sentence, std::string remedy, std::string detail)
    : std::runtime_error(sentence),
      code_(code),
      remedy_(std::move(remedy)),
      detail_(std::move(detail)) {}

namespace {

Failure from_device(const DeviceError& error) {
  using Kind = DeviceError::Kind;
  switch (error.kind()) {
    case Kind::kBusy:
      return {kExitBusy, error.what(), "Close the other program, then try again.", error.detail()};
    case Kind::kNoMedium:
      return {kExitNoFilm, error.what(), "Insert film until the unit takes it, then try again.",
              error.detail()};
    case Kind::kDisconnected:
      return {kExitDevice, error.what(), "Check cable and power, then try again.", error.detail()};
    default:
      return {kExitDevice, error.what(), "Run 'reseau doctor' to see what the unit says.",
              error.detail()};
  }
}

Failure from_system(const std::system_error& error, Doing doing) {
  const bool denied = error.code() == std::errc::permission_denied ||
                      error.code() == std::errc::operation_not_permitted;
  switch (doing) {
    case Doing::kOpeningDevice:
      if (denied) {
        return {kExitAccessDenied, error.what(),
                "Run 'reseau doctor'; it prints the exact remedy."};
      }
      return {kExitDevice, error.what(), "Run 'reseau doctor' to see what is in the way."};
    case Doing::kReadingOptions:
    case Doing::kReadingInput:
      return {kExitInput, error.what(), "Check the name and the permissions of the file."};
    case Doing::kWorking:
    case Doing::kWriting:
      break;
  }
  if (error.code() == std::errc::no_space_on_device || error.code() == std::errc::file_too_large) {
    return {kExitOutput, error.what(), "Free some space or choose another folder with -o."};
  }
  return {kExitOutput, error.what(), "Choose a folder that can be written with -o."};
}

}  // namespace

Failure describe(const std::exception_ptr& error, Doing doing) {
  try {
    std::rethrow_exception(error);
  } catch (const Failure& failure) {
    return failure;
  } catch (const InputError& input) {
    switch (doing) {
      case Doing::kReadingOptions:
      case Doing::kOpeningDevice:
        return {kExitUsage, input.what()};
      case Doing::kReadingInput:
      case Doing::kWorking:
        return {kExitInput, input.what()};
      case Doing::kWriting:
        return {kExitOutput, input.what()};
    }
    return {kExitInput, input.what()};
  } catch (const DeviceError& device) {
    return from_device(device);
  } catch (const std::system_error& system) {
    return from_system(system, doing);
  } catch (const std::bad_alloc&) {
    return {kExitNoMemory, "There is not enough memory for this picture.",
            "Close other programs, or work on a smaller area."};
  } catch (const std::exception& other) {
    return {kExitInternal, fmt::format("The program made a mistake: {}.", other.what()),
            "Please report this, with the command that led here."};
  } catch (...) {
    return {kExitInternal, "The program made a mistake that it cannot name.",
            "Please report this, with the command that led here."};
  }
}

}  // namespace reseau::cli
