#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "core/base/clock.h"
#include "drivers/usb/pcapng_writer.h"
#include "drivers/usb/session_header.h"
#include "drivers/usb/usb_descriptors.h"
#include "drivers/usb/usb_transport.h"

namespace reseau {

// Keeps every transfer of another transport in a pcapng file: submissions and completions, failed
// ones with their status, phases as comments. When the file cannot be continued the next transfer
// throws std::system_error once; after that the unit can still be used, unrecorded. Thread-bound;
// borrows the clock.
class RecordingTransport final : public UsbTransport {
 public:
  // Throws std::system_error when the file exists or cannot be written.
  RecordingTransport(std::unique_ptr<UsbTransport> inner, Clock& clock,
                     const std::filesystem::path& path, const SessionHeader& header);

  [[nodiscard]] const UsbIdentity& identity() const override { return inner_->identity(); }
  void bulk_out(Endpoint endpoint, std::span<const std::byte> data, Duration timeout) override;
  std::size_t bulk_in(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) override;
  void control_out(const ControlRequest& request, std::span<const std::byte> data,
                   Duration timeout) override;
  std::size_t control_in(const ControlRequest& request, std::span<std::byte> buffer,
                         Duration timeout) override;
  void clear_halt(Endpoint endpoint) override;
  void reset() override;
  void annotate(std::string_view phase) override;

 private:
  void submit(UsbPacket& packet);
  void complete(UsbPacket packet, int status, ByteView data, std::size_t length);
  void write(const UsbPacket& packet);
  void report_failure();
  [[nodiscard]] std::int64_t now_us() const;

  std::unique_ptr<UsbTransport> inner_;
  Clock& clock_;
  TimePoint clock_start_;
  std::int64_t start_us_;
  PcapngWriter writer_;
  std::exception_ptr failure_;
  bool recording_ = true;
  std::uint64_t next_id_ = 1;
  std::string phase_;
};

}  // namespace reseau
