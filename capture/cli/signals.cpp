#include "capture/cli/signals.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <system_error>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "capture/cli/exit_code.h"

namespace reseau::cli {

SignalWatcher::SignalWatcher() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  // A closed terminal stops the scan too, unless nohup said otherwise.
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) {
    sigaddset(&set, SIGHUP);
  }
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  signal_fd_ = ::signalfd(-1, &set, SFD_CLOEXEC);
  wake_fd_ = ::eventfd(0, EFD_CLOEXEC);
  if (signal_fd_ < 0 || wake_fd_ < 0) {
    throw std::system_error(errno, std::generic_category(), "Signals cannot be watched");
  }
  thread_ = std::jthread([this] { watch(); });
}

SignalWatcher::~SignalWatcher() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_fd_, &one, sizeof one);
  if (thread_.joinable()) thread_.join();
  ::close(wake_fd_);
  ::close(signal_fd_);
}

void SignalWatcher::watch() noexcept {
  constexpr std::chrono::milliseconds kEcho{100};
  std::uint32_t last_signal = 0;
  std::chrono::steady_clock::time_point last_time;
  while (true) {
    std::array<pollfd, 2> fds{pollfd{signal_fd_, POLLIN, 0}, pollfd{wake_fd_, POLLIN, 0}};
    if (::poll(fds.data(), fds.size(), -1) < 0 && errno != EINTR) return;
    if (fds[1].revents != 0) return;
    if ((fds[0].revents & POLLIN) == 0) continue;
    signalfd_siginfo info{};
    if (::read(signal_fd_, &info, sizeof info) != sizeof info) continue;
    // Wrappers such as timeout(1) send a signal to the child and to its group: that is one wish.
    const auto now = std::chrono::steady_clock::now();
    const bool echo = info.ssi_signo == last_signal && now - last_time < kEcho;
    last_signal = info.ssi_signo;
    last_time = now;
    if (echo) continue;
    switch (++count_) {
      case 1:
        first_.request_stop();
        break;
      case 2:
        second_.request_stop();
        break;
      default:
        ::_exit(kExitSecondCtrlC);
    }
  }
}

}  // namespace reseau::cli
