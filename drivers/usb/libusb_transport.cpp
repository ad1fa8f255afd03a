#include "drivers/usb/libusb_transport.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <libusb.h>

#include "core/base/check.h"
#include "drivers/usb/libusb_flights.h"
#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

// One URB as usbfs takes it whole and as a recording can be replayed by other tools.
constexpr std::size_t kMaxTransferBytes = 128 * 1024;
constexpr int kInterface = 0;

struct ContextDeleter {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
using Context = std::unique_ptr<libusb_context, ContextDeleter>;

struct HandleDeleter {
  void operator()(libusb_device_handle* handle) const { libusb_close(handle); }
};
using Handle = std::unique_ptr<libusb_device_handle, HandleDeleter>;

Context make_context() {
  libusb_context* raw = nullptr;
  if (libusb_init(&raw) != 0) return nullptr;
  return Context(raw);
}

std::string node_of(libusb_device* device) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "/dev/bus/usb/%03u/%03u",
                unsigned{libusb_get_bus_number(device)},
                unsigned{libusb_get_device_address(device)});
  return text.data();
}

// The kernel's copy of the serial string, which needs no permission on the device node.
std::string serial_of(libusb_device* device) {
  std::array<std::uint8_t, 8> ports{};
  const int n = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  if (n <= 0) return {};
  std::string name = std::to_string(unsigned{libusb_get_bus_number(device)});
  for (int i = 0; i < n; ++i) {
    name += i == 0 ? '-' : '.';
    name += std::to_string(unsigned{ports[static_cast<std::size_t>(i)]});
  }
  std::string serial;
  std::ifstream file("/sys/bus/usb/devices/" + name + "/serial");
  std::getline(file, serial);
  return serial;
}

std::string speed_of(libusb_device* device) {
  switch (libusb_get_device_speed(device)) {
    case LIBUSB_SPEED_LOW:
    case LIBUSB_SPEED_FULL:
      return "USB, full speed";
    case LIBUSB_SPEED_HIGH:
      return "USB, high speed";
    default:
      return "USB";
  }
}

template <typename Visit>
void for_each_device(libusb_context* context, Visit visit) {
  libusb_device** list = nullptr;
  const ssize_t n = libusb_get_device_list(context, &list);
  for (ssize_t i = 0; i < n; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) == 0) visit(list[i], descriptor);
  }
  if (n >= 0) libusb_free_device_list(list, 1);
}

[[noreturn]] void throw_open_error(int code, const std::string& node) {
  const std::string detail = node + ": " + libusb_error_name(code);
  if (code == LIBUSB_ERROR_ACCESS) {
    throw std::system_error(
        EACCES, std::generic_category(),
        "The scanner is plugged in, but you may not use " + node +
            ". Install the udev rule 60-reseau.rules (it comes with the program), then unplug the "
            "scanner and plug it in again; `reseau doctor` shows the commands");
  }
  if (code == LIBUSB_ERROR_BUSY) {
    throw DeviceError(DeviceError::Kind::kBusy,
                      "Another program is using the scanner. Close it and try again; `reseau "
                      "doctor` tells which program it is.",
                      detail);
  }
  if (code == LIBUSB_ERROR_NO_DEVICE) throw transfer_error(ENODEV, 0, 0);
  throw DeviceError(DeviceError::Kind::kProtocol,
                    "The scanner cannot be opened. Switch it off and on, then try again.", detail);
}

// A claimed interface 0. Thread-bound.
class LibusbTransport final : public UsbTransport {
 public:
  LibusbTransport(Context context, Handle handle, UsbIdentity identity)
      : context_(std::move(context)),
        handle_(std::move(handle)),
        identity_(std::move(identity)),
        flights_(context_.get(), handle_.get()) {}
  ~LibusbTransport() override { libusb_release_interface(handle_.get(), kInterface); }
  LibusbTransport(const LibusbTransport&) = delete;
  LibusbTransport& operator=(const LibusbTransport&) = delete;

