#include "drivers/usbip/server.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/base/error.h"

namespace reseau::usbip {
namespace {

constexpr std::size_t kMaxConnections = 16;
constexpr std::size_t kReadBytes = 256 * 1024;
// A client that does not read its answers is not answered any further.
constexpr std::size_t kMaxUnsentBytes = 4 * 1024 * 1024;

struct Connection {
  Fd fd;
  RequestReader reader;
  Bytes unsent;
  std::size_t sent = 0;    // of unsent
  bool heard_all = false;  // the client sends nothing more
  bool closing = false;    // once everything is sent
  bool broken = false;     // at once
  std::size_t n_unsent() const { return unsent.size() - sent; }
};

class Server {
 public:
  Server(const ListenSocket& listener, ExportedDevice& device,
         const std::function<void(const std::string&)>& say)
      : listener_(listener), device_(device), say_(say), buffer_(kReadBytes) {}

  void run(const std::stop_token& stop) {
    const Fd wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake.get() < 0)
      throw std::system_error(errno, std::generic_category(), "No event can be made");
    const std::stop_callback on_stop(stop, [&wake] {
      const std::uint64_t one = 1;
      [[maybe_unused]] const auto written = ::write(wake.get(), &one, sizeof one);
    });
    while (!stop.stop_requested()) turn(wake.get());
    if (attached_ != nullptr) device_.detach();
  }

 private:
  void turn(int wake) {
    std::vector<pollfd> fds{{wake, POLLIN, 0}, {listener_.fd(), POLLIN, 0}};
    for (const auto& connection : connections_) {
      short events = 0;
      if (connection->n_unsent() > 0) events |= POLLOUT;
      const bool deaf = connection->closing || connection->heard_all;
      if (!deaf && connection->n_unsent() < kMaxUnsentBytes) events |= POLLIN;
      fds.push_back({connection->fd.get(), events, 0});
    }
    if (::poll(fds.data(), fds.size(), -1) < 0) {
      if (errno == EINTR) return;
      throw std::system_error(errno, std::generic_category(), "Connections cannot be waited for");
    }
    const std::size_t n = connections_.size();
    for (std::size_t i = 0; i < n; ++i) {
      Connection& connection = *connections_[i];
      const short events = fds[i + 2].revents;
      if ((events & POLLIN) != 0) receive(connection);
      // A hang-up without anything to read; with it the read says so.
      else if ((events & (POLLHUP | POLLERR | POLLNVAL)) != 0)
        connection.broken = true;
      pump(connection);
    }
    if ((fds[1].revents & POLLIN) != 0) take_connection();
    std::erase_if(connections_, [this](const std::unique_ptr<Connection>& c) { return ended(*c); });
  }

  void take_connection() {
    Fd fd = listener_.accept();
    if (fd.get() < 0) return;
    if (connections_.size() >= kMaxConnections) {
      // The one that has waited longest without attaching gives way.
      const auto idle = std::find_if(connections_.begin(), connections_.end(),
                                     [this](const auto& c) { return c.get() != attached_; });
      if (idle != connections_.end()) connections_.erase(idle);
    }
    connections_.push_back(std::make_unique<Connection>());
    connections_.back()->fd = std::move(fd);
  }

  void receive(Connection& connection) {
    const ssize_t n = ::recv(connection.fd.get(), buffer_.data(), buffer_.size(), 0);
    if (n > 0) {
      connection.reader.feed(ByteView(buffer_).first(static_cast<std::size_t>(n)));
    } else if (n == 0) {
      connection.heard_all = true;
    } else if (errno != EAGAIN && errno != EINTR) {
      connection.broken = true;
    }
  }

  // Answers what was asked as far as the client takes answers.
  void pump(Connection& connection) {
    while (!connection.broken) {
      const bool more =
          !connection.closing && connection.n_unsent() < kMaxUnsentBytes && answer_next(connection);
      const bool all_sent = send(connection);
      if (!more && all_sent && connection.heard_all) connection.closing = true;
      if (!more || !all_sent) return;
    }
  }

  // False when no whole request is there.
  bool answer_next(Connection& connection) {
    try {
      std::optional<Request> request = connection.reader.next();
      if (!request) return false;
      std::visit([&](auto& r) { answer(connection, r); }, *request);
      return true;
    } catch (const InputError& error) {
      say_(error.what());
      connection.broken = true;
      return false;
    }
  }

  void answer(Connection& connection, const DeviceListRequest& /*request*/) {
    std::vector<DeviceSummary> devices;
    if (!device_.gone()) devices.push_back(device_.summary());
    reply(connection, encode_device_list(devices));
    connection.closing = true;
  }

  void answer(Connection& connection, const ImportRequest& request) {
    const DeviceSummary summary = device_.summary();
    if (attached_ != nullptr || device_.gone() || request.bus_id != summary.bus_id) {
      reply(connection, encode_import(std::nullopt));
      connection.closing = true;
      return;
    }
    attached_ = &connection;
    connection.reader.attach();
    reply(connection, encode_import(summary));
    say_("A client has attached the unit.");
  }

  static void answer(Connection& connection, const UnknownRequest& request) {
    reply(connection, encode_refusal(request.code));
    connection.closing = true;
  }

  void answer(Connection& connection, SubmitRequest& request) {
    done_.clear();
    device_.submit(std::move(request), done_);
    for (const Completion& completion : done_) append_completion(completion, connection.unsent);
    // As when a plug is pulled: the client is told, then its port is empty.
    if (device_.gone()) connection.closing = true;
  }

  void answer(Connection& connection, const UnlinkRequest& request) {
    append_completion(device_.unlink(request), connection.unsent);
  }

  static void reply(Connection& connection, const Bytes& bytes) {
    connection.unsent.insert(connection.unsent.end(), bytes.begin(), bytes.end());
  }

  // False when the client takes no more for now.
  static bool send(Connection& connection) {
    while (connection.n_unsent() > 0) {
      const ssize_t n = ::send(connection.fd.get(), connection.unsent.data() + connection.sent,
                               connection.n_unsent(), MSG_NOSIGNAL);
      if (n < 0) {
        if (errno == EINTR) continue;
        if (errno != EAGAIN) connection.broken = true;
        return false;
      }
      connection.sent += static_cast<std::size_t>(n);
    }
    connection.unsent.clear();
    connection.sent = 0;
    return true;
  }

  bool ended(const Connection& connection) {
    const bool over = connection.broken || (connection.closing && connection.n_unsent() == 0);
    if (over && &connection == attached_) {
      attached_ = nullptr;
      device_.detach();
      say_("The client has gone.");
    }
    return over;
  }

  const ListenSocket& listener_;
  ExportedDevice& device_;
  const std::function<void(const std::string&)>& say_;
  Bytes buffer_;
  std::vector<std::unique_ptr<Connection>> connections_;
  const Connection* attached_ = nullptr;
  std::vector<Completion> done_;
};

}  // namespace

void serve(const ListenSocket& listener, ExportedDevice& device, const std::stop_token& stop,
           const std::function<void(const std::string&)>& say) {
  Server(listener, device, say).run(stop);
}

}  // namespace reseau::usbip
