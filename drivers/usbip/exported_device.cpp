#include "drivers/usbip/exported_device.h"

#include <algorithm>
#include <cerrno>
#include <span>
#include <utility>

#include "core/base/error.h"

namespace reseau::usbip {
namespace {

constexpr std::uint8_t kIn = 0x80;
constexpr std::uint8_t kTypeBits = 0x60, kVendorType = 0x40;
constexpr std::uint32_t kShortNotOk = 0x0001;  // transfer flag of the Linux kernel
constexpr std::size_t kMaxWaiting = 1024;
// A clock that a client cannot see is no use: an IN transfer waits until the client gives up.
constexpr Duration kTimeout = std::chrono::milliseconds(1);

// Requests and recipients of chapter 9.
enum Standard : std::uint8_t {
  kGetStatus = 0,
  kClearFeature = 1,
  kSetFeature = 3,
  kSetAddress = 5,
  kGetDescriptor = 6,
  kGetConfiguration = 8,
  kSetConfiguration = 9,
  kGetInterface = 10,
  kSetInterface = 11,
};
constexpr std::uint8_t kToDevice = 0, kToInterface = 1, kToEndpoint = 2;

Completion completion_of(const SubmitRequest& request, std::int32_t status, std::uint32_t moved) {
  Completion done;
  done.sequence = request.sequence;
  done.status = status;
  done.moved_bytes = moved;
  done.n_packets = request.n_packets;
  return done;
}

}  // namespace

ExportedDevice::ExportedDevice(DeviceDescription description, UsbTransport& unit)
    : description_(std::move(description)), unit_(unit) {}

DeviceSummary ExportedDevice::summary() const {
  DeviceSummary summary;
  summary.path = "/sys/devices/reseau/usb1/1-1";
  summary.bus_id = "1-1";
  summary.speed = description_.high_speed ? 3 : 2;
  summary.vendor_id = description_.vendor_id;
  summary.product_id = description_.product_id;
  summary.bcd_device = description_.bcd_device;
  return summary;
}

bool ExportedDevice::has_endpoint(std::uint16_t address) const {
  return std::any_of(description_.endpoints.begin(), description_.endpoints.end(),
                     [&](const EndpointDescription& e) { return e.address == address; });
}

void ExportedDevice::submit(SubmitRequest request, std::vector<Completion>& done) {
  const DeviceSummary me = summary();
  const auto address = static_cast<std::uint8_t>(request.endpoint | (request.in ? kIn : 0));
  if (gone_ || request.device_id != (me.bus << 16 | me.device)) {
    done.push_back(completion_of(request, -ENODEV, 0));
  } else if (request.endpoint == 0) {
    control(request, done);
  } else if (configuration_ == 0 || !has_endpoint(address)) {
    done.push_back(completion_of(request, -EPIPE, 0));
  } else if (halted_.contains(address)) {
    done.push_back(completion_of(request, -EPIPE, 0));
  } else if (!request.in) {
    bulk_out(request, done);
  } else if (waiting_.size() >= kMaxWaiting) {
    done.push_back(completion_of(request, -ENOMEM, 0));
  } else {
    waiting_.push_back({request.sequence, address, request.length, request.flags, request.n_packets,
                        false, false});
  }
  serve(done);
}

Completion ExportedDevice::unlink(const UnlinkRequest& request) {
  Completion done;
  done.unlink = true;
  done.sequence = request.sequence;
  const auto found = std::find_if(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
    return w.sequence == request.unlink_sequence;
  });
  if (found == waiting_.end()) return done;  // it ended before; its own reply is on its way
  waiting_.erase(found);
  asked_in_vain_ = false;
  done.status = -ECONNRESET;
  return done;
}

void ExportedDevice::detach() {
  waiting_.clear();
  halted_.clear();
  configuration_ = 1;
  if (!gone_) static_cast<void>(reset_unit());
}

bool ExportedDevice::reset_unit() {
  asked_in_vain_ = false;
  try {
    if (description_.bears_reset) unit_.reset();
    for (const EndpointDescription& endpoint : description_.endpoints) {
      if (!description_.bears_reset) unit_.clear_halt(endpoint.address);
    }
  } catch (const DeviceError& error) {
    gone_ = gone_ || error.kind() == DeviceError::Kind::kDisconnected;
  }
  return !gone_;
}

