#include "drivers/coolscan/pages.h"

#include <algorithm>

namespace reseau::coolscan {
namespace {

// Walks one page. Past the end every field is 0.
class PageWalker {
 public:
  explicit PageWalker(ByteView page) {
    constexpr std::size_t kHead = 4;
    if (page.size() <= kHead) return;
    rest_ = page.subspan(kHead, std::min<std::size_t>(page.size() - kHead, u8_at(page, 3)));
  }

  std::uint32_t number(std::size_t n_bytes) {
    if (rest_.size() < n_bytes) {
      rest_ = {};
      return 0;
    }
    const auto value = static_cast<std::uint32_t>(load_be(rest_, 0, n_bytes));
    skip(n_bytes);
    return value;
  }
  int integer(std::size_t n_bytes) {
    // No address of a real unit comes near 2^31; a nonsensical page must not become negative.
    return static_cast<int>(std::min<std::uint32_t>(number(n_bytes), 0x7FFFFFFF));
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(number(1)); }
  void skip(std::size_t n_bytes) { rest_ = rest_.subspan(std::min(n_bytes, rest_.size())); }
  // A field of one byte that another byte of the same field follows while b7 is set.
  std::vector<std::uint8_t> chain() {
    std::vector<std::uint8_t> field;
    do {
      field.push_back(byte());
    } while ((field.back() & 0x80) != 0 && !rest_.empty());
    return field;
  }
  [[nodiscard]] bool ended() const { return rest_.empty(); }
  [[nodiscard]] ByteView rest() const { return rest_; }

