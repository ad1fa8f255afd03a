// Cooperation records, data type 87.
#include "core/base/error.h"
#include "drivers/coolscan/records.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static_cast<void>(reseau::coolscan::parse_cooperation(reseau::fuzz::view(data, size)));
  return 0;
}
