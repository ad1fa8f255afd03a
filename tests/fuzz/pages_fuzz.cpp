// INQUIRY pages, standard data and windows as a unit sends them.
#include "core/base/error.h"
#include "drivers/coolscan/commands.h"
#include "drivers/coolscan/pages.h"
#include "drivers/coolscan/window.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace coolscan = reseau::coolscan;
  const reseau::ByteView page = reseau::fuzz::view(data, size);
  static_cast<void>(coolscan::decode_window(page));
  // The driver asks for nine bytes and is given nine, or an error.
  if (size >= 9) static_cast<void>(coolscan::decode_parameters(page));
  if (size >= 36) static_cast<void>(coolscan::parse_standard_inquiry(page));
  for (int which = 0; which < 5; ++which) {
    try {
      if (which == 0) static_cast<void>(coolscan::parse_page_list(page));
      if (which == 1) static_cast<void>(coolscan::parse_name_page(page));
      if (which == 2) static_cast<void>(coolscan::parse_addresses(page));
      if (which == 3) static_cast<void>(coolscan::parse_window_abilities(page).depths_bits());
      if (which == 4) static_cast<void>(coolscan::parse_duties(page).offers(0xA0));
    } catch (const reseau::DeviceError&) {
      // said, not crashed
    }
  }
  return 0;
}
