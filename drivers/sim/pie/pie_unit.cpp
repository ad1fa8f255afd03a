#include "drivers/sim/pie/pie_unit.h"

#include <algorithm>
#include <utility>

#include "drivers/sim/film/make_film.h"

namespace reseau::sim::pie {
namespace {

constexpr PieSense kUnknownCommand{0x05, 0x20, 0x00};
constexpr PieSense kBadParameter{0x05, 0x26, 0x00}, kOutOfOrder{0x05, 0x2c, 0x00};
constexpr PieSense kListLength{0x06, 0x1a, 0x00}, kPowerOn{0x06, 0x29, 0x00};
constexpr PieSense kWarmingUp{0x02, 0x04, 0x01};

constexpr int kWarmUpPolls = 5;

void set16le(Bytes& in, std::size_t at, int v) {
  in[at] = static_cast<std::uint8_t>(v & 0xff);
  in[at + 1] = static_cast<std::uint8_t>(v >> 8 & 0xff);
}
int get16le(ByteView from, std::size_t at) { return from[at] | from[at + 1] << 8; }

void set_text(Bytes& in, std::size_t at, std::size_t n, std::string_view text) {
  for (std::size_t i = 0; i < n; ++i)
    in[at + i] = static_cast<std::uint8_t>(i < text.size() ? text[i] : ' ');
}

PieReply data_in(Bytes bytes) { return {.next = PieReply::Next::kDataIn, .in = std::move(bytes)}; }

PieReply first_bytes(Bytes bytes, std::size_t length) {
  bytes.resize(length);
  return data_in(std::move(bytes));
}

}  // namespace

PieUnit::PieUnit(const PieModel& model, const SimSpec& spec)
    : model_(model),
      spec_(spec),
      film_(make_film(spec.film)),
      sensor_(model, spec.sensor, spec.film.seed),
      film_present_(spec.film.kind != FilmKind::kEmpty),
      power_on_notice_(spec.unit.cold),
      warm_polls_(spec.unit.cold ? kWarmUpPolls + spec.unit.busy_polls : 0),
      again_left_(spec.unit.again),
      calibrated_(false),
      exposure_(model.exposure),
      gain_(model.gain) {}

PieReply PieUnit::check(const PieSense& sense) {
  sense_ = sense;
  return {.sense = sense};
}

std::optional<PieSense> PieUnit::refusal(std::uint8_t opcode) {
  const bool always = opcode == 0x12 || opcode == 0x03 || opcode == 0xdd;
  if (!always && power_on_notice_) {
    power_on_notice_ = false;
    return kPowerOn;
  }
  const bool needs_lamp = opcode == 0x00 || opcode == 0x1b;
  if (needs_lamp && warm_polls_ > 0) {
    --warm_polls_;
    return kWarmingUp;
  }
  // A pass that was begun is read before anything else is set.
  const bool changes =
      opcode == 0x0a || opcode == 0x15 || opcode == 0x1b || opcode == 0xd1 || opcode == 0xdc;
  // But for exposures before its calibration (SANE's pieusb backend).
  const bool before_calibration = calibration_lines_ > 0 && calibration_at_ == 0;
  if (changes && pass_open() && !(opcode == 0xdc && before_calibration)) return kOutOfOrder;
  return std::nullopt;
}

PieReply PieUnit::command(ByteView cdb) {
  const std::uint8_t opcode = cdb[0];
  const auto length = static_cast<std::size_t>(get16(cdb, 3));
  if (opcode == 0x03) {
    Bytes bytes(14);
    bytes[0] = 0x70;
    bytes[2] = sense_.key;
    bytes[7] = 6;
    bytes[12] = sense_.code;
    bytes[13] = sense_.qualifier;
    sense_ = {};
    if (length != bytes.size()) return check(kListLength);
    return data_in(std::move(bytes));
  }
  sense_ = {};
  if (opcode == 0x1b && length == 0) {
    if (model_.fragile) hang();
    stream_.reset();
    calibration_lines_ = 0;
    return {};
  }
  if (const auto refused = refusal(opcode)) return check(*refused);
  const auto take = [&](std::size_t n) -> PieReply {
    if (length != n) return check(kListLength);
    out_op_ = opcode;
    out_bytes_ = n;
    return {.next = PieReply::Next::kDataOut, .out_bytes = n};
  };
  switch (opcode) {
    case 0x00:
      return {.busy_polls = pass_open() ? 0 : std::min(spec_.unit.busy_polls, 2)};
    case 0x08:
      return read(static_cast<int>(length));
    case 0x0a:
      return length >= 4 && length <= 64 ? take(length) : check(kListLength);
    case 0x0f:
      return parameters(length);
    case 0x12:
      return inquiry(length);
    case 0x15:
      return take(16);
    case 0x18:
      return mask(length);
    case 0x1a:
      return length == 16 ? data_in(Bytes(16)) : check(kListLength);
    case 0x1b:
      return scan(static_cast<int>(length));
    case 0xd1:
      return model_.has_transport ? take(4) : check(kUnknownCommand);
    case 0xd2:
      // The motor runs against its stop.
      hang();
      return {};
    case 0xd7:
      return read_gain(length);
    case 0xdc:
      return take(29);
    case 0xdd:
      return read_state(length);
    default:
      return check(kUnknownCommand);
  }
}

PieSense PieUnit::data_out(ByteView data) {
  PieSense sense;
  switch (out_op_) {
    case 0x0a:
      sense = write(data);
      break;
    case 0x15:
      sense = mode_select(data);
      break;
    case 0xd1:
      sense = slide(data);
      break;
    case 0xdc:
      for (std::size_t c = 0; c < 3; ++c) {
        exposure_[c] = static_cast<std::uint16_t>(get16le(data, 2 * c));
        gain_[c] = data[12 + c];
      }
      exposure_[3] = static_cast<std::uint16_t>(get16le(data, 18));
      gain_[3] = data[22];
      if (pass_open() && !model_.own_calibration) begin_calibrated_image();
      break;
    default:
      break;
  }
  sense_ = sense;
  return sense;
}

PieReply PieUnit::inquiry(std::size_t length) {
  Bytes b(184);
  b[0] = 0x06;  // a scanner
  b[4] = 180;
  set_text(b, 8, 8, "PIE");
  set_text(b, 16, 16, model_.product);
  set_text(b, 32, 4, "1.70");
  set16le(b, 36, model_.max_dpi);
  set16le(b, 38, model_.max_dpi);
  set16le(b, 40, model_.width_px);
  set16le(b, 42, model_.height_px);
  b[44] = 0x9e;  // red green blue infrared, one pass
  b[45] = 0x35;  // 1, 8, 12, 16 bits
  b[46] = 0x07;
  b[50] = static_cast<std::uint8_t>((model_.confirms_frame ? 0x04 : 0) |
                                    (model_.has_transport ? 0x01 : 0) | 0x02);
  set16le(b, 54, 300);
  set_text(b, 96, 4, "1.70");
  set16le(b, 104, 0xffff);
  set16le(b, 106, 100);
  set16le(b, 112, model_.width_px);
  set16le(b, 114, model_.height_px);
  set16le(b, 116, model_.number);
  if (length > b.size()) return check(kListLength);
  return first_bytes(std::move(b), length);
}

PieReply PieUnit::read_state(std::size_t length) {
  if (length != 12 && length != 13) return check(kListLength);
  if (frame_counter_ != frame_target_ && frame_polls_-- <= 0) {
    frame_counter_ += frame_target_ > frame_counter_ ? 1 : -1;
    frame_polls_ = spec_.unit.busy_polls;
  }
  Bytes b(13);
  b[2] = static_cast<std::uint8_t>(frame_counter_);
  b[5] = warm_polls_ > 0 ? 1 : 0;
  if (warm_polls_ > 0) --warm_polls_;
  b[6] = pass_open() ? 1 : 0;
  b[8] = model_.reports_film && !film_present_ ? 1 : 0;
  return first_bytes(std::move(b), length);
}

PieReply PieUnit::read_gain(std::size_t length) {
  Bytes b(123);
  for (std::size_t c = 0; c < 3; ++c) {
    set16le(b, 54 + 2 * c, 0xffff);
    set16le(b, 60 + 2 * c, model_.exposure[c]);
    b[72 + c] = model_.gain[c];
  }
  b[75] = 4;
  set16le(b, 98, model_.exposure[3]);
  b[102] = model_.gain[3];
  if (length > b.size() || length < 103) return check(kListLength);
  return first_bytes(std::move(b), length);
}

PieSense PieUnit::write(ByteView data) {
  const int sub_command = get16le(data, 0);
  // SANE asks for the calibration info with two bytes that the length does not count.
  const bool asks = sub_command == 0x95 && data.size() == 6 && get16le(data, 2) == 0;
  if (!asks && get16le(data, 2) != static_cast<int>(data.size()) - 4) return kListLength;
  switch (sub_command) {
    case 0x12: {
      if (data.size() != 14) return kListLength;
      const Frame f{get16le(data, 6), get16le(data, 8), get16le(data, 10), get16le(data, 12)};
      const bool inside =
          f.x0 <= f.x1 && f.y0 <= f.y1 && f.x1 < model_.width_px && f.y1 <= model_.height_px;
      if (get16le(data, 4) != 0x80 || !inside) return kBadParameter;
      frame_ = f;
      frame_set_ = true;
      frame_confirmed_ = false;
      return {};
    }
    case 0x13:
    case 0x14:
      return data.size() == 8 ? PieSense{} : kListLength;
    case 0x17:
      if (data.size() != 6) return kListLength;
      // Belongs after the frame and before MODE SELECT.
      if (!frame_set_) return kOutOfOrder;
      frame_confirmed_ = get16le(data, 4) == 1;
      return {};
    case 0x95:
      info_prepared_ = true;
      return {};
    default:
      return kBadParameter;
  }
}

PieSense PieUnit::mode_select(ByteView data) {
  if (data[1] != 0x0f) return kListLength;
  Mode mode;
  mode.dpi = get16le(data, 2);
  mode.infrared = data[4] == 0x90;
  mode.two_bytes = data[5] == 0x20;
  mode.quality = static_cast<std::uint16_t>(get16le(data, 9));
  const bool known = (data[4] == 0x80 || data[4] == 0x90) && (data[5] == 0x20 || data[5] == 0x04) &&
                     data[6] == 0x04 && data[8] == 0x01;
  if (!known || mode.dpi <= 0 || mode.dpi > model_.max_dpi || model_.max_dpi % mode.dpi != 0) {
    return kBadParameter;
  }
  mode_ = mode;
  mode_set_ = true;
  return {};
}

PieSense PieUnit::slide(ByteView data) {
  constexpr double kUnitMm = 0.106, kExtraUnits = 1.84;
  switch (data[0]) {
    case 0x04:
      ++frame_target_;
      fine_move_mm_ = 0;
      return {};
    case 0x05:
      frame_target_ = std::max(0, frame_target_ - 1);
      fine_move_mm_ = 0;
      return {};
    case 0x10:
    case 0x40:
      return {};
    case 0x03:
      film_present_ = false;
      frame_counter_ = frame_target_ = 0;
      return {};
    case 0x00:
    case 0x01:
      if (data[3] != 4) return kBadParameter;
      if (data[1] > 0) {
        fine_move_mm_ += (data[0] == 0 ? 1 : -1) * kUnitMm * (data[1] + kExtraUnits);
      }
      return {};
    default:
      return kBadParameter;
  }
}

}  // namespace reseau::sim::pie
