#include "capture/cli/failure.h"

#include <cerrno>
#include <new>
#include <system_error>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace reseau::cli {
namespace {

template <typename E>
Failure of(const E& error, Doing doing) {
  return describe(std::make_exception_ptr(error), doing);
}

DeviceError device(DeviceError::Kind kind) { return {kind, "It failed.", "op=READ"}; }

TEST(Failure, DeviceErrorsHaveSanesCodes) {
  using Kind = DeviceError::Kind;
  EXPECT_EQ(of(device(Kind::kBusy), Doing::kOpeningDevice).code(), 3);
  EXPECT_EQ(of(device(Kind::kNoMedium), Doing::kWorking).code(), 7);
  for (const Kind kind : {Kind::kDisconnected, Kind::kTimeout, Kind::kStall, Kind::kProtocol,
                          Kind::kRefused, Kind::kHardware}) {
    EXPECT_EQ(of(device(kind), Doing::kWorking).code(), 9);
  }
  EXPECT_EQ(of(device(Kind::kStall), Doing::kWorking).detail(), "op=READ");
}

TEST(Failure, TheSameErrorMeansWhatTheProgramWasDoing) {
  const InputError input("No.");
  EXPECT_EQ(of(input, Doing::kReadingOptions).code(), 64);
  EXPECT_EQ(of(input, Doing::kOpeningDevice).code(), 64);
  EXPECT_EQ(of(input, Doing::kReadingInput).code(), 65);
  EXPECT_EQ(of(input, Doing::kWriting).code(), 74);
  const std::system_error denied(EACCES, std::generic_category(), "x");
  EXPECT_EQ(of(denied, Doing::kOpeningDevice).code(), 11);
  EXPECT_EQ(of(denied, Doing::kReadingInput).code(), 65);
  EXPECT_EQ(of(denied, Doing::kWorking).code(), 74);
  const std::system_error full(ENOSPC, std::generic_category(), "x");
  EXPECT_EQ(of(full, Doing::kWorking).code(), 74);
  EXPECT_EQ(of(full, Doing::kWriting).code(), 74);
}

TEST(Failure, MemoryAndBugsHaveTheirOwn) {
  EXPECT_EQ(of(std::bad_alloc(), Doing::kWorking).code(), 10);
  EXPECT_EQ(of(std::logic_error("x"), Doing::kWorking).code(), 70);
  EXPECT_EQ(of(7, Doing::kWorking).code(), 70);
}

TEST(Failure, AFailureStaysWhatItIs) {
  const Failure kept = of(Failure(kExitPartial, "a", "b", "c"), Doing::kReadingOptions);
  EXPECT_EQ(kept.code(), 75);
  EXPECT_STREQ(kept.what(), "a");
  EXPECT_EQ(kept.remedy(), "b");
}

}  // namespace
}  // namespace reseau::cli
