// usbip_host ADDRESS PROGRAM [ARGUMENT...]: runs a program that sees the device which a USB/IP
// server exports as 1-1, through its own libusb. The kernel needs no USB: umockdev's preload
// library shows the program a private /sys and /dev, and hands its usbfs requests to the handler
// below, which makes USB/IP transfers of them.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <umockdev.h>
#include <unistd.h>

#include "tests/support/usbip_host/usbip_client.h"

namespace {

using reseau::testing::TransferReply;
using reseau::testing::UsbipClient;
using Setup = std::array<std::uint8_t, 8>;

constexpr const char* kNode = "/dev/bus/usb/001/002";
constexpr int kCannotRun = 97;
// libusb asks again and again for transfers that have ended; each question in vain is kept for so
// long, so that it does not spin.
constexpr std::chrono::milliseconds kHold{2};

// One transfer of the program under way. Synchronous ones are waited for by whoever made them.
struct Flight {
  UMockdevIoctlData* urb = nullptr;     // the program's struct usbdevfs_urb
  UMockdevIoctlData* buffer = nullptr;  // and what it points to
  std::uint8_t* in = nullptr;           // where received bytes go
  std::uint32_t room = 0;
  bool ended = false;
  int status = 0;
  std::uint32_t length = 0;
};

class Host {
 public:
  explicit Host(UsbipClient& client) : client_(client) {}

  void listen() {
    try {
      while (true) take(client_.reply());
    } catch (const std::exception&) {
      const std::lock_guard lock(mutex_);
      gone_ = true;
      for (auto& [sequence, flight] : flights_) land(*flight, -ENODEV, 0);
      flights_.clear();
      changed_.notify_all();
    }
  }

  // Waits for the end of the transfer.
  int run(bool in, std::uint8_t endpoint, std::uint8_t* bytes, std::uint32_t n,
          const Setup& setup) {
    std::unique_lock lock(mutex_);
    if (gone_) return -ENODEV;
    Flight flight;
    flight.in = in ? bytes : nullptr;
    flight.room = n;
    start(flight, in, endpoint, bytes, n, setup);
    changed_.wait(lock, [&] { return flight.ended; });
    return flight.status != 0 ? flight.status : static_cast<int>(flight.length);
  }

  // Returns 0 or the errno of the ioctl.
  int submit(UMockdevIoctlData* argument) {
    UMockdevIoctlData* urb_data =
        umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr);
    auto* urb = reinterpret_cast<usbdevfs_urb*>(urb_data->data);
    const auto n = static_cast<std::uint32_t>(urb->buffer_length);
    auto* flight = new Flight;
    flight->urb = urb_data;
    if (n > 0) {
      flight->buffer =
          umockdev_ioctl_data_resolve(urb_data, offsetof(usbdevfs_urb, buffer), n, nullptr);
    }
    std::uint8_t* bytes = flight->buffer == nullptr ? nullptr : flight->buffer->data;
    const std::lock_guard lock(mutex_);
    if (gone_) return ENODEV;
    Setup setup{};
    if (urb->type == USBDEVFS_URB_TYPE_CONTROL) {
      std::copy_n(bytes, setup.size(), setup.begin());
      const bool in = (setup[0] & 0x80) != 0;
      flight->in = in ? bytes + 8 : nullptr;
      flight->room = n - 8;
      start(*flight, in, 0, bytes + 8, n - 8, setup);
    } else {
      const bool in = (urb->endpoint & 0x80) != 0;
      flight->in = in ? bytes : nullptr;
      flight->room = n;
      start(*flight, in, urb->endpoint & 0x0F, bytes, n, setup);
    }
    return 0;
  }

  int discard(unsigned long address) {
    const std::lock_guard lock(mutex_);
    for (const auto& [sequence, flight] : flights_) {
      if (flight->urb == nullptr || flight->urb->client_addr != address) continue;
      unlinks_[++next_] = sequence;
      client_.unlink(next_, sequence);
      return 0;
    }
    return EINVAL;
  }

