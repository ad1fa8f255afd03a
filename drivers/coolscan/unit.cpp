#include "drivers/coolscan/unit.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"

namespace reseau::coolscan {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPoll = 100ms;
// A cold unit answers its first command after tens of seconds.
constexpr Duration kFirstCommandTimeout = 180s;
// SET WINDOW and SCAN may move the stage.
constexpr Duration kMotionTimeout = 180s;
constexpr Duration kAbortTimeout = 60s;
constexpr int kMaxAttentions = 16;
constexpr int kMaxHandshakes = 16;
constexpr std::size_t kMaxDataBytes = 1 << 20;

bool starting_up(const Sense& sense) {
  return sense.is(2, 5, 0) || sense.is(0xB, 0x3E, 0) || sense.is(2, 4, 0);
}
bool running(const Sense& sense) { return sense.is(2, 4, 1); }
bool refused(const Sense& sense) { return sense.is(SenseKey::kIllegalRequest); }
bool out_of_sequence(const Sense& sense) { return sense.is(5, 0x2C, 0); }

DeviceError protocol_error(const std::string& what) {
  return {DeviceError::Kind::kProtocol,
          "The scanner gave an answer that this program does not understand. Please record the "
          "session with --record and report it.",
          what};
}

}  // namespace

ScsiReply Unit::run(const Cdb& asked, ByteView out, std::span<std::byte> in, Duration timeout) {
  const Cdb cdb = errata_.zero_control ? asked.with_control(0) : asked;
  for (int attentions = 0;; ++attentions) {
    const ScsiReply reply = !out.empty()  ? scsi_.send(cdb, out, timeout)
                            : !in.empty() ? scsi_.receive(cdb, in, timeout)
                                          : scsi_.command(cdb, timeout);
    // The unit did not execute the command; several attentions queue up.
    if (reply.good || !reply.sense.is(SenseKey::kUnitAttention)) return reply;
    attention_ = true;
    if (attentions == kMaxAttentions) throw sense_error(reply.sense, cdb.describe());
  }
}

ScsiReply Unit::require(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout) {
  const ScsiReply reply = run(cdb, out, in, timeout);
  if (!reply.good && !reply.sense.is(SenseKey::kRecovered)) {
    throw sense_error(reply.sense, cdb.describe());
  }
  if (reply.received != in.size()) throw protocol_error(cdb.describe() + ": no data");
  return reply;
}

void Unit::require_idle(const Cdb& cdb, ByteView out) {
  const ScsiReply reply = run(cdb, out, {}, kCommandTimeout);
  if (reply.good) return;
  if (!out_of_sequence(reply.sense)) throw sense_error(reply.sense, cdb.describe());
  scan_open_ = true;
  abort_open_scan();
  require(cdb, out, {}, kCommandTimeout);
}

Unit::Ready Unit::wait_ready(Duration limit, const std::stop_token& stop) {
  const TimePoint until = clock_.now() + limit;
  bool aborted = false;
  for (;;) {
    const ScsiReply reply = run(test_unit_ready(), {}, {}, kCommandTimeout);
    last_sense_ = reply.sense;
    if (reply.good) return Ready::kGood;
    if (reply.sense.no_medium()) return Ready::kNoMedium;
    if (reply.sense.out_of_focus()) return Ready::kOutOfFocus;
    if (reply.sense.is(2, 4, 2)) {
      // Not ready after a failed operation: SEND DIAGNOSTIC tells the cause, once.
      const ScsiReply cause = run(send_diagnostic(), {}, {}, kCommandTimeout);
      if (cause.sense.out_of_focus()) return Ready::kOutOfFocus;
      throw sense_error(cause.good ? reply.sense : cause.sense, test_unit_ready().describe());
    }
    if (out_of_sequence(reply.sense) && !aborted) {
      aborted = true;
      require_command(abort_scan());
      scan_open_ = false;
      continue;
    }
    if (!running(reply.sense) && !starting_up(reply.sense)) {
      throw sense_error(reply.sense, test_unit_ready().describe());
    }
    if (clock_.now() >= until) {
      throw DeviceError(DeviceError::Kind::kTimeout, sentence_of(reply.sense),
                        "TEST UNIT READY: still not ready at the deadline");
    }
    if (stop.stop_requested()) return Ready::kStopped;
    clock_.sleep_for(kPoll);
  }
}

Bytes Unit::read_inquiry() {
  Bytes data(kInquiryBytes);
  require(inquiry(), {}, data, kFirstCommandTimeout);
  return data;
}

