#pragma once

#include "core/line/capture_context.h"
#include "core/line/line_block.h"
#include "core/line/line_format.h"

namespace reseau {

enum class ScanEnd {
  kComplete,   // every line of the format arrived
  kCancelled,  // a person stopped the scan
  kFailed,     // the device or the environment failed
};

// Takes the lines of one scan. Calls come from one thread in the order begin, lines*, end; once
// begin has returned there is exactly one end. A block is lent until lines() returns.
class LineSink {
 public:
  virtual ~LineSink() = default;
  // Throws std::system_error when the place cannot be written.
  virtual void begin(const LineFormat& format, const CaptureContext& context) = 0;
  // Throws std::system_error; lines of earlier calls stay committed.
  virtual void lines(const LineBlock& block) = 0;
  virtual void end(ScanEnd end) noexcept = 0;
};

}  // namespace reseau
