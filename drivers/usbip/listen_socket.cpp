#include "drivers/usbip/listen_socket.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "core/base/error.h"

namespace reseau::usbip {
namespace {

constexpr int kBacklog = 8;
constexpr const char* kForms =
    "Write tcp:127.0.0.1:3240, tcp:3240 (this computer only) or unix:/path.";

[[noreturn]] void throw_errno(int code, const std::string& sentence) {
  throw std::system_error(code, std::generic_category(), sentence);
}

Fd make_socket(int family) {
  Fd fd(::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (fd.get() < 0) throw_errno(errno, "No socket can be made");
  return fd;
}

// True for a socket file whose server has died.
bool is_left_behind(const std::string& path, const sockaddr_un& address) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0 || !S_ISSOCK(info.st_mode)) return false;
  const Fd probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  return probe.get() >= 0 &&
         ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
         errno == ECONNREFUSED;
}

bool is_loopback(const sockaddr* address) {
  if (address->sa_family == AF_INET) {
    const auto* v4 = reinterpret_cast<const sockaddr_in*>(address);
    return ntohl(v4->sin_addr.s_addr) >> 24 == 127;
  }
  const auto* v6 = reinterpret_cast<const sockaddr_in6*>(address);
  return IN6_IS_ADDR_LOOPBACK(&v6->sin6_addr) != 0;
}

}  // namespace

Fd& Fd::operator=(Fd&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

Fd::~Fd() {
  if (fd_ >= 0) ::close(fd_);
}

ListenSocket::ListenSocket(const std::string& address) : address_(address) {
  if (address.starts_with("unix:") && address.size() > 5) {
    listen_unix(address.substr(5));
  } else if (address.starts_with("tcp:") && address.size() > 4) {
    listen_tcp(address.substr(4));
  } else {
    throw InputError("\"" + address + "\" is no address to listen at. " + kForms);
  }
}

ListenSocket::~ListenSocket() {
  std::error_code ignored;
  if (!file_.empty()) std::filesystem::remove(file_, ignored);
}

void ListenSocket::listen_unix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) {
    throw InputError("The name of the socket is longer than " +
                     std::to_string(sizeof address.sun_path - 1) + " characters: " + path);
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  fd_ = make_socket(AF_UNIX);
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);
  int code = ::bind(fd_.get(), generic, sizeof address) == 0 ? 0 : errno;
  if (code == EADDRINUSE && is_left_behind(path, address)) {
    ::unlink(path.c_str());
    code = ::bind(fd_.get(), generic, sizeof address) == 0 ? 0 : errno;
  }
  if (code == EADDRINUSE) {
    throw_errno(EEXIST, path + " exists already, and a program listens there or it is no socket");
  }
  if (code != 0) throw_errno(code, "No socket can be made at " + path);
  file_ = path;
  if (::listen(fd_.get(), kBacklog) != 0)
    throw_errno(errno, "Nobody can be listened to at " + path);
}

void ListenSocket::listen_tcp(const std::string& host_and_port) {
  const std::size_t colon = host_and_port.rfind(':');
  std::string host = colon == std::string::npos ? "127.0.0.1" : host_and_port.substr(0, colon);
  const std::string port =
      colon == std::string::npos ? host_and_port : host_and_port.substr(colon + 1);
  if (host == "localhost") host = "127.0.0.1";
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  const bool number =
      !port.empty() && port.size() <= 5 &&
      std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* raw = nullptr;
  if (!number || std::stoi(port) > 65535 ||
      ::getaddrinfo(host.c_str(), port.c_str(), &hints, &raw) != 0) {
    throw InputError("\"" + address_ + "\" is no address to listen at. " + kForms);
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> list(raw, &::freeaddrinfo);
  open_to_others_ = !is_loopback(list->ai_addr);
  fd_ = make_socket(list->ai_family);
  const int on = 1;
  ::setsockopt(fd_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(fd_.get(), list->ai_addr, list->ai_addrlen) != 0 ||
      ::listen(fd_.get(), kBacklog) != 0) {
    throw_errno(errno, "Port " + port + " of " + host + " cannot be listened at");
  }
  sockaddr_storage taken{};
  socklen_t size = sizeof taken;
  int taken_port = 0;
  if (::getsockname(fd_.get(), reinterpret_cast<sockaddr*>(&taken), &size) == 0) {
    taken_port =
        ntohs(taken.ss_family == AF_INET6 ? reinterpret_cast<const sockaddr_in6*>(&taken)->sin6_port
                                          : reinterpret_cast<const sockaddr_in*>(&taken)->sin_port);
  }
  const bool v6 = list->ai_family == AF_INET6;
  address_ = "tcp:" + (v6 ? "[" + host + "]" : host) + ":" + std::to_string(taken_port);
}

Fd ListenSocket::accept() const {
  Fd fd(::accept4(fd_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (fd.get() >= 0 && file_.empty()) {
    const int on = 1;
    ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  return fd;
}

}  // namespace reseau::usbip
