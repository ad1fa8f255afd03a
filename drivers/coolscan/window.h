#pragma once

#include <cstdint>
#include <optional>

#include "drivers/bytes.h"
#include "drivers/coolscan/commands.h"

namespace reseau::coolscan {

// Exposures travel in units of 10 ns.
inline constexpr double k10nsPerUs = 100.0;

enum class ScanKind : std::uint8_t { kImage = 0x01, kThumbnail = 0x02 };
enum class Interleaving : std::uint8_t { kLine = 0x02, kMultiLine = 0x40 };

// A window descriptor: how one colour of a scan shall be taken. Units of a window are optical
// pixels, because MODE SELECT is sent with the maximum resolution. Plain value.
// Source: LS-5000 interface specification, SET WINDOW; recorded Nikon Scan session.
struct Window {
  Colour colour = Colour::kDefault;
  int resolution_dpi = 0;
  int x_px = 0, y_px = 0, width_px = 0, height_px = 0;
  int composition = 5;  // 2 one colour, 5 RGB, which Nikon Scan sends even for infrared
  int bits = 16;
  int readings = 1;       // of each line, 1 to 16
  bool averaging = true;  // along the line, below full resolution
  bool positive = true;
  ScanKind kind = ScanKind::kImage;
  std::uint8_t mode = 0x02;  // 02 normal, 10 multiple reading
  Interleaving interleaving = Interleaving::kLine;
  std::uint32_t exposure_10ns = 0;
  bool operator==(const Window&) const = default;
};

// Header and descriptor, kWindowBytes.
[[nodiscard]] Bytes encode_window(const Window& window);

// The first descriptor of SET WINDOW data or of a GET WINDOW reply, which both start with an 8-byte
// header. Absent when there are too few bytes.
[[nodiscard]] std::optional<Window> decode_window(ByteView data);

}  // namespace reseau::coolscan
