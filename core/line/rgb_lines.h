// A scan seen without its infrared. Thread-safe where the source is.
#pragma once

#include <span>
#include <stop_token>

#include "core/line/line_source.h"

namespace reseau {

class RgbLines final : public LineSource {
 public:
  // `source` must outlive this.
  explicit RgbLines(const LineSource& source);

  [[nodiscard]] const LineFormat& format() const override { return format_; }
  [[nodiscard]] int committed() const override { return source_.committed(); }
  int wait_committed(int n_lines, const std::stop_token& stop) const override {
    return source_.wait_committed(n_lines, stop);
  }
  void read(int first, int n, std::span<std::uint16_t> out) const override;

 private:
  const LineSource& source_;
  LineFormat format_;
};

}  // namespace reseau