 private:
  ByteView rest_;
};

std::string text_of(ByteView bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    const char c = static_cast<char>(b);
    if (c == 0) break;
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

bool bit(const std::vector<std::uint8_t>& chain, std::size_t byte, int bit_number) {
  return byte < chain.size() && (chain[byte] >> bit_number & 1) != 0;
}

}  // namespace

StandardInquiry parse_standard_inquiry(ByteView data) {
  CHECK(data.size() >= 36);
  return {text_of(data.subspan(8, 8)), text_of(data.subspan(16, 16)), text_of(data.subspan(32, 4))};
}

std::vector<std::uint8_t> parse_page_list(ByteView page) {
  std::vector<std::uint8_t> codes;
  for (const std::byte code : PageWalker(page).rest()) {
    codes.push_back(std::to_integer<std::uint8_t>(code));
  }
  return codes;
}

std::string parse_name_page(ByteView page) {
  PageWalker walker(page);
  const std::size_t length = walker.byte();
  return text_of(walker.rest().first(std::min(length, walker.rest().size())));
}

AddressPage parse_addresses(ByteView page) {
  PageWalker walker(page);
  AddressPage a;
  const std::uint8_t transfer_rules = walker.chain().front();
  a.whole_lines = (transfer_rules & 0x02) != 0;
  a.whole_frames = (transfer_rules & 0x08) != 0;
  walker.skip(2);  // window descriptor length
  walker.skip(2);  // SET PARAMETER length
  walker.skip(2);  // general transfer buffer
  walker.skip(2);  // image buffer
  walker.skip(2);  // units, adapter name page
  a.holder_id = walker.byte();
  const std::uint8_t order = walker.byte();
  a.pitch_rule = static_cast<PitchRule>(order & 0x03);
  a.thumbnails_reversed = (order & 0x10) != 0;
  a.has_frame_page = (order & 0x40) != 0;
  const std::uint8_t positions = walker.byte();
  a.film_addresses = (positions & 0x01) != 0;
  a.one_frame_per_window = (positions & 0x04) != 0;
  a.optical_dpi = walker.integer(2);
  a.max_dpi = walker.integer(2);
  a.min_dpi = walker.integer(2);
  a.x_origin_max_px = walker.integer(4);
  a.x_origin_min_px = walker.integer(4);
  walker.skip(4);  // X offset of the first image
  a.max_width_px = walker.integer(4);
  walker.skip(6);  // Y optical, maximum, minimum resolution: as X on every USB unit
  a.y_origin_max_px = walker.integer(4);
  a.y_origin_min_px = walker.integer(4);
  walker.skip(4);  // Y offset of the first image
  a.max_height_px = walker.integer(4);
  walker.skip(8);  // reach of the film outside the addresses
  a.thumbnail_dpi = walker.integer(2);
  walker.skip(2);  // the lowest one
  a.frame_capacity = walker.integer(1);
  a.frames_present = walker.integer(1);
  a.focus_min = walker.integer(2);
  a.focus_max = walker.integer(2);
  walker.skip(2);  // lamp warm-up
  a.converter_bits = walker.integer(1);
  a.sensor_pixels = walker.integer(2);
  // An LS-40 page ends here, that of an LS-8000 one field later.
  if (!walker.ended()) a.line_gap = walker.integer(1);
  if (!walker.ended()) a.sensor_lines = walker.integer(1);
  a.unread_bytes = walker.rest().size();
  return a;
}

WindowPage parse_window_abilities(ByteView page) {
  PageWalker walker(page);
  WindowPage w;
  w.kinds = walker.chain().front();
  w.modes = walker.byte();
  w.interleavings = walker.byte();
  walker.skip(1);  // composition
  walker.skip(2);  // colours by position
  w.depths = walker.byte();
  walker.skip(walker.byte());  // setup modes
  walker.skip(1);              // digital control
  walker.skip(walker.byte());  // its block
  walker.skip(1);              // analog controls
  const std::size_t analog_bytes = walker.byte();
  if (analog_bytes >= 9) {
    walker.skip(1);  // bytes per value
    w.exposure_min_10ns = std::max<std::uint32_t>(walker.number(4), 1);
    w.exposure_max_10ns = walker.number(4);
    walker.skip(analog_bytes - 9);
  } else {
    walker.skip(analog_bytes);
  }
  walker.skip(3);  // filter, matrix, halftone
  w.unread_bytes = walker.rest().size();
  return w;
}

std::vector<int> WindowPage::depths_bits() const {
  static constexpr int kBits[] = {1, 8, 10, 12, 14, 16};
  std::vector<int> bits;
  for (std::size_t i = 1; i < std::size(kBits); ++i) {
    if ((depths >> i & 1) != 0) bits.push_back(kBits[i]);
  }
  return bits;
}

DutyPage parse_duties(ByteView page) {
  PageWalker walker(page);
  DutyPage e;
  const std::vector<std::uint8_t> duties = walker.chain();
  const std::vector<std::uint8_t> types = walker.chain();
  e.averages_readings = bit(duties, 0, 1);
  e.remove_padding = bit(duties, 1, 2);
  e.look_up_table = bit(types, 0, 3);
  e.white_balance_exposure = bit(types, 3, 3);
  e.frame_rectangles = bit(types, 2, 6);
  e.perforations = bit(types, 3, 6);
  e.frame_table = bit(types, 4, 0);
  e.set_frame_table = bit(types, 4, 1);
  e.ccd_curves = bit(types, 4, 3) && bit(duties, 1, 3);
  walker.skip(1);  // halftone
  e.table_in_bits = walker.integer(1);
  e.table_out_bits = walker.integer(1);
  walker.skip(6);  // bits of histogram, maximum, matrix, filter, shading, dark data
  for (std::uint8_t& group : e.operations) {
    group = walker.byte();
    walker.skip(1);
  }
  walker.skip(3);  // exchange of adapters, scratch memories
  e.unread_bytes = walker.rest().size();
  return e;
}

int sensor_lines(const AddressPage& addresses, const WindowPage& windows) {
  if (!windows.multi_line()) return 1;
  constexpr int kUnsaid = 3;  // LS-9000 interface specification: absent means three
  return std::clamp(addresses.sensor_lines > 0 ? addresses.sensor_lines : kUnsaid, 1, kUnsaid);
}

}  // namespace reseau::coolscan
