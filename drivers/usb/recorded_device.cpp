#include "drivers/usb/recorded_device.h"

#include <algorithm>
#include <vector>

#include "core/base/error.h"
#include "drivers/usb/capture_reader.h"
#include "drivers/usb/usb_descriptors.h"

namespace reseau {
namespace {

// Nikon's wrapper: LS-5000 interface specification, USB.
constexpr std::byte kPhaseQuery{0xD0};

bool asks_for_phase(const UsbTransfer& transfer) {
  return transfer.type == UsbTransferType::kBulk && !transfer.in() && transfer.data.size() == 1 &&
         transfer.data[0] == kPhaseQuery;
}

struct Candidate {
  RecordedDevice device;
  bool sent_command = false;  // the last thing that was sent to it
};

}  // namespace

bool is_scsi_command(const UsbTransfer& transfer) {
  return transfer.type == UsbTransferType::kBulk && !transfer.in() &&
         (transfer.data.size() == 6 || transfer.data.size() == 10);
}

bool writes_bridge_port(const UsbTransfer& transfer) {
  // PIE bridges take a byte for a port with this request (SANE's pieusb backend).
  return transfer.type == UsbTransferType::kControl && transfer.setup &&
         u8_at(*transfer.setup, 0) == 0x40 && u8_at(*transfer.setup, 1) == 0x0C;
}

RecordedDevice find_recorded_device(const std::filesystem::path& path) {
  TransferReader transfers(path);
  std::vector<Candidate> known;
  while (const auto transfer = transfers.next()) {
    auto one = std::find_if(known.begin(), known.end(), [&](const Candidate& c) {
      return c.device.bus == transfer->bus && c.device.device == transfer->device;
    });
    if (one == known.end()) {
      known.push_back({{transfer->bus, transfer->device, {}}, false});
      one = known.end() - 1;
    }
    if (transfer->type == UsbTransferType::kControl) {
      learn_identity(*transfer, one->device.identity);
    }
    // Six bytes may be anybody's; the phase query behind them is Nikon's alone.
    if (writes_bridge_port(*transfer) || (one->sent_command && asks_for_phase(*transfer))) {
      return one->device;
    }
    if (transfer->type == UsbTransferType::kBulk && !transfer->in()) {
      one->sent_command = is_scsi_command(*transfer);
    }
  }
  throw InputError("The recording " + path.string() +
                   " holds no commands to a scanner. Record with --record, or with Wireshark on "
                   "the bus that the scanner is plugged into.");
}

}  // namespace reseau