  // Attaches an ended transfer to the argument; false when there is none.
  bool reap(UMockdevIoctlData* pointer, bool wait_for_it) {
    std::unique_lock lock(mutex_);
    const auto some = [this] { return !ended_.empty(); };
    if (wait_for_it) {
      changed_.wait(lock, some);
    } else if (!some() && asked_in_vain_) {
      changed_.wait_for(lock, kHold, some);
    }
    asked_in_vain_ = ended_.empty();
    if (asked_in_vain_) return false;
    Flight* flight = ended_.front();
    ended_.pop_front();
    umockdev_ioctl_data_set_ptr(pointer, 0, flight->urb);
    g_object_unref(flight->urb);
    if (flight->buffer != nullptr) g_object_unref(flight->buffer);
    delete flight;
    return true;
  }

  // The program closed the device: what is under way is taken back.
  void closed() {
    const std::lock_guard lock(mutex_);
    for (const auto& [sequence, flight] : flights_) {
      unlinks_[++next_] = sequence;
      if (!gone_) client_.unlink(next_, sequence);
    }
  }

 private:
  void start(Flight& flight, bool in, std::uint8_t endpoint, const std::uint8_t* bytes,
             std::uint32_t n, const Setup& setup) {
    flights_[++next_] = &flight;
    const std::span<const std::uint8_t> out =
        in ? std::span<const std::uint8_t>() : std::span(bytes, n);
    client_.submit(next_, in, endpoint, n, out, setup);
  }

  void take(const TransferReply& reply) {
    const std::lock_guard lock(mutex_);
    std::uint32_t sequence = reply.sequence;
    if (reply.unlink) {
      sequence = unlinks_[reply.sequence];
      unlinks_.erase(reply.sequence);
      if (reply.status == 0) return;  // it had ended before
    }
    const auto found = flights_.find(sequence);
    if (found == flights_.end()) std::abort();
    Flight* flight = found->second;
    if (!reply.unlink && flight->in != nullptr) {
      if (reply.length > flight->room || !client_.receive({flight->in, reply.length})) std::abort();
    }
    flights_.erase(found);
    land(*flight, reply.unlink ? -ENOENT : reply.status, reply.length);
    changed_.notify_all();
  }

  void land(Flight& flight, int status, std::uint32_t length) {
    flight.status = status;
    flight.length = length;
    flight.ended = true;
    if (flight.urb == nullptr) return;
    auto* urb = reinterpret_cast<usbdevfs_urb*>(flight.urb->data);
    urb->status = status;
    urb->actual_length = static_cast<int>(length);
    ended_.push_back(&flight);
  }

  UsbipClient& client_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::uint32_t, Flight*> flights_;
  std::map<std::uint32_t, std::uint32_t> unlinks_;
  std::deque<Flight*> ended_;
  std::uint32_t next_ = 0;
  bool asked_in_vain_ = false;
  bool gone_ = false;
};

Setup setup_of(int type, int request, int value, int index, int length) {
  const auto low = [](int v) { return static_cast<std::uint8_t>(v & 0xFF); };
  const auto high = [](int v) { return static_cast<std::uint8_t>(v >> 8 & 0xFF); };
  return {low(type),  low(request), low(value),  high(value),
          low(index), high(index),  low(length), high(length)};
}

// The data that an ioctl's argument points to.
template <typename T>
T& pointee(UMockdevIoctlData* argument, UMockdevIoctlData*& data) {
  data = umockdev_ioctl_data_resolve(argument, 0, sizeof(T), nullptr);
  return *reinterpret_cast<T*>(data->data);
}

void finish(UMockdevIoctlClient* client, int result) {
  umockdev_ioctl_client_complete(client, result < 0 ? -1 : result, result < 0 ? -result : 0);
}

