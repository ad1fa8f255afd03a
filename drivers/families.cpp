#include "drivers/families.h"

#include <string>
#include <string_view>
#include <utility>

#include "drivers/coolscan/coolscan.h"
#include "drivers/coolscan/explain.h"
#include "drivers/coolscan/models.h"
#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/models.h"
#include "drivers/pieusb/pieusb.h"
#include "drivers/scsi/scsi_as_usb.h"
#include "drivers/scsi/scsi_link.h"

namespace reseau {

std::string trade_name_of(std::uint16_t vendor_id, std::uint16_t product_id) {
  if (const coolscan::Model* const model = coolscan::model_by_usb_id(vendor_id, product_id)) {
    return std::string(model->trade_name);
  }
  std::string names;
  if (!pieusb::is_known_usb_id(vendor_id, product_id)) return names;
  for (const pieusb::Model& model : pieusb::models()) {
    if (model.product_id != product_id) continue;
    constexpr std::string_view kMake = "Reflecta ";
    std::string_view name = model.trade_name;
    if (!names.empty() && name.starts_with(kMake)) name.remove_prefix(kMake.size());
    names.append(names.empty() ? "" : ", or ").append(name);
  }
  return names;
}

std::vector<UsbDeviceInfo> list_known_units() {
  std::vector<UsbDeviceInfo> units;
  for (const std::uint16_t vendor : {coolscan::kNikonVendorId, pieusb::kGenesysVendorId}) {
    for (UsbDeviceInfo& unit : list_usb_devices(vendor)) {
      if (!trade_name_of(unit.vendor_id, unit.product_id).empty()) units.push_back(std::move(unit));
    }
  }
  return units;
}

std::unique_ptr<Scanner> open_family(std::unique_ptr<UsbTransport> usb,
                                     std::shared_ptr<Clock> clock, OpenAs open_as) {
  if (usb->identity().vendor_id == pieusb::kGenesysVendorId) {
    return std::make_unique<pieusb::Pieusb>(std::move(usb), std::move(clock), std::move(open_as));
  }
  const bool is_scsi = usb->identity().product_id == ScsiAsUsb::kScsiProductId;
  ScsiLink link = usb_scsi_link(std::move(usb), *clock);
  if (is_scsi) as_scsi(link);
  return std::make_unique<coolscan::Coolscan>(std::move(link), std::move(clock),
                                              std::move(open_as));
}

ReplayTransport::Decoder command_decoder() {
  return {coolscan::name_of_command, coolscan::source_of,
          [](ByteView cdb) { return pieusb::describe(Cdb(cdb)); },
          [](ByteView /*cdb*/) {
            return std::string("SANE's pieusb backend; s6stkurz/reflecta-rps-7200, protocol.md");
          }};
}

}  // namespace reseau
