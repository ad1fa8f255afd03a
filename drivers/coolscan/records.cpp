#include "drivers/coolscan/records.h"

namespace reseau::coolscan {
namespace {

constexpr std::size_t kHead = 6;
constexpr std::size_t kLineRecordBytes = 18;
constexpr std::size_t kPaddingRecordBytes = 27;

PaddingRecord parse_padding(ByteView r) {
  const int flags = u8_at(r, 5);
  const auto field = [&](int flag, std::size_t offset) {
    return (flags >> flag & 1) != 0 ? static_cast<int>(load_be(r, offset, 2)) : 0;
  };
  PaddingRecord padding{field(0, 7),  field(1, 9),  field(2, 11), field(3, 13),
                        field(6, 19), field(7, 21), std::nullopt};
  if ((flags >> 5 & 1) != 0) padding.infrared_after_bytes = field(5, 17);
  return padding;
}

}  // namespace

std::optional<CooperationRecord> parse_cooperation(ByteView data) {
  if (data.size() < kHead + kLineRecordBytes) return std::nullopt;
  const ByteView r = data.subspan(kHead);
  const auto number = [&](std::size_t offset, std::size_t n) {
    return static_cast<int>(load_be(r, offset, n));
  };
  switch (u8_at(r, 0)) {
    case 1:
    case 2:
    case 4:
      return LineRecord{number(0, 1),  number(5, 2),  number(7, 2), number(9, 1),
                        number(10, 2), number(12, 1), number(13, 2)};
    case 6:
      if (r.size() < kPaddingRecordBytes) return std::nullopt;
      return parse_padding(r);
    case 7: {
      CurveRecord record;
      for (std::size_t i = 5; i <= 12; ++i) record.curve_types.push_back(number(i, 1));
      return record;
    }
    default:
      return std::nullopt;
  }
}

}  // namespace reseau::coolscan
