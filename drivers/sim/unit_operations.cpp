// Operations of a unit: focus, film transport, timers.
#include <algorithm>

#include "drivers/sim/unit.h"

namespace reseau::sim {
namespace {

// Focus position as a unit reported it after loading film.
constexpr int kFocusAfterLoading = 192;

}  // namespace

CommandReply Unit::set_parameter(ByteView cdb) {
  const std::optional<std::size_t> fewest =
      operation_min_bytes(operation_groups(*model_, adapter_), cdb[2]);
  const std::size_t length = get24(cdb, 6);
  if (!fewest || length < *fewest || length > kMaxParameterBytes) {
    return CommandReply::status(kBadCdb);
  }
  if (length > 0) return {.next = CommandReply::Next::kDataOut, .out_bytes = length};
  parameters_ = parse_operation(cdb[2], {});
  return CommandReply::status(kGood);
}

CommandReply Unit::get_parameter(ByteView cdb) const {
  std::uint32_t first = 0, second = 0;
  switch (cdb[2]) {
    case kOpFocusAtLoad:
      first = focus_at_load_;
      break;
    case kOpAutofocus:
      first = focus_x_;
      second = focus_y_;
      break;
    case kOpUnloadTimer:
      first = unload_seconds_;
      second = unload_on_;
      break;
    case kOpMoveStage:
    case kOpPosition:
      first = stage_;
      break;
    case kOpMoveFocus:
      first = static_cast<std::uint32_t>(focus_);
      break;
    default:
      return CommandReply::status(kBadCdb);
  }
  const std::size_t length = get24(cdb, 6);
  if (length == 0 || length > kMaxParameterBytes) return CommandReply::status(kBadCdb);
  Bytes reply(kMaxParameterBytes, 0);
  set32(reply, 1, first);
  set32(reply, 5, second);
  reply.resize(length);
  return {.next = CommandReply::Next::kDataIn, .in = std::move(reply)};
}

Sense Unit::execute() {
  if (!parameters_) return kBadSequence;
  const OperationParameters p = *parameters_;
  parameters_.reset();
  const int polls = spec_.unit.busy_polls;
  switch (p.code) {
    case kOpFocusAtLoad:
      focus_at_load_ = p.first;
      return kGood;
    case kOpLock:
    case kOpDeviceData:
      return kGood;
    case kOpUnloadTimer:
      unload_seconds_ = p.first;
      unload_on_ = p.second;
      return kGood;
    case kOpAutofocus:
      if (!adapter_.film_present) return without_film();
      if (adapter_.strip() && !adapter_.holder() && !frames_.contains(p.second)) return kOutOfFocus;
      focus_x_ = p.first;
      focus_y_ = p.second;
      break;
    case kOpMoveStage:
    case kOpPosition:
      stage_ = p.first;
      break;
    case kOpMoveFocus:
      focus_ = static_cast<int>(p.first);
      break;
    case kOpLoad:
      if (adapter_.kind == AdapterKind::kFeeder && slides_left_ == 0) return kNoSlide;
      operation_ = Operation{kFilmMoves, polls, p.code};
      return kGood;
    case kOpUnload:
      operation_ = Operation{kFilmMoves, polls, p.code};
      return kGood;
    default:
      break;
  }
  operation_ = Operation{kOperationRuns, polls, p.code};
  return kGood;
}

void Unit::finish_operation(std::uint8_t code) {
  switch (code) {
    case kOpInitialise:
      power_on();
      attend(kPowerOn);
      break;
    case kOpAutofocus:
      if (spec_.unit.focus_fails) {
        deferred_error_ = kOutOfFocus;
      } else {
        focus_ = kBestFocus;
      }
      break;
    case kOpUnload:
      adapter_.film_present = false;
      adapter_.counted_frames = 0;
      frames_ = new_frames();
      break;
    case kOpLoad:
      if (adapter_.kind == AdapterKind::kFeeder) --slides_left_;
      insert_film();
      break;
    default:
      break;
  }
}

void Unit::insert_film() {
  adapter_.film_present = true;
  adapter_.counted_frames = 0;
  frames_ = new_frames();
  focus_ = kFocusAfterLoading;
  attend(kMediumChanged);
  attend(kInquiryChanged);
}

}  // namespace reseau::sim
