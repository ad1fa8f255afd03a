// Whatever a unit sends as phase, data and status of a command.
#include <algorithm>
#include <cerrno>

#include "core/base/error.h"
#include "drivers/scsi/nikon_usb_scsi.h"
#include "drivers/scsi/sense.h"
#include "drivers/usb/usb_error.h"
#include "drivers/virtual_clock.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace std::chrono_literals;

// Answers every IN transfer with the next piece of the input: a length, then so many bytes.
class Babbler final : public reseau::UsbTransport {
 public:
  explicit Babbler(reseau::ByteView answers) : answers_(answers) {
    identity_.max_packet_bytes = 64;
  }
  [[nodiscard]] const reseau::UsbIdentity& identity() const override { return identity_; }
  void bulk_out(reseau::Endpoint, std::span<const std::byte>, reseau::Duration) override {}
  std::size_t bulk_in(reseau::Endpoint endpoint, std::span<std::byte> buffer,
                      reseau::Duration) override {
    if (answers_.empty()) throw reseau::transfer_error(ENODEV, endpoint, buffer.size());
    const std::size_t wanted = reseau::u8_at(answers_, 0);
    answers_ = answers_.subspan(1);
    if (wanted == 255) throw reseau::transfer_error(ETIMEDOUT, endpoint, buffer.size());
    if (wanted == 254) throw reseau::transfer_error(EPIPE, endpoint, buffer.size());
    const std::size_t n = std::min({wanted, answers_.size(), buffer.size()});
    std::copy_n(answers_.begin(), n, buffer.begin());
    answers_ = answers_.subspan(n);
    return n;
  }
  void clear_halt(reseau::Endpoint) override {}
  void reset() override {}

 private:
  reseau::ByteView answers_;
  reseau::UsbIdentity identity_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Babbler usb(reseau::fuzz::view(data, size));
  reseau::VirtualClock clock;
  reseau::NikonUsbScsi scsi(usb, clock);
  std::vector<std::byte> in(36);
  for (int i = 0; i < 4; ++i) {
    try {
      const reseau::ScsiReply reply = scsi.receive(reseau::Cdb{0x12, 0, 0, 0, 36, 0x80}, in, 1s);
      if (!reply.good && reseau::sentence_of(reply.sense).empty()) __builtin_trap();
    } catch (const reseau::DeviceError&) {
      // a sentence, which is what a person should get
    }
  }
  return 0;
}
