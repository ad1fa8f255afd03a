#include "drivers/coolscan/frames.h"

#include <algorithm>
#include <cmath>

namespace reseau::coolscan {
namespace {

constexpr std::size_t kDataHead = 6;
constexpr int kPulsesPerPerforation = 108;
constexpr int kPulsesPerPattern = 22;
// Film of 40 frames is 1.6 m; no address of a unit comes near this.
constexpr int kMaxAddress = 1 << 24;

int int_at(ByteView data, std::size_t offset, std::size_t n) {
  return static_cast<int>(std::min<std::uint64_t>(load_be(data, offset, n), 0x7FFFFFFF));
}

}  // namespace

int units_per_pulse(int max_dpi) {
  constexpr double kUnitsAt4000 = 7.0;
  return std::max(1, static_cast<int>(std::lround(kUnitsAt4000 * max_dpi / 4000)));
}

int address_of(const FilmCount& count, int max_dpi) {
  const int pulses =
      kPulsesPerPerforation * count.perforation + kPulsesPerPattern * count.pattern + count.pulse;
  return pulses * units_per_pulse(max_dpi);
}

FilmCount count_at(int address_px, int max_dpi) {
  const int pulses = std::clamp(address_px, 0, kMaxAddress) / units_per_pulse(max_dpi);
  const int rest = pulses % kPulsesPerPerforation;
  return {pulses / kPulsesPerPerforation, rest / kPulsesPerPattern, rest % kPulsesPerPattern};
}

std::vector<FrameRecord> parse_frame_table(ByteView data) {
  constexpr std::size_t kCount = 4, kRecord = 8;
  std::vector<FrameRecord> frames;
  if (data.size() < kDataHead + kCount) return frames;
  const std::size_t n = std::min<std::size_t>(u8_at(data, kDataHead + 2), kMaxFrames);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at = kDataHead + kCount + i * kRecord;
    if (at + kRecord > data.size()) break;
    const int address = int_at(data, at, 4);
    if (address > kMaxAddress) break;
    frames.push_back(
        {address, {int_at(data, at + 4, 2), u8_at(data, at + 6), u8_at(data, at + 7)}});
  }
  return frames;
}

Bytes frame_table_data(const std::vector<FrameRecord>& frames) {
  CHECK(!frames.empty() && frames.size() <= kMaxFrames);
  Bytes data(4 + 8 * frames.size());
  store_be(data, 0, 2, 8 * frames.size() + 2);
  store_be(data, 2, 1, frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t at = 4 + 8 * i;
    const FilmCount& count = frames[i].count;
    store_be(data, at, 4, static_cast<std::uint64_t>(frames[i].address_px));
    store_be(data, at + 4, 2, static_cast<std::uint64_t>(count.perforation));
    store_be(data, at + 6, 1, static_cast<std::uint64_t>(count.pattern));
    store_be(data, at + 7, 1, static_cast<std::uint64_t>(count.pulse));
  }
  return data;
}

FrameRecord moved(const FrameRecord& frame, int by_px, int max_dpi) {
  const int unit = units_per_pulse(max_dpi);
  const int target = std::max(frame.address_px + by_px, 0);
  // Address and count have to agree, as all records that a thumbnail was measured for do.
  const int address = (target + unit / 2) / unit * unit;
  return {address, count_at(address, max_dpi)};
}

std::optional<std::vector<int>> parse_perforations(ByteView data, int max_dpi) {
  constexpr std::size_t kFirst = kDataHead + 4, kRecord = 4;
  if (data.size() < kFirst + 2 * kRecord) return std::nullopt;
  std::vector<int> addresses;
  for (std::size_t at = kFirst; at + kRecord <= data.size(); at += kRecord) {
    constexpr std::uint8_t kPatternBits = 0x7F;  // b7: the counting sensor
    const FilmCount count{int_at(data, at, 2), u8_at(data, at + 2) & kPatternBits,
                          u8_at(data, at + 3)};
    const int address = address_of(count, max_dpi);
    // Counting stops after the last perforation.
    if (!addresses.empty() && address < addresses.back()) return std::nullopt;
    addresses.push_back(address);
  }
  if (addresses.back() == addresses.front()) return std::nullopt;
  return addresses;
}

std::vector<FrameRectangle> parse_frame_page(ByteView page) {
  constexpr std::size_t kPageHead = 4, kRecord = 16;
  std::vector<FrameRectangle> frames;
  if (page.size() <= kPageHead) return frames;
  const ByteView body =
      page.subspan(kPageHead, std::min<std::size_t>(page.size() - kPageHead, u8_at(page, 3)));
  if (body.empty()) return frames;
  const std::size_t n = u8_at(body, 0);
  for (std::size_t i = 0; i < n && 1 + (i + 1) * kRecord <= body.size(); ++i) {
    const std::size_t at = 1 + i * kRecord;
    frames.push_back({int_at(body, at, 4), int_at(body, at + 4, 4), int_at(body, at + 8, 4),
                      int_at(body, at + 12, 4)});
  }
  return frames;
}

Bytes frame_rectangle_data(const std::vector<FrameRectangle>& frames) {
  CHECK(!frames.empty() && frames.size() <= kMaxFrames);
  Bytes data(4 + 16 * frames.size());
  // The length counts itself and everything (measured on an LS-9000; its specification says two
  // less).
  store_be(data, 0, 2, data.size());
  store_be(data, 2, 1, frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t at = 4 + 16 * i;
    const FrameRectangle& f = frames[i];
    store_be(data, at, 4, static_cast<std::uint64_t>(f.top_px));
    store_be(data, at + 4, 4, static_cast<std::uint64_t>(f.left_px));
    store_be(data, at + 8, 4, static_cast<std::uint64_t>(f.top_px + f.height_px - 1));
    store_be(data, at + 12, 4, static_cast<std::uint64_t>(f.left_px + f.width_px - 1));
  }
  return data;
}

}  // namespace reseau::coolscan
