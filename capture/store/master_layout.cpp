#include "capture/store/master_layout.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "core/base/check.h"
#include "core/base/error.h"

namespace reseau {
namespace {

enum Type : std::uint16_t {
  kAscii = 2,
  kShort = 3,
  kLong = 4,
  kRational = 5,
  kByte = 1,
  kUndefined = 7,
  kLong8 = 16
};

enum Tag : std::uint16_t {
  kImageWidth = 256,
  kImageLength = 257,
  kBitsPerSample = 258,
  kCompression = 259,
  kPhotometric = 262,
  kImageDescription = 270,
  kMake = 271,
  kModel = 272,
  kStripOffsets = 273,
  kOrientation = 274,
  kSamplesPerPixel = 277,
  kRowsPerStrip = 278,
  kStripByteCounts = 279,
  kXResolution = 282,
  kYResolution = 283,
  kPlanarConfiguration = 284,
  kResolutionUnit = 296,
  kSoftware = 305,
  kDateTime = 306,
  kExtraSamples = 338,
  kSampleFormat = 339,
  kXmp = 700,
  kIccProfile = 34675
};

// Readers decode strip by strip; this size keeps both their number and their buffers small.
constexpr std::uint64_t kStripBytes = 512u << 10;
// Pixels start on a page, so that they can be mapped.
constexpr std::uint64_t kDataAlignment = 4096;

// Little endian whatever the machine is.
void append(std::vector<std::byte>& out, std::uint64_t value, int n_bytes) {
  for (int i = 0; i < n_bytes; ++i) {
    out.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xFFu));
  }
}

struct Field {
  Tag tag;
  Type type;
  std::uint64_t count;
  std::vector<std::byte> value;
  std::uint64_t reserved_bytes = 0;  // room outside the directory; 0 = as the value needs
  std::uint64_t place = 0;           // offset of that room in the file; 0 = none
};

Field shorts(Tag tag, const std::vector<std::uint16_t>& values) {
  Field field{tag, kShort, values.size(), {}};
  for (const auto value : values) append(field.value, value, 2);
  return field;
}

Field one_long(Tag tag, std::uint64_t value) {
  Field field{tag, kLong, 1, {}};
  append(field.value, value, 4);
  return field;
}

Field rational(Tag tag, double value) {
  Field field{tag, kRational, 1, {}};
  const bool whole = value == std::floor(value);
  const std::uint64_t denominator = whole ? 1 : 10000;
  append(field.value,
         static_cast<std::uint64_t>(std::llround(value * static_cast<double>(denominator))), 4);
  append(field.value, denominator, 4);
  return field;
}

Field bytes(Tag tag, Type type, std::span<const std::byte> value) {
  return {tag, type, value.size(), {value.begin(), value.end()}};
}

// The TIFF type holds 7-bit text only; the full text stands in the XMP packet.
Field ascii(Tag tag, std::string_view text) {
  Field field{tag, kAscii, text.size() + 1, {}};
  for (const char c : text) {
    field.value.push_back(static_cast<std::byte>(c >= ' ' && c <= '~' ? c : '?'));
  }
  field.value.push_back(std::byte{0});
  return field;
}

int n_strips_of(const MasterLayout& layout, int n_lines) {
  return n_lines == 0 ? 0 : layout.strip_of(n_lines - 1) + 1;
}

int table_entry_bytes(const MasterLayout& layout) { return layout.big ? 8 : 4; }

std::uint64_t strip_bytes(const MasterLayout& layout, int strip, int n_lines) {
  const int first = strip * layout.rows_per_strip;
  const int rows = std::clamp(n_lines - first, 0, layout.rows_per_strip);
  return static_cast<std::uint64_t>(rows) * layout.bytes_per_row;
}

