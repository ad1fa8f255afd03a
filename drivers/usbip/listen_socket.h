#pragma once

#include <filesystem>
#include <string>

namespace reseau::usbip {

// An open file descriptor. Movable, closes itself.
class Fd {
 public:
  Fd() = default;
  explicit Fd(int fd) : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  Fd& operator=(Fd&& other) noexcept;
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  ~Fd();

  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_ = -1;
};

// Where connections are waited for: "tcp:127.0.0.1:3240", "tcp:3240" (loopback), "tcp:[::1]:3240",
// or "unix:/path". Port 0 takes a free one. A socket file that nobody listens on any more is
// replaced; any other file is left alone. The file goes away with the object.
class ListenSocket {
 public:
  // Throws InputError for an address that cannot be understood, std::system_error when it cannot
  // be had.
  explicit ListenSocket(const std::string& address);
  ~ListenSocket();
  ListenSocket(const ListenSocket&) = delete;
  ListenSocket& operator=(const ListenSocket&) = delete;

  [[nodiscard]] int fd() const { return fd_.get(); }
  // As it is, with the port that was taken.
  [[nodiscard]] const std::string& address() const { return address_; }
  // Others than this computer can reach it.
  [[nodiscard]] bool open_to_others() const { return open_to_others_; }
  // The next connection, non-blocking; get() is -1 when there is none.
  [[nodiscard]] Fd accept() const;

 private:
  void listen_unix(const std::string& path);
  void listen_tcp(const std::string& host_and_port);

  Fd fd_;
  std::string address_;
  std::filesystem::path file_;
  bool open_to_others_ = false;
};

}  // namespace reseau::usbip
