#include "drivers/coolscan/window.h"

namespace reseau::coolscan {
namespace {

constexpr std::size_t kHeaderBytes = 8;
constexpr std::size_t kDescriptorBytes = 50;
constexpr int kAveraging = 0x80;
constexpr int kPositive = 0x01;
constexpr int kDefaultAutoExposureTarget = 0xFF;

}  // namespace

Bytes encode_window(const Window& window) {
  Bytes data(kHeaderBytes + kDescriptorBytes);
  store_be(data, 6, 2, kDescriptorBytes);
  const auto put = [&](std::size_t offset, std::size_t n, int value) {
    store_be(data, kHeaderBytes + offset, n, static_cast<std::uint64_t>(value));
  };
  put(0, 1, static_cast<int>(window.colour));
  put(2, 2, window.resolution_dpi);
  put(4, 2, window.resolution_dpi);
  put(6, 4, window.x_px);
  put(10, 4, window.y_px);
  put(14, 4, window.width_px);
  put(18, 4, window.height_px);
  put(25, 1, window.composition);
  put(26, 1, window.bits);
  put(40, 1, (window.readings - 1) << 4);
  put(41, 1, (window.averaging ? kAveraging : 0) | (window.positive ? kPositive : 0));
  put(42, 1, static_cast<int>(window.kind));
  put(43, 1, window.mode);
  put(44, 1, static_cast<int>(window.interleaving));
  put(45, 1, kDefaultAutoExposureTarget);
  store_be(data, kHeaderBytes + 46, 4, window.exposure_10ns);
  return data;
}

std::optional<Window> decode_window(ByteView data) {
  if (data.size() < kHeaderBytes + kDescriptorBytes) return std::nullopt;
  const auto get = [&](std::size_t offset, std::size_t n) {
    return static_cast<int>(load_be(data, kHeaderBytes + offset, n));
  };
  Window window;
  window.colour = static_cast<Colour>(get(0, 1));
  window.resolution_dpi = get(2, 2);
  window.x_px = get(6, 4);
  window.y_px = get(10, 4);
  window.width_px = get(14, 4);
  window.height_px = get(18, 4);
  window.composition = get(25, 1);
  window.bits = get(26, 1);
  window.readings = (get(40, 1) >> 4) + 1;
  window.averaging = (get(41, 1) & kAveraging) != 0;
  window.positive = (get(41, 1) & kPositive) != 0;
  window.kind = static_cast<ScanKind>(get(42, 1));
  window.mode = static_cast<std::uint8_t>(get(43, 1));
  window.interleaving = static_cast<Interleaving>(get(44, 1));
  window.exposure_10ns = static_cast<std::uint32_t>(get(46, 4));
  return window;
}

}  // namespace reseau::coolscan
