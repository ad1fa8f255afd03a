#include "capture/store/master_source.h"

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

// The number of channels as a constant lets the compiler use vector loads.
template <std::size_t kChannels>
void split_row(const std::uint16_t* in, std::size_t width, std::uint16_t* out) {
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t c = 0; c < kChannels; ++c) out[c * width + x] = in[x * kChannels + c];
  }
}

void split_row(const std::uint16_t* in, std::size_t width, std::size_t channels,
               std::uint16_t* out) {
  if (channels == 4) return split_row<4>(in, width, out);
  if (channels == 3) return split_row<3>(in, width, out);
  for (std::size_t x = 0; x < width; ++x) {
    for (std::size_t c = 0; c < channels; ++c) out[c * width + x] = in[x * channels + c];
  }
}

void read_fully(int fd, std::uint64_t offset, std::span<std::uint16_t> out) {
  auto* data = reinterpret_cast<char*>(out.data());
  std::size_t done = 0;
  while (done < out.size_bytes()) {
    const ssize_t n =
        ::pread(fd, data + done, out.size_bytes() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      throw std::system_error(errno, std::generic_category(), "The scan cannot be read back");
    }
    if (n == 0) {
      throw InputError(
          "The scan file became shorter while it was read; another program must have changed it.");
    }
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

MasterFileSource::MasterFileSource(LineFormat format, int fd, std::uint64_t data_offset,
                                   std::shared_ptr<const LineWatermark> watermark)
    : format_(std::move(format)),
      fd_(::fcntl(fd, F_DUPFD_CLOEXEC, 0)),
      data_offset_(data_offset),
      watermark_(std::move(watermark)) {
  CHECK(watermark_ != nullptr && format_.samples_per_line() > 0);
  if (fd_ < 0) {
    throw std::system_error(errno, std::generic_category(),
                            "The scan cannot be opened a second time for reading");
  }
}

MasterFileSource::~MasterFileSource() { ::close(fd_); }

void MasterFileSource::read(int first, int n, std::span<std::uint16_t> out) const {
  CHECK(first >= 0 && n >= 0 && n <= committed() - first);
  const std::size_t per_line = format_.samples_per_line();
  CHECK(out.size() == per_line * static_cast<std::size_t>(n));
  const std::size_t line_bytes = per_line * sizeof(std::uint16_t);
  const auto chunk_lines = std::max<std::size_t>(1, kChunkBytes / line_bytes);
  const auto n_lines = static_cast<std::size_t>(n);
  std::vector<std::uint16_t> chunk(std::min(chunk_lines, n_lines) * per_line);
  for (std::size_t y = 0; y < n_lines; y += chunk_lines) {
    const std::size_t lines = std::min(chunk_lines, n_lines - y);
    const std::uint64_t line = static_cast<std::uint64_t>(first) + y;
    read_fully(fd_, data_offset_ + line * line_bytes, std::span(chunk).first(lines * per_line));
    for (std::size_t i = 0; i < lines; ++i) {
      split_row(chunk.data() + i * per_line, static_cast<std::size_t>(format_.width_px),
                format_.channels.size(), out.data() + (y + i) * per_line);
    }
  }
}

}  // namespace reseau