int synchronous(Host& host, UMockdevIoctlData* argument, bool bulk) {
  UMockdevIoctlData* data = nullptr;
  std::uint32_t n = 0;
  bool in = false;
  std::uint8_t endpoint = 0;
  Setup setup{};
  std::size_t pointer = 0;
  if (bulk) {
    const auto& t = pointee<usbdevfs_bulktransfer>(argument, data);
    n = t.len;
    in = (t.ep & 0x80) != 0;
    endpoint = static_cast<std::uint8_t>(t.ep & 0x0F);
    pointer = offsetof(usbdevfs_bulktransfer, data);
  } else {
    const auto& t = pointee<usbdevfs_ctrltransfer>(argument, data);
    n = t.wLength;
    in = (t.bRequestType & 0x80) != 0;
    setup = setup_of(t.bRequestType, t.bRequest, t.wValue, t.wIndex, t.wLength);
    pointer = offsetof(usbdevfs_ctrltransfer, data);
  }
  UMockdevIoctlData* buffer =
      n > 0 ? umockdev_ioctl_data_resolve(data, pointer, n, nullptr) : nullptr;
  const int result = host.run(in, endpoint, buffer == nullptr ? nullptr : buffer->data, n, setup);
  if (buffer != nullptr) g_object_unref(buffer);
  g_object_unref(data);
  return result;
}

gboolean on_ioctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer user) {
  Host& host = *static_cast<Host*>(user);
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  UMockdevIoctlData* data = nullptr;
  int result = 0;
  switch (umockdev_ioctl_client_get_request(client)) {
    case USBDEVFS_GET_CAPABILITIES:
      pointee<std::uint32_t>(argument, data) =
          USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
          USBDEVFS_CAP_BULK_SCATTER_GATHER | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      break;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_RESET:
      break;
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
      result = -ENODATA;  // no driver is bound
      break;
    case USBDEVFS_SETCONFIGURATION:
      result = host.run(false, 0, nullptr, 0, setup_of(0, 9, pointee<int>(argument, data), 0, 0));
      break;
    case USBDEVFS_SETINTERFACE: {
      const auto& set = pointee<usbdevfs_setinterface>(argument, data);
      result = host.run(
          false, 0, nullptr, 0,
          setup_of(1, 11, static_cast<int>(set.altsetting), static_cast<int>(set.interface), 0));
      break;
    }
    case USBDEVFS_CLEAR_HALT:
      result = host.run(false, 0, nullptr, 0, setup_of(2, 1, 0, pointee<int>(argument, data), 0));
      break;
    case USBDEVFS_CONTROL:
      result = synchronous(host, argument, false);
      break;
    case USBDEVFS_BULK:
      result = synchronous(host, argument, true);
      break;
    case USBDEVFS_SUBMITURB:
      result = -host.submit(argument);
      break;
    case USBDEVFS_DISCARDURB: {
      unsigned long address = 0;
      std::memcpy(&address, argument->data, sizeof address);
      result = -host.discard(address);
      break;
    }
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY: {
      const bool wait = umockdev_ioctl_client_get_request(client) == USBDEVFS_REAPURB;
      data = umockdev_ioctl_data_resolve(argument, 0, sizeof(void*), nullptr);
      if (!host.reap(data, wait)) result = -EAGAIN;
      break;
    }
    default:
      result = -ENOTTY;
  }
  finish(client, result);
  if (data != nullptr) g_object_unref(data);
  return TRUE;
}

void on_closed(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* /*client*/, gpointer user) {
  static_cast<Host*>(user)->closed();
}

std::string text_of(UsbipClient& client, int index) {
  std::vector<std::uint8_t> bytes(255);
  const int n =
      index == 0 ? 0 : client.control_in(setup_of(0x80, 6, 0x300 | index, 0x409, 255), bytes);
  std::string text;
  for (int i = 2; i + 1 < n; i += 2) text += static_cast<char>(bytes[static_cast<std::size_t>(i)]);
  return text;
}

std::string format(const char* pattern, int value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), pattern, value);
  return text.data();
}