std::optional<Bytes> Unit::read_page(std::uint8_t page) {
  Bytes head(kPageHeadBytes);
  const Cdb cdb = inquiry_page(page, head.size());
  const ScsiReply reply = run(cdb, {}, head, kCommandTimeout);
  if (refused(reply.sense)) return std::nullopt;
  if (!reply.good) throw sense_error(reply.sense, cdb.describe());
  if (reply.received != head.size()) throw protocol_error(cdb.describe() + ": no whole head");
  // [1] is the page code; a page of an adapter that is not there comes back without content.
  const std::size_t n_bytes = std::min<std::size_t>(kPageHeadBytes + u8_at(head, 3), 0xFF);
  Bytes data(n_bytes);
  require(inquiry_page(page, n_bytes), {}, data, kCommandTimeout);
  if (u8_at(data, 1) != page)
    throw protocol_error("INQUIRY page " + std::to_string(int{page}) + " answered as " +
                         hex_of(data));
  return data;
}

void Unit::reserve() {
  const ScsiReply reply = run(reserve_unit(), {}, {}, kCommandTimeout);
  if (reply.good || reply.sense.is(5, 0x20, 0)) return;
  require_idle(reserve_unit(), {});
}

void Unit::release() { require_command(release_unit()); }

void Unit::set_units_per_inch(int dpi) {
  if (errata_.short_mode_select) {
    require_idle(short_mode_select(), short_mode_select_data(dpi));
  } else {
    require_idle(mode_select(), mode_select_data(dpi));
  }
}

std::optional<Bytes> Unit::read_data(DataType type, Colour colour) {
  const int element = element_code(type, 1);
  Bytes head(kDataHeadBytes);
  const Cdb cdb = read(type, colour, element, head.size());
  const ScsiReply reply = run(cdb, {}, head, kCommandTimeout);
  if (refused(reply.sense)) return std::nullopt;
  if (!reply.good) throw sense_error(reply.sense, cdb.describe());
  if (reply.received != head.size()) throw protocol_error(cdb.describe() + ": no whole head");
  const std::size_t n_bytes = data_length(head);
  if (n_bytes > kMaxDataBytes) throw protocol_error(cdb.describe() + " → " + hex_of(head));
  if (n_bytes == 0) return head;
  Bytes data(kDataHeadBytes + n_bytes);
  require(read(type, colour, element, data.size()), {}, data, kCommandTimeout);
  return data;
}

void Unit::send_table(Colour colour, ByteView table) {
  const DataType type = DataType::kLookUpTable;
  require(send(type, colour, element_code(type, 2), table.size()), table, {}, kCommandTimeout);
}

void Unit::send_data(DataType type, Colour colour, ByteView data) {
  require(send(type, colour, element_code(type, 1), data.size()), data, {}, kMotionTimeout);
}

void Unit::set_window(const Window& window) {
  if (bounds_) {
    const StageBounds& b = *bounds_;
    const bool across = window.x_px >= 0 && window.width_px > 0 &&
                        window.width_px <= b.max_width_px &&
                        window.x_px + window.width_px <= b.x_end_px;
    const bool along = window.y_px >= b.y_min_px && window.height_px > 0 &&
                       (b.y_end_px == 0 || window.y_px + window.height_px <= b.y_end_px);
    if (!across || !along) {
      throw DeviceError(DeviceError::Kind::kRefused,
                        "That area lies outside what the scanner's stage can reach, and going "
                        "there could jam it. Choose a smaller area or another frame.",
                        "window at " + std::to_string(window.y_px) + " of " +
                            std::to_string(window.height_px) + " lines, limit " +
                            std::to_string(b.y_end_px));
    }
  }
  const ScsiReply reply =
      require(coolscan::set_window(), encode_window(window), {}, kMotionTimeout);
  if (reply.good) return;
  // Done with a remark: the unit rounded something. Plans ask for exact values only.
  const std::optional<Window> applied = get_window(window.colour);
  if (!applied || applied->resolution_dpi != window.resolution_dpi) {
    throw protocol_error("SET WINDOW was rounded: " + reply.sense.code());
  }
}

std::optional<Window> Unit::find_window(Colour colour) {
  // Asking for more than there is is refused, too: first the length, then all.
  Bytes head(8);
  require(get_all_windows(head.size()), {}, head, kCommandTimeout);
  const std::size_t n_bytes = 2 + load_be(head, 0, 2);
  const std::size_t descriptor = load_be(head, 6, 2);
  if (n_bytes <= head.size() || descriptor == 0) return std::nullopt;
  Bytes data(n_bytes);
  require(get_all_windows(n_bytes), {}, data, kCommandTimeout);
  for (std::size_t at = head.size(); at + descriptor <= data.size(); at += descriptor) {
    if (u8_at(data, at) != static_cast<std::uint8_t>(colour)) continue;
    return decode_window(ByteView(data).subspan(at - head.size()));
  }
  return std::nullopt;
}

