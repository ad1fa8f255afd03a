#include "drivers/pieusb/line_sorter.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau::pieusb {
namespace {

// Lines of the sensor's colours lie at most some tens of rows apart.
constexpr std::size_t kMostPendingRows = 2048;

[[noreturn]] void out_of_step(const std::string& what) {
  throw DeviceError(
      DeviceError::Kind::kProtocol,
      "The scanner's lines are out of step (" + what + "). The lines before are kept. Scan again.",
      "image lines");
}

}  // namespace

int channel_of_tag(ByteView line) {
  if (line.size() < kTagBytes || line[0] != line[1]) return -1;
  switch (static_cast<char>(line[0])) {
    case 'R':
      return 0;
    case 'G':
      return 1;
    case 'B':
      return 2;
    case 'I':
      return 3;
    default:
      return -1;
  }
}

LineSorter::LineSorter(int width_px, int n_rows, int n_channels, int bytes_per_sample)
    : width_(static_cast<std::size_t>(width_px)),
      n_rows_(n_rows),
      n_channels_(n_channels),
      bytes_per_sample_(bytes_per_sample),
      line_bytes_(kTagBytes + width_ * static_cast<std::size_t>(bytes_per_sample)) {
  CHECK(width_px > 0 && n_rows > 0);
  CHECK(n_channels == 3 || n_channels == 4);
  CHECK(bytes_per_sample == 1 || bytes_per_sample == 2);
}

void LineSorter::add(ByteView line) {
  CHECK(line.size() == line_bytes_);
  const int channel = channel_of_tag(line);
  if (channel < 0 || channel >= n_channels_) {
    out_of_step("a line without a colour, \"" + hex_of(line.first(kTagBytes)) + "\"");
  }
  if (!direction_known_ && (channel == 0 || channel == 2)) {
    direction_known_ = true;
    bottom_up_ = channel == 2;
  }
  const auto c = static_cast<std::size_t>(channel);
  const int row = seen_[c]++;
  if (row >= n_rows_) out_of_step("too many lines of one colour");
  const auto at = static_cast<std::size_t>(row - (bottom_up_ ? 0 : taken_));
  if (at >= rows_.size()) {
    if (!bottom_up_ && rows_.size() >= kMostPendingRows) out_of_step("a colour is missing");
    rows_.resize(at + 1);
  }
  std::vector<std::uint16_t>& samples = rows_[at];
  samples.resize(static_cast<std::size_t>(n_channels_) * width_);
  const auto* const from = reinterpret_cast<const unsigned char*>(line.data()) + kTagBytes;
  std::uint16_t* const to = samples.data() + c * width_;
  for (std::size_t i = 0; i < width_; ++i) {
    to[i] = bytes_per_sample_ == 2 ? static_cast<std::uint16_t>(from[2 * i] | from[2 * i + 1] << 8)
                                   : static_cast<std::uint16_t>(from[i] * 257);
  }
}

int LineSorter::rows_ready() const {
  const int complete = *std::min_element(seen_.begin(), seen_.begin() + n_channels_);
  if (bottom_up_) return complete == n_rows_ ? n_rows_ - taken_ : 0;
  return complete - taken_;
}

std::vector<std::uint16_t> LineSorter::take() {
  CHECK(rows_ready() > 0);
  ++taken_;
  std::vector<std::uint16_t> row;
  if (bottom_up_) {
    row = std::move(rows_.back());
    rows_.pop_back();
  } else {
    row = std::move(rows_.front());
    rows_.pop_front();
  }
  return row;
}

}  // namespace reseau::pieusb
