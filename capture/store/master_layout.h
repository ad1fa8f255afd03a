// Where everything lies in a master TIFF, as pure arithmetic: no I/O, so that the 4 GiB threshold
// and the crash consistency can be tested without writing 4 GiB. Tags and types: TIFF 6.0; BigTIFF
// as in the libtiff format description; XMP packet tag 700; ICC tag 34675.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/line/capture_context.h"
#include "core/line/line_format.h"

namespace reseau {

// Offsets of a classic TIFF have 32 bits.
inline constexpr std::uint64_t kClassicTiffLimit = 0xFFFFFFFFu;
// Header and directory fit here: one sector of any disk, so replaced in one step.
inline constexpr std::size_t kMasterHeadBytes = 512;

// Text and profile that go into the tags.
struct MasterTags {
  std::string description, make, model, software;
  std::string date_time;       // "2026:11:22 10:15:00"; empty = no tag
  std::string xmp;             // UTF-8 packet
  std::vector<std::byte> icc;  // empty = no tag
};

// Tags of a scan: a function of its arguments only. `film` as in MasterOptions.
[[nodiscard]] MasterTags make_master_tags(const LineFormat& format, const CaptureContext& context,
                                          const std::string& film);

struct MasterLayout {
  LineFormat format;
  MasterTags tags;
  bool big = false;
  int rows_per_strip = 1;
  std::uint64_t bytes_per_row = 0;
  std::uint64_t data_offset = 0;    // of the first row; rows follow without gaps
  std::uint64_t total_bytes = 0;    // of the finished file
  std::uint64_t offsets_table = 0;  // of the strip offsets, all of them, fixed
  std::uint64_t counts_table = 0;   // of the strip byte counts, which grow with the lines

  [[nodiscard]] std::uint64_t row_offset(int row) const {
    return data_offset + static_cast<std::uint64_t>(row) * bytes_per_row;
  }
  [[nodiscard]] int strip_of(int row) const { return row / rows_per_strip; }
};

// BigTIFF when the finished file would exceed `bigtiff_above_bytes`. Throws InputError when the
// format has no channel, no pixel or no line.
[[nodiscard]] MasterLayout plan_master(const LineFormat& format, MasterTags tags,
                                       std::uint64_t bigtiff_above_bytes);

// The first kMasterHeadBytes of the file: header and directory claiming n_lines >= 1 lines.
[[nodiscard]] std::vector<std::byte> encode_master_head(const MasterLayout& layout, int n_lines);
// What follows, up to data_offset: values of the tags, strip offsets, and the byte counts of the
// strips as they are when n_lines >= 0 lines are in the file.
[[nodiscard]] std::vector<std::byte> encode_master_values(const MasterLayout& layout, int n_lines);

// A piece of the file to be replaced.
struct MasterPatch {
  std::uint64_t offset = 0;
  std::vector<std::byte> bytes;
};
// Byte counts of the strips that hold lines [first_line, n_lines), when n_lines are in the file. To
// be written after the lines and before the head, so that no reader ever finds a strip that claims
// more than the file holds.
[[nodiscard]] MasterPatch encode_strip_counts(const MasterLayout& layout, int first_line,
                                              int n_lines);

}  // namespace reseau
