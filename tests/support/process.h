// A child process of a test, with a deadline. Output of both streams is collected; a test can wait
// for a line of it and send signals. Thread-bound.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace reseau::testing {

struct ProcessOptions {
  std::vector<std::string> environment;  // "NAME=value", added to that of the test
  long file_size_limit_blocks = -1;      // `ulimit -f` in blocks of 512 bytes; < 0 = none
};

struct ProcessResult {
  int exit_code = -1;  // when it exited
  int signal = 0;      // when a signal ended it
  bool timed_out = false;
  std::string out, err;
};

class Process {
 public:
  // arguments[0] is the program. Throws std::system_error when it cannot be started.
  explicit Process(const std::vector<std::string>& arguments, const ProcessOptions& options = {});
  // Kills what still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // Reads stdout until a whole line fulfils the condition. False when the deadline passed or the
  // child closed its output first.
  [[nodiscard]] bool wait_for_line(const std::function<bool(const std::string&)>& wanted,
                                   std::chrono::milliseconds timeout);
  void send(int signal) const;
  // Collects everything until the child ends; kills it at the deadline.
  [[nodiscard]] ProcessResult wait(std::chrono::milliseconds timeout);

 private:
  using Time = std::chrono::steady_clock::time_point;
  // Reads what there is, waiting until something comes. False at the deadline.
  bool pump(Time deadline);

  pid_t pid_ = -1;
  int pid_fd_ = -1;
  int out_fd_ = -1;
  int err_fd_ = -1;
  bool ended_ = false;
  std::string out_, err_;
  std::size_t scanned_ = 0;  // of out_, by wait_for_line
};

// Start to end with one deadline.
[[nodiscard]] ProcessResult run_process(
    const std::vector<std::string>& arguments, const ProcessOptions& options = {},
    std::chrono::milliseconds timeout = std::chrono::seconds(60));

}  // namespace reseau::testing