std::optional<Window> Unit::get_window(Colour colour) {
  if (errata_.all_windows_only) return find_window(colour);
  Bytes data(kWindowBytes);
  require(coolscan::get_window(colour), {}, data, kCommandTimeout);
  return decode_window(data);
}

bool Unit::begin(Operation operation, const Parameters& parameters) {
  Parameters safe = parameters;
  if (bounds_ && operation == Operation::kMoveFocus) {
    safe.first = std::clamp(safe.first, static_cast<std::uint32_t>(bounds_->focus_min),
                            static_cast<std::uint32_t>(bounds_->focus_max));
  }
  const Bytes data = parameter_data(safe);
  require(set_parameter(operation), data, {}, kCommandTimeout);
  const ScsiReply reply = run(execute(), {}, {}, kCommandTimeout);
  if (reply.sense.out_of_focus()) return false;
  if (!reply.good) throw sense_error(reply.sense, execute().describe());
  return true;
}

Unit::Ready Unit::perform(Operation operation, const Parameters& parameters, Duration limit) {
  return begin(operation, parameters) ? wait_ready(limit) : Ready::kOutOfFocus;
}

bool Unit::wait_for_film(bool present, Duration limit) {
  const TimePoint until = clock_.now() + limit;
  for (;;) {
    const Ready ready = wait_ready(limit);
    if ((ready == Ready::kGood) == present) return true;
    if (clock_.now() >= until) return false;
    clock_.sleep_for(kPoll);
  }
}

Parameters Unit::get_parameters(Operation operation) {
  Bytes block(kParameterBytes);
  require(get_parameter(operation), {}, block, kCommandTimeout);
  return decode_parameters(block);
}

std::vector<CooperationRecord> Unit::start_scan(const std::vector<Colour>& colours) {
  const Bytes list = scan_data(colours);
  const Cdb cdb = scan(colours.size());
  std::vector<CooperationRecord> records;
  std::vector<Bytes> seen;
  for (int round = 0; round < kMaxHandshakes; ++round) {
    // From here on the unit may have taken the scan, even if its answer gets lost.
    scan_open_ = true;
    const ScsiReply reply = run(cdb, list, {}, kMotionTimeout);
    if (reply.good) {
      const Ready ready = wait_ready(kMotionTimeout);
      if (ready != Ready::kGood) throw sense_error(last_sense_, cdb.describe());
      return records;
    }
    if (!reply.sense.is(SenseKey::kHostAction)) throw sense_error(reply.sense, cdb.describe());
    const std::optional<Bytes> data = read_data(DataType::kCooperation, Colour::kDefault);
    if (!data) throw protocol_error(cdb.describe() + ": no cooperation record");
    if (std::find(seen.begin(), seen.end(), *data) != seen.end()) {
      throw protocol_error("the same cooperation record twice: " + hex_of(*data));
    }
    seen.push_back(*data);
    const std::optional<CooperationRecord> record = parse_cooperation(*data);
    if (!record) throw protocol_error("cooperation record " + hex_of(*data));
    records.push_back(*record);
  }
  throw protocol_error(cdb.describe() + ": asked for help more than 16 times");
}

std::size_t Unit::read_image(std::span<std::byte> out, int bytes_per_sample, Duration timeout) {
  const DataType type = DataType::kImage;
  const Cdb cdb = read(type, Colour::kDefault, element_code(type, bytes_per_sample), out.size());
  const ScsiReply reply = run(cdb, {}, out, timeout);
  if (reply.good) return reply.received;
  if (reply.sense.is(0xB, 0x4B, 0) && reply.sense.short_read) {
    scan_open_ = false;
    return reply.received;
  }
  throw sense_error(reply.sense, cdb.describe());
}

void Unit::abort_open_scan() {
  if (!scan_open_) return;
  // ABORT while the stage moves has wedged units: wait for the motion first.
  const Ready ready = wait_ready(kMotionTimeout);
  if (!scan_open_) return;
  require_command(abort_scan());
  scan_open_ = false;
  if (ready != Ready::kNoMedium) wait_ready(kAbortTimeout);
}

}  // namespace reseau::coolscan
