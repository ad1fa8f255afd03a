#include "drivers/usb/usb_descriptors.h"

#include <algorithm>

namespace reseau {
namespace {

// USB 2.0 specification, chapter 9.
constexpr int kDevice = 1, kConfiguration = 2, kString = 3, kEndpointDescriptor = 5;
constexpr int kSerialIndex = 3;
constexpr int kBulk = 2;

UsbSetup setup_of(const Bytes& bytes) {
  UsbSetup setup{};
  std::copy_n(bytes.begin(), setup.size(), setup.begin());
  return setup;
}

ControlExchange get_descriptor(int type, int index, Bytes data) {
  const int language = type == kString ? 0x0409 : 0;
  const int n = static_cast<int>(data.size());
  return {setup_of(bytes_of(
              {0x80, 0x06, index, type, language & 0xFF, language >> 8, n & 0xFF, n >> 8})),
          std::move(data)};
}

}  // namespace

std::vector<ControlExchange> describe_identity(const UsbIdentity& identity) {
  const auto low = [](int value) { return value & 0xFF; };
  const auto high = [](int value) { return value >> 8 & 0xFF; };
  const int packet = identity.max_packet_bytes;
  std::vector<ControlExchange> exchanges;
  exchanges.push_back(get_descriptor(
      kDevice, 0,
      bytes_of({18, kDevice, 0x00, packet >= 512 ? 0x02 : 0x01, 0xFF, 0xFF, 0xFF, 64,
                low(identity.vendor_id), high(identity.vendor_id), low(identity.product_id),
                high(identity.product_id), low(identity.bcd_device), high(identity.bcd_device), 0,
                0, identity.serial.empty() ? 0 : kSerialIndex, 1})));
  exchanges.push_back(get_descriptor(kConfiguration, 0,
                                     bytes_of({9,
                                               kConfiguration,
                                               32,
                                               0,
                                               1,
                                               1,
                                               0,
                                               0xC0,
                                               1,  //
                                               9,
                                               4,
                                               0,
                                               0,
                                               2,
                                               0xFF,
                                               0xFF,
                                               0xFF,
                                               0,  //
                                               7,
                                               kEndpointDescriptor,
                                               0x01,
                                               kBulk,
                                               low(packet),
                                               high(packet),
                                               0,  //
                                               7,
                                               kEndpointDescriptor,
                                               identity.bulk_in,
                                               kBulk,
                                               low(packet),
                                               high(packet),
                                               0})));
  if (!identity.serial.empty()) {
    constexpr std::size_t kMaxCharacters = 126;
    const std::string serial = identity.serial.substr(0, kMaxCharacters);
    Bytes text = bytes_of({static_cast<int>(2 + 2 * serial.size()), kString});
    for (const char c : serial) append_le(text, 2, static_cast<std::uint8_t>(c));
    exchanges.push_back(get_descriptor(kString, kSerialIndex, std::move(text)));
  }
  return exchanges;
}

void learn_identity(const UsbTransfer& control, UsbIdentity& identity) {
  if (!control.setup || control.status != 0) return;
  const UsbSetup& setup = *control.setup;
  if (u8_at(setup, 0) != 0x80 || u8_at(setup, 1) != 0x06) return;
  const ByteView d = control.data;
  switch (u8_at(setup, 3)) {
    case kDevice:
      if (d.size() < 18) return;
      identity.vendor_id = static_cast<std::uint16_t>(load_le(d, 8, 2));
      identity.product_id = static_cast<std::uint16_t>(load_le(d, 10, 2));
      identity.bcd_device = static_cast<std::uint16_t>(load_le(d, 12, 2));
      return;
    case kConfiguration:
      for (std::size_t at = 0; at + 7 <= d.size();) {
        const std::size_t length = u8_at(d, at);
        if (length < 2) return;
        if (u8_at(d, at + 1) == kEndpointDescriptor && u8_at(d, at + 3) == kBulk) {
          const int bytes = static_cast<int>(load_le(d, at + 4, 2));
          if (bytes == 64 || bytes == 512) identity.max_packet_bytes = bytes;
          if ((u8_at(d, at + 2) & 0x80) != 0) identity.bulk_in = u8_at(d, at + 2);
        }
        at += length;
      }
      return;
    case kString:
      if (u8_at(setup, 2) != kSerialIndex) return;
      identity.serial.clear();
      for (std::size_t i = 2; i + 1 < d.size(); i += 2) {
        identity.serial += static_cast<char>(u8_at(d, i));
      }
      return;
    default:
      return;
  }
}

UsbSetup setup_of_request(const ControlRequest& request, std::size_t n_bytes) {
  CHECK(n_bytes <= 0xFFFF);
  const int n = static_cast<int>(n_bytes);
  return setup_of(bytes_of({request.type, request.request, request.value & 0xFF, request.value >> 8,
                            request.index & 0xFF, request.index >> 8, n & 0xFF, n >> 8}));
}

bool is_vendor_request(const UsbSetup& setup) { return (u8_at(setup, 0) & 0x60) == 0x40; }

UsbSetup clear_halt_setup(Endpoint endpoint) {
  return setup_of(bytes_of({0x02, 0x01, 0, 0, endpoint, 0, 0, 0}));
}

UsbSetup reset_setup() { return setup_of(bytes_of({0x00, 0x09, 1, 0, 0, 0, 0, 0})); }

}  // namespace reseau