// Entries [0, n_strips) of both tables when n_lines lines are in the file.
std::pair<Field, Field> strip_tables(const MasterLayout& layout, int n_strips, int n_lines) {
  const Type type = layout.big ? kLong8 : kLong;
  const int entry = table_entry_bytes(layout);
  const auto all = static_cast<std::uint64_t>(n_strips_of(layout, layout.format.n_lines));
  const auto reserved = all * static_cast<std::uint64_t>(entry);
  const auto count = static_cast<std::uint64_t>(n_strips);
  Field offsets{kStripOffsets, type, count, {}, reserved};
  Field counts{kStripByteCounts, type, count, {}, reserved};
  for (int strip = 0; strip < n_strips; ++strip) {
    append(offsets.value, layout.row_offset(strip * layout.rows_per_strip), entry);
    append(counts.value, strip_bytes(layout, strip, n_lines), entry);
  }
  return {std::move(offsets), std::move(counts)};
}

// All fields, sorted by tag, with their places. `n_strips` entries of the strip tables.
std::vector<Field> make_fields(const MasterLayout& layout, int n_strips, int n_lines) {
  const LineFormat& format = layout.format;
  const MasterTags& tags = layout.tags;
  const std::size_t samples = format.channels.size();
  const bool rgb = samples >= 3;
  const std::size_t colours = rgb ? 3 : 1;
  const bool has_dpi = format.x_dpi > 0 && format.y_dpi > 0;
  auto [offsets, counts] = strip_tables(layout, n_strips, n_lines);

  std::vector<Field> fields;
  fields.push_back(one_long(kImageWidth, static_cast<std::uint64_t>(format.width_px)));
  fields.push_back(one_long(kImageLength, static_cast<std::uint64_t>(n_lines)));
  fields.push_back(shorts(kBitsPerSample, std::vector<std::uint16_t>(samples, 16)));
  fields.push_back(shorts(kCompression, {1}));
  fields.push_back(shorts(kPhotometric, {static_cast<std::uint16_t>(rgb ? 2 : 1)}));
  if (!tags.description.empty()) fields.push_back(ascii(kImageDescription, tags.description));
  if (!tags.make.empty()) fields.push_back(ascii(kMake, tags.make));
  if (!tags.model.empty()) fields.push_back(ascii(kModel, tags.model));
  fields.push_back(std::move(offsets));
  fields.push_back(shorts(kOrientation, {1}));
  fields.push_back(shorts(kSamplesPerPixel, {static_cast<std::uint16_t>(samples)}));
  fields.push_back(one_long(kRowsPerStrip, static_cast<std::uint64_t>(layout.rows_per_strip)));
  fields.push_back(std::move(counts));
  fields.push_back(rational(kXResolution, has_dpi ? format.x_dpi : 1));
  fields.push_back(rational(kYResolution, has_dpi ? format.y_dpi : 1));
  fields.push_back(shorts(kPlanarConfiguration, {1}));
  fields.push_back(shorts(kResolutionUnit, {static_cast<std::uint16_t>(has_dpi ? 2 : 1)}));
  if (!tags.software.empty()) fields.push_back(ascii(kSoftware, tags.software));
  if (!tags.date_time.empty()) fields.push_back(ascii(kDateTime, tags.date_time));
  if (samples > colours) {
    fields.push_back(shorts(kExtraSamples, std::vector<std::uint16_t>(samples - colours, 0)));
  }
  fields.push_back(shorts(kSampleFormat, std::vector<std::uint16_t>(samples, 1)));
  if (!tags.xmp.empty()) {
    fields.push_back(bytes(kXmp, kByte, std::as_bytes(std::span(tags.xmp))));
  }
  if (!tags.icc.empty()) fields.push_back(bytes(kIccProfile, kUndefined, tags.icc));

  const std::size_t inline_bytes = layout.big ? 8 : 4;
  std::uint64_t place = kMasterHeadBytes;
  for (Field& field : fields) {
    const std::uint64_t room = field.reserved_bytes > 0            ? field.reserved_bytes
                               : field.value.size() > inline_bytes ? field.value.size()
                                                                   : 0;
    if (room == 0) continue;
    field.place = place;
    place += (room + 7) / 8 * 8;
  }
  return fields;
}

std::uint64_t end_of_values(const std::vector<Field>& fields) {
  std::uint64_t end = kMasterHeadBytes;
  for (const Field& field : fields) {
    if (field.place == 0) continue;
    const std::uint64_t room = std::max<std::uint64_t>(field.reserved_bytes, field.value.size());
    end = std::max(end, field.place + room);
  }
  return end;
}

