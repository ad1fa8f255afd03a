#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>

#include "capture/store/line_watermark.h"
#include "core/line/line_source.h"

namespace reseau {

// Lines of a master (or of any uncompressed, chunky, contiguous 16-bit TIFF in the machine's byte
// order), read from the file on demand: of one still being written, below the watermark, or of a
// finished one. Holds its own descriptor, so that a rename does not disturb it. Thread-safe.
class MasterFileSource final : public LineSource {
 public:
  // Lines start at `data_offset` and follow each other without gaps. `fd` is duplicated.
  // `watermark` is shared with the writer. Throws std::system_error.
  MasterFileSource(LineFormat format, int fd, std::uint64_t data_offset,
                   std::shared_ptr<const LineWatermark> watermark);
  ~MasterFileSource() override;
  MasterFileSource(const MasterFileSource&) = delete;
  MasterFileSource& operator=(const MasterFileSource&) = delete;

  [[nodiscard]] const LineFormat& format() const override { return format_; }
  [[nodiscard]] int committed() const override { return watermark_->committed(); }
  int wait_committed(int n_lines, const std::stop_token& stop) const override {
    return watermark_->wait(n_lines, stop);
  }
  // Throws std::system_error when the medium fails, InputError when the file was shortened.
  void read(int first, int n, std::span<std::uint16_t> out) const override;

 private:
  LineFormat format_;
  int fd_;
  std::uint64_t data_offset_;
  std::shared_ptr<const LineWatermark> watermark_;
};

}  // namespace reseau
