#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "drivers/recording/exchange.h"
#include "drivers/recording/rewrite.h"
#include "drivers/usb/pcapng_writer.h"
#include "drivers/usb/usb_descriptors.h"

namespace reseau {
namespace {

constexpr Endpoint kBulkOut = 0x01, kBulkIn = 0x82;
// The time that nothing in the file tells; transfers follow each other by this much.
constexpr std::int64_t kStepUs = 1000;

Bytes bytes_of_hex(const std::string& hex) {
  Bytes bytes;
  if (hex.size() % 2 != 0) throw InputError("A field has an odd number of hexadecimal digits.");
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    std::size_t used = 0;
    const std::string pair = hex.substr(i, 2);
    const int value = pair.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos
                          ? std::stoi(pair, &used, 16)
                          : -1;
    if (value < 0) throw InputError("A field has a character that is no hexadecimal digit.");
    bytes.push_back(std::byte(value));
  }
  return bytes;
}

class TransferWriter {
 public:
  explicit TransferWriter(PcapngWriter& writer) : writer_(writer) {}

  void identity(const UsbIdentity& identity) {
    for (const ControlExchange& exchange : describe_identity(identity)) {
      UsbPacket packet;
      packet.type = UsbTransferType::kControl;
      packet.endpoint = 0x80;
      packet.setup = exchange.setup;
      write(packet, {}, exchange.data, exchange.data.size());
    }
  }
  void out(ByteView data) {
    UsbPacket packet;
    packet.endpoint = kBulkOut;
    write(packet, data, {}, data.size());
  }
  void in(ByteView data, std::size_t n_bytes) {
    UsbPacket packet;
    packet.endpoint = kBulkIn;
    write(packet, {}, data, n_bytes);
  }

 private:
  void write(UsbPacket packet, ByteView sent, ByteView received, std::size_t n_bytes) {
    packet.id = ++id_;
    packet.time_us = time_us_ += kStepUs;
    packet.length = static_cast<std::uint32_t>(n_bytes);
    packet.data.assign(sent.begin(), sent.end());
    writer_.write(packet);
    packet.submission = false;
    packet.setup.reset();
    packet.data.assign(received.begin(), received.end());
    writer_.write(packet);
  }

  PcapngWriter& writer_;
  std::uint64_t id_ = 0;
  std::int64_t time_us_ = 0;
};

void write_command(const nlohmann::json& json, TransferWriter& to) {
  const Bytes cdb = bytes_of_hex(json.at("cdb").get<std::string>());
  if (cdb.size() != 6 && cdb.size() != 10) {
    throw InputError("A command is neither 6 nor 10 bytes long.");
  }
  to.out(cdb);
  const std::byte query{0xD0};
  to.out({&query, 1});
  const int phase = json.at("expected_phase").get<int>();
  const std::byte phase_byte{static_cast<std::uint8_t>(phase)};
  to.in({&phase_byte, 1}, 1);
  if (phase == Exchange::kPhaseOut) to.out(bytes_of_hex(json.value("data_out", "")));
  if (phase == Exchange::kPhaseIn) {
    const Bytes data = bytes_of_hex(json.value("expected_data_in", ""));
    const auto came = json.value("pcap_original_n_in", std::size_t{0});
    to.in(data, std::max(came, data.size()));
  }
  Bytes status = bytes_of_hex(json.value("expected_status", ""));
  status.resize(Exchange::kStatusBytes);
  to.in(status, Exchange::kStatusBytes);
}

}  // namespace

int import_command_lines(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::ifstream file(from);
  if (!file) {
    throw std::system_error(errno != 0 ? errno : ENOENT, std::generic_category(),
                            "The recording " + from.string() + " cannot be opened");
  }
  PcapngWriter writer(to, "converted from " + from.filename().string());
  TransferWriter transfers(writer);
  UsbIdentity identity;
  // UNVERIFIED(the file names no unit): its commands are those of an LS-5000.
  identity.vendor_id = 0x04B0;
  identity.product_id = 0x4002;
  transfers.identity(identity);
  int n = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.empty()) continue;
    try {
      write_command(nlohmann::json::parse(line), transfers);
    } catch (const nlohmann::json::exception& error) {
      throw InputError("Line " + std::to_string(n + 1) + " of " + from.string() +
                       " is no command of a recorded session: " + error.what());
    } catch (const InputError& error) {
      throw InputError("Line " + std::to_string(n + 1) + " of " + from.string() + ": " +
                       error.what());
    }
    ++n;
  }
  return n;
}

}  // namespace reseau
