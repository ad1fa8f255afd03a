#include "drivers/usb/libusb_flights.h"

#include <algorithm>
#include <cerrno>
#include <utility>

#include <libusb.h>

#include "drivers/usb/usb_error.h"

namespace reseau {
namespace {

int code_of(libusb_transfer_status status) {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return 0;
    case LIBUSB_TRANSFER_TIMED_OUT:
    case LIBUSB_TRANSFER_CANCELLED:
      return LIBUSB_ERROR_TIMEOUT;
    case LIBUSB_TRANSFER_STALL:
      return LIBUSB_ERROR_PIPE;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return LIBUSB_ERROR_NO_DEVICE;
    case LIBUSB_TRANSFER_OVERFLOW:
      return LIBUSB_ERROR_OVERFLOW;
    default:
      return LIBUSB_ERROR_IO;
  }
}

bool is_whole(const libusb_transfer& transfer) {
  return transfer.status == LIBUSB_TRANSFER_COMPLETED && transfer.actual_length == transfer.length;
}

}  // namespace

int errno_of_libusb(int code) {
  switch (code) {
    case LIBUSB_ERROR_TIMEOUT:
      return ETIMEDOUT;
    case LIBUSB_ERROR_PIPE:
      return EPIPE;
    case LIBUSB_ERROR_NO_DEVICE:
      return ENODEV;
    case LIBUSB_ERROR_OVERFLOW:
      return EOVERFLOW;
    default:
      return EPROTO;
  }
}

unsigned libusb_milliseconds(Duration timeout) {
  return static_cast<unsigned>(std::max<Duration::rep>(1, timeout.count() / 1000));
}

void BulkFlights::TransferDeleter::operator()(libusb_transfer* transfer) const {
  libusb_free_transfer(transfer);
}

BulkFlights::BulkFlights(libusb_context* context, libusb_device_handle* handle)
    : context_(context), handle_(handle) {
  for (auto& transfer : transfers_) transfer.reset(libusb_alloc_transfer(0));
}

std::size_t BulkFlights::read(Endpoint endpoint, std::span<std::byte> buffer, Duration timeout) {
  const std::size_t n = std::min((buffer.size() + kFlightBytes - 1) / kFlightBytes, kMaxFlights);
  std::size_t n_started = 0;
  int refused = 0;
  for (; n_started < n; ++n_started) {
    const auto part = buffer.subspan(n_started * kFlightBytes);
    refused = start(n_started, endpoint, part.first(std::min(part.size(), kFlightBytes)), timeout);
    if (refused != 0) break;
  }
  land(n_started);
  std::size_t done = 0;
  for (std::size_t i = 0; i < n_started; ++i) {
    const libusb_transfer& transfer = *transfers_[i];
    done += static_cast<std::size_t>(transfer.actual_length);
    if (is_whole(transfer)) continue;
    keep_from(i + 1, n_started, endpoint);
    const int code = code_of(transfer.status);
    // What came before a timeout is data, not an error.
    if (code == 0 || (code == LIBUSB_ERROR_TIMEOUT && done > 0)) return done;
    throw transfer_error(errno_of_libusb(code), endpoint, buffer.size());
  }
  if (refused != 0) throw transfer_error(errno_of_libusb(refused), endpoint, buffer.size());
  return done;
}

std::optional<std::size_t> BulkFlights::take_kept(Endpoint endpoint, std::span<std::byte> buffer) {
  if (kept_.empty() || kept_.front().endpoint != endpoint) return std::nullopt;
  const Kept piece = std::move(kept_.front());
  kept_.pop_front();
  const std::size_t n = std::min(piece.bytes.size(), buffer.size());
  std::copy_n(piece.bytes.begin(), n, buffer.begin());
  return n;
}

void BulkFlights::ended(libusb_transfer* transfer) noexcept {
  auto& flights = *static_cast<BulkFlights*>(transfer->user_data);
  --flights.n_flying_;
  if (!is_whole(*transfer)) flights.broken_ = 1;
}

// Returns 0 or libusb's code.
int BulkFlights::start(std::size_t i, Endpoint endpoint, std::span<std::byte> part,
                       Duration timeout) {
  libusb_transfer* const transfer = transfers_[i].get();
  if (transfer == nullptr) return LIBUSB_ERROR_NO_MEM;
  libusb_fill_bulk_transfer(
      transfer, handle_, endpoint, reinterpret_cast<unsigned char*>(part.data()),
      static_cast<int>(part.size()), &ended, this, libusb_milliseconds(timeout));
  const int code = libusb_submit_transfer(transfer);
  if (code == 0) ++n_flying_;
  return code;
}

// Waits until none is in flight; each has its own time limit.
void BulkFlights::land(std::size_t n_started) {
  broken_ = 0;
  bool taken_back = false;
  while (n_flying_ > 0) {
    if (broken_ != 0 && !std::exchange(taken_back, true)) {
      for (std::size_t i = n_started; i-- > 0;) libusb_cancel_transfer(transfers_[i].get());
    }
    libusb_handle_events_completed(context_, taken_back ? nullptr : &broken_);
  }
}

void BulkFlights::keep_from(std::size_t first, std::size_t end, Endpoint endpoint) {
  for (std::size_t i = first; i < end; ++i) {
    const auto n = static_cast<std::size_t>(transfers_[i]->actual_length);
    const auto* const bytes = reinterpret_cast<const std::byte*>(transfers_[i]->buffer);
    if (n > 0) kept_.push_back({endpoint, {bytes, bytes + n}});
  }
}

}  // namespace reseau
