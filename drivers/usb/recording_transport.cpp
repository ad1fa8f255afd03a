#include "drivers/usb/recording_transport.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

std::int64_t wall_clock_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

UsbPacket bulk(Endpoint endpoint, std::size_t length) {
  UsbPacket packet;
  packet.endpoint = endpoint;
  packet.length = static_cast<std::uint32_t>(length);
  return packet;
}

UsbPacket control_packet(const UsbSetup& setup, std::size_t length) {
  UsbPacket packet;
  packet.type = UsbTransferType::kControl;
  packet.endpoint = std::to_integer<std::uint8_t>(setup[0]) & 0x80;
  packet.length = static_cast<std::uint32_t>(length);
  packet.setup = setup;
  return packet;
}

}  // namespace

RecordingTransport::RecordingTransport(std::unique_ptr<UsbTransport> inner, Clock& clock,
                                       const std::filesystem::path& path,
                                       const SessionHeader& header)
    : inner_(std::move(inner)),
      clock_(clock),
      clock_start_(clock.now()),
      start_us_(wall_clock_us()),
      writer_(path, encode_session_header(header)) {
  for (const ControlExchange& exchange : describe_identity(identity())) {
    UsbPacket packet = control_packet(exchange.setup, exchange.data.size());
    submit(packet);
    complete(packet, 0, exchange.data, exchange.data.size());
  }
  report_failure();
}

void RecordingTransport::bulk_out(Endpoint endpoint, std::span<const std::byte> data,
                                  Duration timeout) {
  report_failure();
  UsbPacket packet = bulk(endpoint, data.size());
  packet.data.assign(data.begin(), data.end());
  submit(packet);
  try {
    inner_->bulk_out(endpoint, data, timeout);
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, {}, data.size());
}

std::size_t RecordingTransport::bulk_in(Endpoint endpoint, std::span<std::byte> buffer,
                                        Duration timeout) {
  report_failure();
  UsbPacket packet = bulk(endpoint, buffer.size());
  submit(packet);
  std::size_t n = 0;
  try {
    n = inner_->bulk_in(endpoint, buffer, timeout);
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, buffer.first(n), n);
  return n;
}

void RecordingTransport::control_out(const ControlRequest& request, std::span<const std::byte> data,
                                     Duration timeout) {
  report_failure();
  UsbPacket packet = control_packet(setup_of_request(request, data.size()), data.size());
  packet.data.assign(data.begin(), data.end());
  submit(packet);
  try {
    inner_->control_out(request, data, timeout);
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, {}, data.size());
}

std::size_t RecordingTransport::control_in(const ControlRequest& request,
                                           std::span<std::byte> buffer, Duration timeout) {
  report_failure();
  UsbPacket packet = control_packet(setup_of_request(request, buffer.size()), buffer.size());
  submit(packet);
  std::size_t n = 0;
  try {
    n = inner_->control_in(request, buffer, timeout);
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, buffer.first(n), n);
  return n;
}

void RecordingTransport::clear_halt(Endpoint endpoint) {
  UsbPacket packet = control_packet(clear_halt_setup(endpoint), 0);
  submit(packet);
  try {
    inner_->clear_halt(endpoint);
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, {}, 0);
}

void RecordingTransport::reset() {
  UsbPacket packet = control_packet(reset_setup(), 0);
  submit(packet);
  try {
    inner_->reset();
  } catch (const DeviceError& error) {
    complete(std::move(packet), status_of(error.kind()), {}, 0);
    throw;
  }
  complete(std::move(packet), 0, {}, 0);
}

void RecordingTransport::annotate(std::string_view phase) {
  phase_ = phase;
  inner_->annotate(phase);
}

void RecordingTransport::submit(UsbPacket& packet) {
  packet.id = next_id_++;
  packet.time_us = now_us();
  packet.comment = std::exchange(phase_, {});
  write(packet);
}

void RecordingTransport::complete(UsbPacket packet, int status, ByteView data, std::size_t length) {
  packet.submission = false;
  packet.time_us = now_us();
  packet.status = -status;
  packet.length = static_cast<std::uint32_t>(length);
  packet.setup.reset();
  packet.comment.clear();
  packet.data.assign(data.begin(), data.end());
  write(packet);
}

void RecordingTransport::write(const UsbPacket& packet) {
  if (!recording_) return;
  try {
    writer_.write(packet);
  } catch (const std::system_error&) {
    // Not now: what this transfer moved must reach the caller.
    failure_ = std::current_exception();
    recording_ = false;
  }
}

void RecordingTransport::report_failure() {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

std::int64_t RecordingTransport::now_us() const {
  return start_us_ + (clock_.now() - clock_start_).count();
}

}  // namespace reseau