MasterLayout plan_as(const LineFormat& format, MasterTags tags, bool big) {
  MasterLayout layout;
  layout.format = format;
  layout.tags = std::move(tags);
  layout.big = big;
  layout.bytes_per_row = format.samples_per_line() * sizeof(std::uint16_t);
  layout.rows_per_strip = static_cast<int>(std::clamp<std::uint64_t>(
      kStripBytes / layout.bytes_per_row, 1, static_cast<std::uint64_t>(format.n_lines)));
  const auto fields = make_fields(layout, 0, 0);
  for (const Field& field : fields) {
    if (field.tag == kStripOffsets) layout.offsets_table = field.place;
    if (field.tag == kStripByteCounts) layout.counts_table = field.place;
  }
  layout.data_offset =
      (end_of_values(fields) + kDataAlignment - 1) / kDataAlignment * kDataAlignment;
  layout.total_bytes = layout.row_offset(format.n_lines);
  return layout;
}

}  // namespace

MasterLayout plan_master(const LineFormat& format, MasterTags tags,
                         std::uint64_t bigtiff_above_bytes) {
  if (format.width_px < 1 || format.n_lines < 1 || format.channels.empty()) {
    throw InputError("A scan without pixels, lines or channels cannot be written as a file.");
  }
  MasterLayout layout = plan_as(format, tags, false);
  if (layout.total_bytes > bigtiff_above_bytes) layout = plan_as(format, std::move(tags), true);
  return layout;
}

std::vector<std::byte> encode_master_head(const MasterLayout& layout, int n_lines) {
  CHECK(n_lines >= 1 && n_lines <= layout.format.n_lines);
  const auto fields = make_fields(layout, n_strips_of(layout, n_lines), n_lines);
  const int word = layout.big ? 8 : 4;
  std::vector<std::byte> head;
  append(head, 0x4949, 2);
  append(head, layout.big ? 43 : 42, 2);
  if (layout.big) append(head, 8, 4);
  append(head, layout.big ? 16 : 8, word);
  append(head, fields.size(), layout.big ? 8 : 2);
  for (const Field& field : fields) {
    append(head, field.tag, 2);
    append(head, field.type, 2);
    append(head, field.count, word);
    if (field.value.size() > static_cast<std::size_t>(word)) {
      append(head, field.place, word);
    } else {
      head.insert(head.end(), field.value.begin(), field.value.end());
      append(head, 0, word - static_cast<int>(field.value.size()));
    }
  }
  append(head, 0, word);  // no further directory
  CHECK(head.size() <= kMasterHeadBytes);
  head.resize(kMasterHeadBytes);
  return head;
}

std::vector<std::byte> encode_master_values(const MasterLayout& layout, int n_lines) {
  CHECK(n_lines >= 0 && n_lines <= layout.format.n_lines);
  std::vector<std::byte> out(layout.data_offset - kMasterHeadBytes);
  for (const Field& field :
       make_fields(layout, n_strips_of(layout, layout.format.n_lines), n_lines)) {
    if (field.place == 0) continue;
    std::ranges::copy(field.value,
                      out.begin() + static_cast<std::ptrdiff_t>(field.place - kMasterHeadBytes));
  }
  return out;
}

MasterPatch encode_strip_counts(const MasterLayout& layout, int first_line, int n_lines) {
  CHECK(first_line >= 0 && first_line < n_lines && n_lines <= layout.format.n_lines);
  const int entry = table_entry_bytes(layout);
  const int first_strip = layout.strip_of(first_line);
  MasterPatch patch;
  patch.offset = layout.counts_table +
                 static_cast<std::uint64_t>(first_strip) * static_cast<std::uint64_t>(entry);
  for (int strip = first_strip; strip < n_strips_of(layout, n_lines); ++strip) {
    append(patch.bytes, strip_bytes(layout, strip, n_lines), entry);
  }
  return patch;
}

}  // namespace reseau
