// Requests of a USB/IP client, to the simulated unit itself. The first byte says whether the client
// has attached already.
#include <vector>

#include "core/base/error.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/usbip/exported_device.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace usbip = reseau::usbip;
  if (size == 0) return 0;
  static const auto unit = reseau::sim::open_simulated_unit(
      "sim:ls5000?width_px=64&height_px=64&border_px=0&rebate_px=0&cells=1");
  usbip::DeviceDescription description;
  description.endpoints = {{0x01, false, 0, 0}, {0x82, false, 0, 0}, {0x83, true, 8, 0xC8}};
  usbip::ExportedDevice device(description, *unit);
  usbip::RequestReader reader;
  if (data[0] != 0) reader.attach();
  reader.feed(reseau::fuzz::view(data + 1, size - 1));
  std::vector<usbip::Completion> done;
  try {
    while (auto request = reader.next()) {
      if (auto* submit = std::get_if<usbip::SubmitRequest>(&*request)) {
        submit->device_id = 0x10002;
        submit->length = submit->in ? submit->length % 65536 : submit->length;
        device.submit(std::move(*submit), done);
      } else if (const auto* unlink = std::get_if<usbip::UnlinkRequest>(&*request)) {
        done.push_back(device.unlink(*unlink));
      }
    }
  } catch (const reseau::InputError&) {
    // the connection ends
  }
  reseau::Bytes bytes;
  for (const usbip::Completion& completion : done) usbip::append_completion(completion, bytes);
  device.detach();
  return 0;
}
