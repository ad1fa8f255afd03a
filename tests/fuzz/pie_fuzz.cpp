// Whatever a PIE unit answers while the driver opens it and starts a scan; then lines with tags and
// a calibration made of the same bytes.
#include <algorithm>
#include <cerrno>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "drivers/pieusb/line_sorter.h"
#include "drivers/pieusb/pieusb.h"
#include "drivers/pieusb/shading.h"
#include "drivers/usb/usb_error.h"
#include "drivers/virtual_clock.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

// Answers every request with the next bytes of the input; a status of FE or FD is a time-out or a
// stall. Gone when they are used up.
class PieBabbler final : public reseau::UsbTransport {
 public:
  explicit PieBabbler(reseau::ByteView answers) : answers_(answers) {
    identity_.vendor_id = 0x05e3;
    identity_.bulk_in = 0x81;
  }
  [[nodiscard]] const reseau::UsbIdentity& identity() const override { return identity_; }
  void bulk_out(reseau::Endpoint, std::span<const std::byte>, reseau::Duration) override {}
  std::size_t bulk_in(reseau::Endpoint endpoint, std::span<std::byte> buffer,
                      reseau::Duration) override {
    return answer(endpoint, buffer);
  }
  void control_out(const reseau::ControlRequest&, std::span<const std::byte>,
                   reseau::Duration) override {}
  std::size_t control_in(const reseau::ControlRequest&, std::span<std::byte> buffer,
                         reseau::Duration) override {
    const std::size_t n = answer(0x80, buffer);
    if (buffer[0] == std::byte{0xFE}) throw reseau::transfer_error(ETIMEDOUT, 0x80, 1);
    if (buffer[0] == std::byte{0xFD}) throw reseau::transfer_error(EPIPE, 0x80, 1);
    return n;
  }
  void clear_halt(reseau::Endpoint) override {}
  void reset() override {}

 private:
  std::size_t answer(reseau::Endpoint endpoint, std::span<std::byte> buffer) {
    if (answers_.empty()) throw reseau::transfer_error(ENODEV, endpoint, buffer.size());
    const std::size_t n = std::min(answers_.size(), buffer.size());
    std::copy_n(answers_.begin(), n, buffer.begin());
    answers_ = answers_.subspan(n);
    return n;
  }

  reseau::ByteView answers_;
  reseau::UsbIdentity identity_;
};

class Deaf final : public reseau::ScanObserver {
 public:
  void phase(reseau::ScanPhase, const std::string&) override {}
  void note(const std::string&) override {}
};

void open_and_scan(reseau::ByteView answers) {
  try {
    reseau::pieusb::Pieusb scanner(std::make_unique<PieBabbler>(answers),
                                   std::make_shared<reseau::VirtualClock>(), {"fuzz", ""});
    reseau::ScanRequest request;
    request.exposure.mode = reseau::ExposureRequest::Mode::kFixed;
    Deaf observer;
    const reseau::ScanPlan plan = scanner.negotiate(request).plan;
    if (!scanner.start(plan, observer, {})) return;
    reseau::LineBlock block;
    while (scanner.read(block, reseau::Duration(0)) == reseau::ReadStatus::kLines) {
    }
  } catch (const reseau::DeviceError&) {
    // a sentence, which is what a person should get
  } catch (const reseau::InputError&) {
    // a unit that offers nothing that could be asked for
  }
}

void sort_and_even_out(reseau::ByteView bytes) {
  constexpr int kRows = 8;
  const int width = 1 + reseau::u8_at(bytes, 0) % 32, n_channels = 3 + reseau::u8_at(bytes, 1) % 2;
  const int sample_bytes = 1 + reseau::u8_at(bytes, 1) / 2 % 2;
  bytes = bytes.subspan(2);
  try {
    reseau::pieusb::LineSorter sorter(width, kRows, n_channels, sample_bytes);
    for (auto rest = bytes; rest.size() >= sorter.line_bytes();
         rest = rest.subspan(sorter.line_bytes())) {
      sorter.add(rest.first(sorter.line_bytes()));
      while (sorter.rows_ready() > 0) static_cast<void>(sorter.take());
    }
  } catch (const reseau::DeviceError&) {
    // lines that nobody asked for
  }
  try {
    const std::size_t line = 2 + 2 * static_cast<std::size_t>(width);
    const auto reference =
        reseau::pieusb::reference_of(bytes.first(bytes.size() / line * line), width);
    std::vector<std::uint16_t> row(static_cast<std::size_t>(width) * 4, 0x1234);
    reseau::pieusb::Shading(reference, {0}, width).apply(row, 4);
  } catch (const reseau::DeviceError&) {
    // no light in it
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  open_and_scan(reseau::fuzz::view(data, size));
  sort_and_even_out(reseau::fuzz::view(data, size));
  return 0;
}
