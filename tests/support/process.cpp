#include "tests/support/process.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace reseau::testing {

namespace {

[[noreturn]] void fail(int error, const char* what) {
  throw std::system_error(error, std::generic_category(), what);
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> list;
  for (std::string& word : words) list.push_back(word.data());
  list.push_back(nullptr);
  return list;
}

// Reads once; closes at the end of the stream.
void drain(int& fd, std::string& text) {
  std::array<char, 65536> buffer{};
  const ssize_t n = ::read(fd, buffer.data(), buffer.size());
  if (n > 0) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  } else if (n == 0 || errno != EINTR) {
    ::close(fd);
    fd = -1;
  }
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments, const ProcessOptions& options) {
  std::vector<std::string> words = arguments;
  if (options.file_size_limit_blocks >= 0) {
    const std::string script =
        "ulimit -f " + std::to_string(options.file_size_limit_blocks) + "; exec \"$@\"";
    const std::vector<std::string> shell{"/bin/sh", "-c", script, "sh"};
    words.insert(words.begin(), shell.begin(), shell.end());
  }
  std::vector<std::string> environment = options.environment;
  for (char** entry = environ; *entry != nullptr; ++entry) environment.emplace_back(*entry);

  std::array<int, 2> out{};
  std::array<int, 2> err{};
  if (::pipe2(out.data(), O_CLOEXEC) != 0 || ::pipe2(err.data(), O_CLOEXEC) != 0) {
    fail(errno, "pipe2");
  }
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  auto argument_pointers = pointers(words);
  auto environment_pointers = pointers(environment);
  const int error = ::posix_spawnp(&pid_, argument_pointers[0], &actions, nullptr,
                                   argument_pointers.data(), environment_pointers.data());
  posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  ::close(err[1]);
  out_fd_ = out[0];
  err_fd_ = err[0];
  if (error != 0) fail(error, argument_pointers[0]);
  pid_fd_ = static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0));
  if (pid_fd_ < 0) fail(errno, "pidfd_open");
}

Process::~Process() {
  if (pid_ > 0 && !ended_) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  for (const int fd : {pid_fd_, out_fd_, err_fd_}) {
    if (fd >= 0) ::close(fd);
  }
}

bool Process::pump(Time deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
      deadline - std::chrono::steady_clock::now());
  if (left.count() <= 0) return false;
  // poll() ignores negative descriptors. The end of the child counts only when both pipes are
  // empty.
  const bool pipes_open = out_fd_ >= 0 || err_fd_ >= 0;
  std::array<pollfd, 3> fds{pollfd{out_fd_, POLLIN, 0}, pollfd{err_fd_, POLLIN, 0},
                            pollfd{pipes_open ? -1 : pid_fd_, POLLIN, 0}};
  const int n = ::poll(fds.data(), fds.size(), static_cast<int>(left.count()));
  if (n < 0 && errno != EINTR) fail(errno, "poll");
  if (n <= 0) return n < 0;
  if (fds[0].revents != 0) drain(out_fd_, out_);
  if (fds[1].revents != 0) drain(err_fd_, err_);
  if (fds[2].revents != 0) ended_ = true;
  return true;
}

bool Process::wait_for_line(const std::function<bool(const std::string&)>& wanted,
                            std::chrono::milliseconds timeout) {
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    for (auto end = out_.find('\n', scanned_); end != std::string::npos;
         end = out_.find('\n', scanned_)) {
      const std::string line = out_.substr(scanned_, end - scanned_);
      scanned_ = end + 1;
      if (wanted(line)) return true;
    }
    if (out_fd_ < 0 || !pump(deadline)) return false;
  }
}

void Process::send(int signal) const { ::kill(pid_, signal); }

ProcessResult Process::wait(std::chrono::milliseconds timeout) {
  ProcessResult result;
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  while (!ended_ && pump(deadline)) {
  }
  if (!ended_) {
    result.timed_out = true;
    ::kill(pid_, SIGKILL);
  }
  int status = 0;
  ::waitpid(pid_, &status, 0);
  ended_ = true;
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  result.out = std::move(out_);
  result.err = std::move(err_);
  return result;
}

ProcessResult run_process(const std::vector<std::string>& arguments, const ProcessOptions& options,
                          std::chrono::milliseconds timeout) {
  Process process(arguments, options);
  return process.wait(timeout);
}

}  // namespace reseau::testing
