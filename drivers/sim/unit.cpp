#include "drivers/sim/unit.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/check.h"
#include "drivers/sim/film/make_film.h"

namespace reseau::sim {
namespace {

constexpr int kStartUpPolls = 3;
constexpr std::size_t kMaxAttentions = 16;
constexpr std::array<std::uint8_t, 6> kBasic{0x00, 0x03, 0x12, 0x16, 0x17, 0x1a};

bool is_one_of(std::uint8_t opcode, std::initializer_list<std::uint8_t> list) {
  return std::ranges::find(list, opcode) != list.end();
}

bool is_basic(std::uint8_t opcode) { return std::ranges::find(kBasic, opcode) != kBasic.end(); }

bool is_known(std::uint8_t opcode) {
  return is_basic(opcode) ||
         is_one_of(opcode, {0x15, 0x1b, 0x1d, 0x24, 0x25, 0x28, 0x2a, 0xc0, 0xc1, 0xe0, 0xe1});
}

CommandReply data_in(Bytes data, std::size_t asked) {
  if (data.size() > asked) data.resize(asked);
  if (data.empty()) return CommandReply::status(kGood);
  return {.next = CommandReply::Next::kDataIn, .in = std::move(data)};
}

CommandReply data_out_of(std::size_t bytes) {
  if (bytes == 0) return CommandReply::status(kGood);
  return {.next = CommandReply::Next::kDataOut, .out_bytes = bytes};
}

// A display gamma, as a picture program would leave it.
LookupTables old_luts(const UnitModel& model) {
  LookupTables tables;
  const int full = (1 << model.adc_bits) - 1;
  for (auto& table : tables) {
    table.resize(static_cast<std::size_t>(full) + 1);
    for (int v = 0; v <= full; ++v) {
      const double level = std::pow(static_cast<double>(v) / full, 1 / 2.2);
      table[static_cast<std::size_t>(v)] = static_cast<std::uint16_t>(std::lround(level * full));
    }
  }
  return tables;
}

}  // namespace

Unit::Unit(const SimSpec& spec, int packet_bytes)
    : spec_(spec),
      model_(&unit_model(spec.model)),
      packet_bytes_(packet_bytes),
      film_(make_film(spec.film)),
      windows_(*model_),
      frames_(*model_, 1, 1) {
  adapter_.model = model_;
  adapter_.kind = spec.unit.adapter;
  if (spec.unit.adapter == AdapterKind::kDefault) {
    const bool roll = model_->sensor_lines == 2;
    adapter_.kind = roll ? AdapterKind::kSa30 : AdapterKind::kSa21;
  }
  slides_left_ = spec.unit.feeder_slides;
  if (spec.unit.old_lut && model_->has_lut) luts_ = old_luts(*model_);
  power_on();
  film_polls_ = spec.unit.film_arrives_polls;
  const bool waits = adapter_.kind == AdapterKind::kFeeder || adapter_.kind == AdapterKind::kNone;
  if (film_polls_ == 0 && spec.film.kind != FilmKind::kEmpty && !waits) insert_film();
  if (spec.unit.cold) start_up_polls_ = kStartUpPolls;
  attentions_.clear();  // another program has seen them, unless the unit is cold
}

FrameTable Unit::new_frames() const {
  return {*model_, adapter_.capacity(), adapter_.frame_height()};
}

Sense Unit::without_film() const {
  if (adapter_.kind == AdapterKind::kNone) return kNoAdapter;
  return adapter_.kind == AdapterKind::kFeeder ? kNoSlide : kNoMedium;
}

void Unit::power_on() {
  abort_all();
  mud_ = 1200;
  windows_ = WindowStore(*model_);
  frames_ = new_frames();
  rectangles_.clear();
  adapter_.counted_frames = 0;
  focus_ = 15;  // as a unit reported it before any film was loaded
  stage_ = 0;
  unload_seconds_ = 600;
  unload_on_ = 1;
}

void Unit::abort_all() {
  operation_.reset();
  end_scan();
}

void Unit::attend(const Sense& attention) {
  if (attentions_.size() < kMaxAttentions) attentions_.push_back(attention);
}

CommandReply Unit::command(ByteView cdb) {
  CHECK(cdb.size() == 6 || cdb.size() == 10);
  const std::uint8_t opcode = cdb[0];
  CommandReply reply;
  if (const std::optional<Sense> sense = refusal(opcode, cdb)) {
    reply = CommandReply::status(*sense);
  } else {
    reply = dispatch(cdb);
  }
  if (reply.next == CommandReply::Next::kDataOut) {
    pending_cdb_.assign(cdb.begin(), cdb.end());
  } else if (opcode != 0x03) {
    last_sense_ = reply.sense;
  }
  return reply;
}

std::optional<Sense> Unit::refusal(std::uint8_t opcode, ByteView cdb) {
  const bool ten_bytes = opcode >= 0x20 && opcode != 0xc0 && opcode != 0xc1;
  if (!is_known(opcode)) return kBadOpcode;
  if (cdb.size() != (ten_bytes ? 10U : 6U)) return kBadCdb;
  if (cdb[1] >> 5 != 0 && opcode != 0x12) return kBadLun;
  if (start_up_polls_ > 0 && !is_basic(opcode)) return kNotSelfConfigured;
  if (!attentions_.empty() && !is_one_of(opcode, {0x03, 0x12, 0x1d})) {
    const Sense sense = attentions_.front();
    attentions_.pop_front();
    return sense;
  }
  if (jammed_ && !is_one_of(opcode, {0x03, 0x12, 0x1d, 0x16, 0x17})) return kJammed;
  if (operation_ && !is_basic(opcode) && opcode != 0xc0) {
    abort_all();
    return kBadSequence;
  }
  if (stream_ && !is_basic(opcode) && !is_one_of(opcode, {0xc0, 0x25, 0x28})) {
    abort_all();
    return kBadSequence;
  }
  return std::nullopt;
}

CommandReply Unit::dispatch(ByteView cdb) {
  switch (cdb[0]) {
    case 0x00:
      return CommandReply::status(poll());
    case 0x03:
      return request_sense(cdb);
    case 0x12:
      return inquiry(cdb);
    case 0x15:
      return mode_select(cdb);
    case 0x1a:
      return mode_sense(cdb);
    case 0x1b: {
      if (cdb[4] > 4) return CommandReply::status(kBadCdb);
      if (cdb[4] == 0) return CommandReply::status(scan({}));
      return data_out_of(cdb[4]);
    }
    case 0x1d: {
      if (cdb[1] != 0x04) return CommandReply::status(kBadCdb);
      const Sense sense = deferred_error_;
      deferred_error_ = kGood;
      return CommandReply::status(sense);
    }
    case 0x24: {
      const std::size_t length = get24(cdb, 6);
      if (length > static_cast<std::size_t>(model_->descriptor_list_bytes)) {
        return CommandReply::status(kBadCdb);
      }
      return data_out_of(length);
    }
    case 0x25:
      return get_window(cdb);
    case 0x28:
      return read(cdb);
    case 0x2a:
      return send(cdb);
    case 0xc0:
      abort_all();
      return CommandReply::status(kGood);
    case 0xc1:
      return CommandReply::status(execute());
    case 0xe0:
      return set_parameter(cdb);
    case 0xe1:
      return get_parameter(cdb);
    default:
      return CommandReply::status(kGood);  // RESERVE, RELEASE
  }
}

Sense Unit::data_out(ByteView data) {
  CHECK(!pending_cdb_.empty());
  const Bytes cdb = std::move(pending_cdb_);
  pending_cdb_.clear();
  Sense sense;
  switch (cdb[0]) {
    case 0x15:
      sense = mode_select_data(data);
      break;
    case 0x1b:
      sense = scan(data);
      break;
    case 0x24:
      sense = windows_.set(data, adapter_, mud_, (cdb[9] & 0x80) != 0);
      requests_open_ = false;  // cooperation is negotiated anew for changed windows
      break;
    case 0x2a:
      sense = send_data(cdb[2], cdb[4], data);
      break;
    case 0xe0: {
      const OperationParameters parameters = parse_operation(cdb[2], data);
      sense = check_operation(parameters, *model_,
                              std::max(adapter_.max_y_origin(), adapter_.frame_height() - 1));
      if (sense.good()) parameters_ = parameters;
      break;
    }
    default:
      CHECK(false);
  }
  last_sense_ = sense;
  return sense;
}

Sense Unit::poll() {
  if (start_up_polls_ > 0) return poll_start_up();
  if (operation_) {
    if (operation_->polls_left > 0) {
      --operation_->polls_left;
      return operation_->busy;
    }
    const std::uint8_t code = operation_->code;
    operation_.reset();
    finish_operation(code);
    if (!deferred_error_.good()) return kOperationFailed;
    if (!attentions_.empty()) {
      const Sense sense = attentions_.front();
      attentions_.pop_front();
      return sense;
    }
  }
  const bool any_film = spec_.film.kind != FilmKind::kEmpty;
  if (any_film && !adapter_.film_present && film_polls_ > 0 && --film_polls_ == 0) {
    operation_ = Operation{kFilmMoves, spec_.unit.busy_polls, 0xd1};
  }
  return adapter_.film_present ? kGood : without_film();
}

Sense Unit::poll_start_up() {
  if (--start_up_polls_ == 0) attend(kPowerOn);
  return kNotInitialised;
}

CommandReply Unit::inquiry(ByteView cdb) const {
  const std::size_t asked = cdb[4];
  if (cdb[1] >> 5 != 0) {
    Bytes nobody = standard_inquiry(*model_);
    nobody[0] = 0x7f;
    return data_in(std::move(nobody), asked);
  }
  if ((cdb[1] & 1) == 0) {
    if (cdb[2] != 0) return CommandReply::status(kBadCdb);
    return data_in(standard_inquiry(*model_), asked);
  }
  std::optional<Bytes> page = vital_page(*model_, adapter_, cdb[2]);
  if (!page) return CommandReply::status(kBadCdb);
  return data_in(std::move(*page), asked);
}

CommandReply Unit::request_sense(ByteView cdb) const {
  Bytes reply(19, 0);
  reply[0] = 0x70;
  reply[2] = static_cast<std::uint8_t>(last_sense_.key | (last_sense_.ili ? 0x20 : 0));
  reply[7] = 0x0b;
  reply[12] = last_sense_.asc;
  reply[13] = last_sense_.ascq;
  reply[15] = last_sense_.tsc;
  return data_in(std::move(reply), cdb[4]);
}

CommandReply Unit::mode_sense(ByteView cdb) const {
  const int control = cdb[2] >> 6, page = cdb[2] & 0x3f;
  if (control == 3) return CommandReply::status(kSavingParameters);
  if (page != 0x03 && page != 0x3f) return CommandReply::status(kBadCdb);
  const bool with_block = (cdb[1] & 0x08) == 0;
  Bytes reply = from_hex(with_block ? "13 00 00 08 00 000000 00 000001" : "0B 00 00 00");
  append(reply, from_hex("03 06 00 00"));
  const int current = control == 0 ? mud_ : 1200;
  put16(reply, control == 1 ? 0xffff : static_cast<std::uint32_t>(current));
  put16(reply, 0);
  return data_in(std::move(reply), cdb[4]);
}

CommandReply Unit::mode_select(ByteView cdb) const {
  if ((cdb[1] & 0x11) != 0x10) return CommandReply::status(kBadCdb);
  if (!is_one_of(cdb[4], {0x00, 0x04, 0x0c, 0x14})) return CommandReply::status(kListLength);
  return data_out_of(cdb[4]);
}

Sense Unit::mode_select_data(ByteView data) {
  const std::size_t block = data[3];
  if (data.size() == 4) return block == 0 ? kGood : kBadParameter;
  if (block != (data.size() == 0x14 ? 8U : 0U)) return kBadParameter;
  const ByteView page = data.subspan(4 + block);
  if (page[0] != 0x03 || page[1] != 0x06) return kBadParameter;
  const auto mud = static_cast<int>(get16(page, 4));
  if (mud != 1200 && mud != model_->optical_dpi) return kBadParameter;
  mud_ = mud;
  return kGood;
}

CommandReply Unit::get_window(ByteView cdb) const {
  const std::size_t asked = get24(cdb, 6);
  if ((cdb[1] & 1) == 0 && cdb[5] == 0) {
    Bytes all = windows_.reply_all();
    if (model_->all_windows_only && asked > all.size()) return CommandReply::status(kBadCdb);
    return data_in(std::move(all), asked);
  }
  if (model_->all_windows_only) return CommandReply::status(kBadCdb);
  if (cdb[5] == 9 && (cdb[9] & 0x80) == 0 && !model_->page_d1.empty()) {
    return CommandReply::status(kBadCdb);
  }
  std::optional<Bytes> reply = windows_.reply_one(cdb[5]);
  if (!reply) return CommandReply::status(kBadCdb);
  return data_in(std::move(*reply), asked);
}

}  // namespace reseau::sim
