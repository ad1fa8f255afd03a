#include "drivers/export_unit.h"

#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "drivers/coolscan/models.h"
#include "drivers/families.h"
#include "drivers/pieusb/models.h"
#include "drivers/sim/simulated_unit.h"
#include "drivers/usbip/exported_device.h"
#include "drivers/usbip/listen_socket.h"
#include "drivers/usbip/server.h"

namespace reseau {
namespace {

constexpr int kHighSpeedPacket = 512;

usbip::DeviceDescription plain_description(const UsbIdentity& identity) {
  usbip::DeviceDescription device;
  device.vendor_id = identity.vendor_id;
  device.product_id = identity.product_id;
  device.bcd_device = identity.bcd_device;
  device.high_speed = identity.max_packet_bytes >= kHighSpeedPacket;
  device.bcd_usb = device.high_speed ? 0x0200 : 0x0110;
  device.serial = identity.serial;
  return device;
}

// LS-5000 interface specification, USB descriptors; LS-50 and LS-40 firmware.
usbip::DeviceDescription coolscan_description(const UsbIdentity& identity) {
  constexpr std::uint16_t kLs40 = 0x4000, kLs50 = 0x4001;
  usbip::DeviceDescription device = plain_description(identity);
  device.manufacturer = "Nikon";
  const coolscan::Model* const model =
      coolscan::model_by_usb_id(identity.vendor_id, identity.product_id);
  device.product = model == nullptr ? "Scanner" : std::string(model->product);
  device.endpoints = {{0x01, false, 0, 0}, {0x82, false, 0, 0}};
  // The LS-50's descriptor has a serial; which one a real unit has says nothing about this one.
  if (identity.product_id == kLs50 && device.serial.empty()) device.serial = "SIM00001";
  if (identity.product_id == kLs40) {
    device.control_packet_bytes = 8;
    device.endpoints.push_back({0x83, true, 8, 0xC8});
  }
  return device;
}

// A bridge of Genesys Logic (SANE's pieusb backend). Its strings are not known.
usbip::DeviceDescription pie_description(const UsbIdentity& identity) {
  usbip::DeviceDescription device = plain_description(identity);
  device.endpoints = {{identity.bulk_in, false, 0, 0}};
  device.bears_reset = false;
  return device;
}

usbip::DeviceDescription description_of(const UsbIdentity& identity) {
  return identity.vendor_id == pieusb::kGenesysVendorId ? pie_description(identity)
                                                        : coolscan_description(identity);
}

std::string name_of(const UsbIdentity& identity, const usbip::DeviceDescription& device) {
  return device.product.empty() ? trade_name_of(identity.vendor_id, identity.product_id)
                                : device.manufacturer + " " + device.product;
}

}  // namespace

void export_unit(const ExportOptions& options, const ExportTalk& talk,
                 const std::stop_token& stop) {
  const sim::SimSpec spec = sim::parse_sim_spec(options.device_name);
  if (sim::is_scsi_model(spec)) {
    throw InputError(
        "This model has no USB: it is a unit of FireWire or SCSI. Export ls40, ls50, ls5000 or one "
        "of the Reflecta and Braun models.");
  }
  const std::unique_ptr<UsbTransport> unit = sim::open_simulated_unit(spec);
  usbip::ExportedDevice device(description_of(unit->identity()), *unit);
  const usbip::ListenSocket listener(options.listen);
  if (listener.open_to_others()) {
    talk.note("Other computers can reach " + listener.address() +
              ", and nobody is asked for a password.");
  }
  talk.ready(listener.address(), name_of(unit->identity(), device.description()));
  usbip::serve(listener, device, stop, talk.note);
}

}  // namespace reseau