// The device as umockdev wants it told: what udev and /sys would show.
std::string describe(UsbipClient& client, std::uint32_t speed) {
  std::vector<std::uint8_t> device(18), configuration(255);
  const int n_device = client.control_in(setup_of(0x80, 6, 0x100, 0, 18), device);
  const int n_all = client.control_in(setup_of(0x80, 6, 0x200, 0, 255), configuration);
  if (n_device != 18 || n_all < 9) throw std::runtime_error("no descriptors");
  configuration.resize(static_cast<std::size_t>(n_all));
  const auto two = [&](std::size_t at) { return device[at] | device[at + 1] << 8; };
  std::string text =
      "P: /devices/pci0000:00/0000:00:14.0/usb1/1-1\nN: bus/usb/001/002\n"
      "E: BUSNUM=001\nE: DEVNUM=002\nE: DEVNAME=/dev/bus/usb/001/002\nE: DEVTYPE=usb_device\n"
      "E: SUBSYSTEM=usb\nE: MAJOR=189\nE: MINOR=1\nE: libsane_matched=yes\n";
  text += format("E: PRODUCT=%x/", two(8)) + format("%x/", two(10)) + format("%x\n", two(12));
  text += "A: busnum=1\nA: devnum=2\nA: devpath=1\nA: maxchild=0\nA: bConfigurationValue=1\n";
  text += format("A: bNumConfigurations=%d\n", device[17]);
  text += format("A: bNumInterfaces=%2d\n", configuration[4]);
  text +=
      format("A: bDeviceClass=%02x\n", device[4]) + format("A: bDeviceSubClass=%02x\n", device[5]);
  text +=
      format("A: bDeviceProtocol=%02x\n", device[6]) + format("A: bMaxPacketSize0=%d\n", device[7]);
  text += format("A: idVendor=%04x\n", two(8)) + format("A: idProduct=%04x\n", two(10));
  text += format("A: bcdDevice=%04x\n", two(12));
  text += format("A: version= %x.", device[3]) + format("%02x\n", device[2]);
  text += std::string("A: speed=") + (speed == 3 ? "480" : speed == 2 ? "12" : "1.5") + "\n";
  const char* const names[] = {"manufacturer", "product", "serial"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string value = text_of(client, device[14 + i]);
    if (!value.empty()) text += std::string("A: ") + names[i] + "=" + value + "\n";
  }
  text += "H: descriptors=";
  for (const std::uint8_t byte : device) text += format("%02X", byte);
  for (const std::uint8_t byte : configuration) text += format("%02X", byte);
  return text + "\n\n";
}

int run(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: usbip_host ADDRESS PROGRAM [ARGUMENT...]\n", stderr);
    return kCannotRun;
  }
  std::signal(SIGPIPE, SIG_IGN);
  UsbipClient client(argv[1]);
  const auto imported = client.import("1-1");
  if (!imported) throw std::runtime_error("the device was refused");
  const std::string description = describe(client, imported->speed);

  Host host(client);
  std::thread([&host] { host.listen(); }).detach();
  GError* error = nullptr;
  UMockdevTestbed* testbed = umockdev_testbed_new();
  UMockdevIoctlBase* base = umockdev_ioctl_base_new();
  g_signal_connect(base, "handle-ioctl", G_CALLBACK(on_ioctl), &host);
  g_signal_connect(base, "client-vanished", G_CALLBACK(on_closed), &host);
  if (umockdev_testbed_add_from_string(testbed, description.c_str(), &error) == 0 ||
      umockdev_testbed_attach_ioctl(testbed, kNode, base, &error) == 0) {
    throw std::runtime_error(error->message);
  }
  const pid_t child = ::fork();
  if (child == 0) {
    ::setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1);
    ::execvp(argv[2], argv + 2);
    std::perror(argv[2]);
    std::_Exit(kCannotRun);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  umockdev_testbed_detach_ioctl(testbed, kNode, nullptr);
  g_object_unref(testbed);  // takes the private /sys away
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const int code = run(argc, argv);
    std::fflush(nullptr);
    std::_Exit(code);  // the listening thread still waits for the server
  } catch (const std::exception& error) {
    std::fprintf(stderr, "usbip_host: %s\n", error.what());
    std::_Exit(kCannotRun);
  }
}
