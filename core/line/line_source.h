// Committed lines, to be pulled by whoever looks at them: a master file that is still being
// written, a finished file, or memory. Live, resumed and offline runs differ only in the source
// behind this.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>

#include "core/line/line_format.h"

namespace reseau {

// Thread-safe, all of it.
class LineSource {
 public:
  virtual ~LineSource() = default;
  [[nodiscard]] virtual const LineFormat& format() const = 0;
  // Lines [0, committed()) can be read. Never falls.
  [[nodiscard]] virtual int committed() const = 0;
  // Blocks until at least n_lines are committed, no more lines will come, or stop is requested.
  // Returns committed(), which is below n_lines only in the last two cases.
  virtual int wait_committed(int n_lines, const std::stop_token& stop) const = 0;
  // Copies lines [first, first + n) into out, [line][channel][pixel], which must be exactly that
  // large. The lines must be committed. Throws std::system_error or InputError.
  virtual void read(int first, int n, std::span<std::uint16_t> out) const = 0;
};

}  // namespace reseau
