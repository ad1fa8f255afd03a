// Other people's scans, and our own masters, as lines. Reads with libtiff's scanlines and tiles
// only: its RGBA interface and OpenImageIO multiply a fourth sample that is tagged as alpha into
// the colours, and here it is infrared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/line/capture_context.h"
#include "core/line/line_source.h"
#include "core/reconstruct/tone_curve.h"

namespace reseau {

struct ReadScanOptions {
  // Encoding gamma of all channels, infrared included; overrides an embedded profile.
  std::optional<double> gamma;
  // A file with infrared, instead of what is found in or beside the scan.
  std::filesystem::path infrared_file;
  bool look_for_sidecar = true;  // NAME_IR.tif, NAME-ir.tif and the like
  bool allow_grey = false;       // one channel: format().channels is {kGrey}
  // Give the readable lines of a truncated file instead of refusing it.
  bool accept_truncated = false;
  // For decoded lines; 0 = three quarters of the machine's memory.
  std::uint64_t max_memory_bytes = 0;
};

enum class InfraredFrom { kNone, kFourthSample, kSecondPage, kSidecar };

struct Scan {
  // RGB or RGBI (or grey), 16 bit: 8-bit samples v arrive as v * 257. Lives independent of Scan.
  std::shared_ptr<const LineSource> source;
  ToneCurves tone = ToneCurves::linear();
  InfraredFrom infrared = InfraredFrom::kNone;
  std::filesystem::path infrared_path;  // kSidecar
  // From the tags and from our XMP; unknown fields are empty.
  CaptureContext context;
  std::string film;  // from our XMP
  std::string software, date_time, description;
  std::vector<std::byte> icc;
  int file_bits = 16;
  bool truncated = false;          // only with accept_truncated
  std::vector<std::string> notes;  // sentences about what was found and assumed
};

// Opens a TIFF scan: 8 or 16 bit integer or 32-bit float (0..1, clamped, rounded to 16 bit), RGB
// or RGBI, chunky or planar, strips or tiles, any compression of libtiff; infrared as fourth
// sample, second page or sidecar. Uncompressed 16-bit chunky files are read on demand, others are
// decoded into memory. Throws InputError with a sentence for everything that is wrong with the
// file, std::system_error when the system does not let us read it.
[[nodiscard]] Scan read_scan(const std::filesystem::path& path,
                             const ReadScanOptions& options = {});

}  // namespace reseau
