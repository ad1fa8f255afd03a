// Frame tables: as a unit sends them to the driver, as a driver sends them to the simulated unit.
#include "core/base/error.h"
#include "drivers/coolscan/frames.h"
#include "drivers/sim/frame_table.h"
#include "drivers/sim/unit_model.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const reseau::ByteView bytes = reseau::fuzz::view(data, size);
    static_cast<void>(reseau::coolscan::parse_frame_table(bytes));
    static_cast<void>(reseau::coolscan::parse_frame_page(bytes));
    static_cast<void>(reseau::coolscan::parse_perforations(bytes, 4000));
  } catch (const reseau::DeviceError&) {
    // said, not crashed
  }
  reseau::sim::FrameTable table(reseau::sim::unit_model("ls50"), 6, 5959);
  const bool kept = table.set_frames({data, size}).good();
  if (kept && table.frames_reply().size() != size + 6) __builtin_trap();
  if (table.set_rectangles({data, size}).good() && table.rectangles_reply().size() != size + 6) {
    __builtin_trap();
  }
  static_cast<void>(table.film_position(5959));
  return 0;
}
