// A scan that goes on, seen as if it ended after the lines that are there. Thread-safe where the
// source is.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "core/base/check.h"
#include "core/line/line_source.h"

namespace reseau {

class FirstLines final : public LineSource {
 public:
  // `source` must outlive this and have n_lines committed.
  FirstLines(const LineSource& source, int n_lines) : source_(source), format_(source.format()) {
    CHECK(n_lines >= 0 && n_lines <= source.committed());
    format_.n_lines = n_lines;
  }

  [[nodiscard]] const LineFormat& format() const override { return format_; }
  [[nodiscard]] int committed() const override { return format_.n_lines; }
  int wait_committed(int /*n_lines*/, const std::stop_token& /*stop*/) const override {
    return format_.n_lines;
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override {
    CHECK(n <= format_.n_lines - first);
    source_.read(first, n, out);
  }

 private:
  const LineSource& source_;
  LineFormat format_;
};

}  // namespace reseau