void ExportedDevice::bulk_out(const SubmitRequest& request, std::vector<Completion>& done) {
  for (Waiting& waiting : waiting_) waiting.held = false;
  const auto address = static_cast<std::uint8_t>(request.endpoint);
  try {
    unit_.bulk_out(address, request.data, kTimeout);
    asked_in_vain_ = false;
    done.push_back(completion_of(request, 0, request.length));
  } catch (const DeviceError& error) {
    switch (error.kind()) {
      case DeviceError::Kind::kTimeout:
        if (waiting_.size() < kMaxWaiting) {
          waiting_.push_back({request.sequence, address, 0, 0, request.n_packets, true, false});
        }
        return;
      case DeviceError::Kind::kStall:
        halted_.insert(address);
        done.push_back(completion_of(request, -EPIPE, 0));
        return;
      case DeviceError::Kind::kDisconnected:
        gone_ = true;
        done.push_back(completion_of(request, -ENODEV, 0));
        return;
      default:
        done.push_back(completion_of(request, -EPROTO, 0));
    }
  }
}

void ExportedDevice::serve(std::vector<Completion>& done) {
  for (std::size_t i = 0; i < waiting_.size();) {
    const Waiting& next = waiting_[i];
    const bool halted = halted_.contains(next.address);
    if (gone_ || halted) {
      Completion failed;
      failed.sequence = next.sequence;
      failed.status = gone_ ? -ENODEV : -EPIPE;
      failed.n_packets = next.n_packets;
      done.push_back(std::move(failed));
    } else if (next.stuck || next.held || asked_in_vain_ || !serve_one(i, done)) {
      ++i;
      continue;
    }
    waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

bool ExportedDevice::serve_one(std::size_t index, std::vector<Completion>& done) {
  const Waiting request = waiting_[index];
  for (const EndpointDescription& endpoint : description_.endpoints) {
    // Described for the family, never used.
    if (endpoint.address == request.address && endpoint.interrupt) return false;
  }
  Completion ended;
  ended.sequence = request.sequence;
  ended.n_packets = request.n_packets;
  if (buffer_.size() < request.length) buffer_.resize(request.length);
  try {
    const std::size_t n =
        unit_.bulk_in(request.address, std::span(buffer_).first(request.length), kTimeout);
    ended.moved_bytes = static_cast<std::uint32_t>(n);
    ended.data.assign(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(n));
    if (n < request.length && (request.flags & kShortNotOk) != 0) {
      // What was submitted behind it belongs to the same wish of the host, which takes it back.
      ended.status = -EREMOTEIO;
      for (Waiting& behind : waiting_) behind.held |= behind.address == request.address;
    }
  } catch (const DeviceError& error) {
    switch (error.kind()) {
      case DeviceError::Kind::kTimeout:
        asked_in_vain_ = true;
        return false;
      case DeviceError::Kind::kStall:
        halted_.insert(request.address);
        ended.status = -EPIPE;
        break;
      case DeviceError::Kind::kDisconnected:
        gone_ = true;
        ended.status = -ENODEV;
        break;
      default:
        ended.status = -EOVERFLOW;
    }
  }
  done.push_back(std::move(ended));
  return true;
}

void ExportedDevice::control(const SubmitRequest& request, std::vector<Completion>& done) {
  const bool in = (u8_at(request.setup, 0) & kIn) != 0;
  const auto asked = static_cast<std::uint32_t>(load_le(request.setup, 6, 2));
  const std::uint8_t type = u8_at(request.setup, 0) & kTypeBits;
  // A request without data has no direction of its own.
  const bool fits = asked == 0 || in == request.in;
  if (fits && type == kVendorType) return vendor(request, done);
  done.push_back(fits && type == 0 ? standard(request) : completion_of(request, -EPIPE, 0));
}

Completion ExportedDevice::standard(const SubmitRequest& request) {
  const bool in = (u8_at(request.setup, 0) & kIn) != 0;
  const std::size_t asked = load_le(request.setup, 6, 2);
  Bytes reply;
  const std::int32_t status = standard(request.setup, reply);
  if (status != 0) return completion_of(request, status, 0);
  if (!in) return completion_of(request, 0, static_cast<std::uint32_t>(request.data.size()));
  reply.resize(std::min<std::size_t>({reply.size(), asked, request.length}));
  Completion done = completion_of(request, 0, static_cast<std::uint32_t>(reply.size()));
  done.data = std::move(reply);
  return done;
}

void ExportedDevice::vendor(const SubmitRequest& request, std::vector<Completion>& done) {
  const ControlRequest asked{u8_at(request.setup, 0), u8_at(request.setup, 1),
                             static_cast<std::uint16_t>(load_le(request.setup, 2, 2)),
                             static_cast<std::uint16_t>(load_le(request.setup, 4, 2))};
  asked_in_vain_ = false;
  try {
    if ((asked.type & kIn) == 0) {
      unit_.control_out(asked, request.data, kTimeout);
      done.push_back(completion_of(request, 0, static_cast<std::uint32_t>(request.data.size())));
      return;
    }
    Bytes reply(std::min<std::size_t>(load_le(request.setup, 6, 2), request.length));
    reply.resize(unit_.control_in(asked, reply, kTimeout));
    Completion answered = completion_of(request, 0, static_cast<std::uint32_t>(reply.size()));
    answered.data = std::move(reply);
    done.push_back(std::move(answered));
  } catch (const DeviceError& error) {
    if (error.kind() == DeviceError::Kind::kTimeout && waiting_.size() < kMaxWaiting) {
      // Until the client gives up.
      waiting_.push_back({request.sequence, 0, 0, 0, request.n_packets, true, false});
      return;
    }
    gone_ = gone_ || error.kind() == DeviceError::Kind::kDisconnected;
    // A stall of endpoint 0 ends with the next request.
    done.push_back(completion_of(request, gone_ ? -ENODEV : -EPIPE, 0));
  }
}

std::int32_t ExportedDevice::standard(ByteView setup, Bytes& reply) {
  const bool in = (u8_at(setup, 0) & kIn) != 0;
  const std::uint8_t recipient = u8_at(setup, 0) & 0x1F;
  const std::uint8_t request = u8_at(setup, 1);
  const auto value = static_cast<std::uint16_t>(load_le(setup, 2, 2));
  const auto index = static_cast<std::uint16_t>(load_le(setup, 4, 2));
  const auto key = [](bool data_in, std::uint8_t to, std::uint8_t what) {
    return (data_in ? 0x10000 : 0) | to << 8 | what;
  };
  switch (key(in, recipient, request)) {
    case key(true, kToDevice, kGetStatus):
    case key(true, kToInterface, kGetStatus):
    case key(true, kToEndpoint, kGetStatus):
      return value == 0 ? get_status(recipient, index, reply) : -EPIPE;
    case key(false, kToEndpoint, kClearFeature):
    case key(false, kToEndpoint, kSetFeature):
      return value == 0 ? set_halt(index, request == kSetFeature) : -EPIPE;
    case key(false, kToDevice, kSetAddress):
      return value <= 127 ? 0 : -EPIPE;
    case key(true, kToDevice, kGetDescriptor): {
      auto found = descriptor(description_, static_cast<std::uint8_t>(value >> 8),
                              static_cast<std::uint8_t>(value & 0xFF));
      if (!found) return -EPIPE;
      reply = *std::move(found);
      return 0;
    }
    case key(true, kToDevice, kGetConfiguration):
      append_le(reply, 1, configuration_);
      return 0;
    case key(false, kToDevice, kSetConfiguration):
      if (value > 1) return -EPIPE;
      // Endpoints start anew; what waited on them ends with the next look at it.
      halted_.clear();
      configuration_ = static_cast<std::uint8_t>(value);
      return reset_unit() ? 0 : -ENODEV;
    case key(true, kToInterface, kGetInterface):
      if (index != 0 || configuration_ == 0) return -EPIPE;
      append_le(reply, 1, 0);
      return 0;
    case key(false, kToInterface, kSetInterface):
      return index == 0 && value == 0 && configuration_ != 0 ? 0 : -EPIPE;
    default:
      // SET_DESCRIPTOR and SYNCH_FRAME among them; no test mode, no remote wake-up.
      return -EPIPE;
  }
}

std::int32_t ExportedDevice::get_status(std::uint8_t recipient, std::uint16_t index, Bytes& reply) {
  if (recipient == kToEndpoint) {
    const bool control_endpoint = (index & 0x7F) == 0;
    if (!control_endpoint && (configuration_ == 0 || !has_endpoint(index))) return -EPIPE;
    append_le(reply, 2, halted_.contains(static_cast<std::uint8_t>(index)) ? 1 : 0);
    return 0;
  }
  if (index != 0 || (recipient == kToInterface && configuration_ == 0)) return -EPIPE;
  append_le(reply, 2, recipient == kToDevice && (description_.attributes & 0x40) != 0 ? 1 : 0);
  return 0;
}

std::int32_t ExportedDevice::set_halt(std::uint16_t index, bool halted) {
  if ((index & 0x7F) == 0) return 0;
  if (configuration_ == 0 || !has_endpoint(index)) return -EPIPE;
  const auto address = static_cast<std::uint8_t>(index);
  if (halted) {
    halted_.insert(address);
    return 0;
  }
  halted_.erase(address);
  asked_in_vain_ = false;
  try {
    unit_.clear_halt(address);
  } catch (const DeviceError& error) {
    gone_ = gone_ || error.kind() == DeviceError::Kind::kDisconnected;
    return gone_ ? -ENODEV : -EPIPE;
  }
  return 0;
}

}  // namespace reseau::usbip
