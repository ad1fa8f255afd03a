// Captures: pcapng and pcap of any program, damaged in any way.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

#include "core/base/error.h"
#include "drivers/usb/replay_transport.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

// One file per process, in memory where there is such a place.
const std::filesystem::path& scratch() {
  static const std::filesystem::path path = [] {
    const char* const folder = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
    return std::filesystem::path(folder) / ("reseau-fuzz-" + std::to_string(getpid()) + ".pcapng");
  }();
  static const int registered = std::atexit([] {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  });
  static_cast<void>(registered);
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::FILE* const file = std::fopen(scratch().c_str(), "wb");
  if (file == nullptr) std::abort();
  if (size > 0 && std::fwrite(data, 1, size, file) != size) std::abort();
  std::fclose(file);
  try {
    reseau::TransferReader reader(scratch());
    while (reader.next()) {
    }
  } catch (const reseau::InputError&) {
    // said, not crashed
  }
  try {
    reseau::VirtualClock clock;
    reseau::ReplayTransport replay(scratch(), clock, {});
    std::vector<std::byte> buffer(512);
    while (true) replay.bulk_in(0x82, buffer, reseau::Duration(0));
  } catch (const std::exception&) {
    // every replay ends
  }
  return 0;
}