  [[nodiscard]] const UsbIdentity& identity() const override { return identity_; }

  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override {
    while (!data.empty()) {
      const auto part = data.first(std::min(data.size(), kMaxTransferBytes));
      // libusb takes a pointer to non-const for both directions and does not write for OUT.
      auto* const bytes =
          const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(part.data()));
      int done = 0;
      const int code =
          libusb_bulk_transfer(handle_.get(), endpoint, bytes, static_cast<int>(part.size()), &done,
                               libusb_milliseconds(timeout));
      if (code != 0) throw transfer_error(errno_of_libusb(code), endpoint, part.size());
      data = data.subspan(static_cast<std::size_t>(done));
    }
  }

  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override {
    // Anything but whole packets lets a full packet overflow the buffer.
    CHECK(!buffer.empty() &&
          buffer.size() % static_cast<std::size_t>(identity_.max_packet_bytes) == 0);
    if (const auto kept = flights_.take_kept(endpoint, buffer)) return *kept;
    return flights_.read(endpoint, buffer.first(std::min(buffer.size(), kMaxTransferBytes)),
                         timeout);
  }

  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override {
    // Not written to for OUT.
    auto* const bytes =
        const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(data.data()));
    if (control(request, bytes, data.size(), timeout) != data.size()) {
      throw transfer_error(EPROTO, kControlOut, data.size());
    }
  }

  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override {
    return control(request, reinterpret_cast<unsigned char*>(buffer.data()), buffer.size(),
                   timeout);
  }

  void clear_halt(Endpoint endpoint) override {
    const int code = libusb_clear_halt(handle_.get(), endpoint);
    if (code != 0) throw transfer_error(errno_of_libusb(code), endpoint, 0);
  }

  void reset() override {
    flights_.forget();
    const int code = libusb_reset_device(handle_.get());
    if (code == LIBUSB_ERROR_NOT_FOUND) throw transfer_error(ENODEV, 0, 0);
    if (code != 0) throw transfer_error(errno_of_libusb(code), 0, 0);
  }

 private:
  std::size_t control(const ControlRequest& request, unsigned char* bytes, std::size_t size,
                      Duration timeout) {
    CHECK(size <= 0xFFFF);
    const int code = libusb_control_transfer(
        handle_.get(), request.type, request.request, request.value, request.index, bytes,
        static_cast<std::uint16_t>(size), libusb_milliseconds(timeout));
    if (code >= 0) return static_cast<std::size_t>(code);
    throw transfer_error(errno_of_libusb(code), request.type & 0x80, size);
  }

  Context context_;
  Handle handle_;
  UsbIdentity identity_;
  BulkFlights flights_;
};

struct ConfigDeleter {
  void operator()(libusb_config_descriptor* config) const { libusb_free_config_descriptor(config); }
};

// Address and packet size of the first bulk IN endpoint of interface 0.
void learn_bulk_in(libusb_device* device, UsbIdentity& identity) {
  libusb_config_descriptor* raw = nullptr;
  int code = libusb_get_active_config_descriptor(device, &raw);
  if (code != 0) code = libusb_get_config_descriptor(device, 0, &raw);
  if (code != 0) return;
  const std::unique_ptr<libusb_config_descriptor, ConfigDeleter> config(raw);
  if (config->bNumInterfaces < 1 || config->interface[0].num_altsetting < 1) return;
  const libusb_interface_descriptor& interface = config->interface[0].altsetting[0];
  for (int i = 0; i < interface.bNumEndpoints; ++i) {
    const libusb_endpoint_descriptor& endpoint = interface.endpoint[i];
    const bool in = (endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0;
    if (!in || (endpoint.bmAttributes & 3) != LIBUSB_TRANSFER_TYPE_BULK) continue;
    identity.bulk_in = endpoint.bEndpointAddress;
    identity.max_packet_bytes = libusb_get_max_packet_size(device, endpoint.bEndpointAddress);
    if (identity.max_packet_bytes <= 0) identity.max_packet_bytes = 512;
    return;
  }
}

}  // namespace

std::vector<UsbDeviceInfo> list_usb_devices(std::uint16_t vendor_id) {
  std::vector<UsbDeviceInfo> found;
  const Context context = make_context();
  if (context == nullptr) return found;
  for_each_device(context.get(), [&](libusb_device* device, const libusb_device_descriptor& d) {
    if (d.idVendor != vendor_id) return;
    found.push_back(
        {d.idVendor, d.idProduct, serial_of(device), node_of(device), speed_of(device)});
  });
  return found;
}

std::unique_ptr<UsbTransport> open_libusb(std::uint16_t vendor_id, std::uint16_t product_id,
                                          const std::string& serial) {
  Context context = make_context();
  if (context == nullptr) {
    throw std::system_error(ENODEV, std::generic_category(),
                            "The USB bus of this computer cannot be used");
  }
  Handle handle;
  UsbIdentity identity;
  int code = LIBUSB_ERROR_NOT_FOUND;
  std::string node;
  for_each_device(context.get(), [&](libusb_device* device, const libusb_device_descriptor& d) {
    if (handle != nullptr || d.idVendor != vendor_id || d.idProduct != product_id) return;
    const std::string this_serial = serial_of(device);
    if (!serial.empty() && this_serial != serial) return;
    node = node_of(device);
    libusb_device_handle* raw = nullptr;
    code = libusb_open(device, &raw);
    if (code != 0) return;
    handle.reset(raw);
    identity = {d.idVendor, d.idProduct, this_serial, d.bcdDevice};
    learn_bulk_in(device, identity);
  });
  if (handle == nullptr && code == LIBUSB_ERROR_NOT_FOUND) {
    throw DeviceError(DeviceError::Kind::kDisconnected,
                      "No such scanner is connected. Plug it in, switch it on and wait until its "
                      "lamp stops blinking; `reseau list` shows what is there.",
                      "usb " + std::to_string(vendor_id) + ":" + std::to_string(product_id) +
                          (serial.empty() ? "" : ":" + serial));
  }
  if (handle == nullptr) throw_open_error(code, node);

  int configuration = 0;
  code = libusb_get_configuration(handle.get(), &configuration);
  if (code == 0 && configuration == 0) code = libusb_set_configuration(handle.get(), 1);
  if (code == 0) code = libusb_claim_interface(handle.get(), kInterface);
  if (code != 0) throw_open_error(code, node);
  return std::make_unique<LibusbTransport>(std::move(context), std::move(handle),
                                           std::move(identity));
}

}  // namespace reseau
