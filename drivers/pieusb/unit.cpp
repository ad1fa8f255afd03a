#include "drivers/pieusb/unit.h"

#include <algorithm>
#include <string>

#include "core/base/check.h"
#include "core/base/error.h"
#include "drivers/pieusb/never.h"
#include "drivers/pieusb/sense.h"

namespace reseau::pieusb {
namespace {

using namespace std::chrono_literals;

// Any command but READ. A unit may hold one up while it moves.
constexpr Duration kPieCommandTimeout = 60s;
// A READ waits for the sensor's lines.
constexpr Duration kPieReadTimeout = 120s;
constexpr Duration kStatePoll = 1s;
constexpr Duration kReadyPoll = 2s;
constexpr Duration kReadyLimit = 120s;
constexpr Duration kScanAgain = 5s;
constexpr Duration kWarmUpLimit = 180s;
// A frame takes 7 s.
constexpr Duration kFrameLimit = 60s;
constexpr int kPowerOnNotices = 3;

DeviceError lost_data(const Cdb& cdb) {
  return {DeviceError::Kind::kProtocol,
          "Part of the scanner's data got lost on the cable. Scan again; if it happens again, try "
          "another cable or port, without a hub.",
          describe(cdb)};
}

// Not about the command that it answers: the unit was switched on, or another program left before
// it had read what its SCAN was answered.
bool is_notice(const Sense& sense) { return power_on(sense) || must_calibrate(sense); }

}  // namespace

int lines_for_read(int lines_left, std::size_t line_bytes) {
  const std::size_t by_bytes = std::max<std::size_t>(1, kMaxReadBytes / line_bytes);
  const int n = std::min({lines_left, kMaxReadLines, static_cast<int>(by_bytes)});
  return n == kCursedLines ? kCursedLines - 1 : n;
}

ScsiReply Unit::receive(const Cdb& cdb, std::span<std::byte> in) {
  ScsiReply reply;
  for (int notice = 0; notice < kPowerOnNotices; ++notice) {
    reply = scsi_.receive(cdb, in, kPieCommandTimeout);
    if (reply.good || !is_notice(reply.sense)) break;
  }
  return reply;
}

Bytes Unit::ask(Op op, std::size_t n_bytes) {
  Bytes bytes(n_bytes);
  const Cdb cdb = command_of(op, static_cast<int>(n_bytes));
  const ScsiReply reply = receive(cdb, bytes);
  if (!reply.good) throw pie_error(reply.sense, describe(cdb));
  if (reply.received < bytes.size()) throw lost_data(cdb);
  return bytes;
}

void Unit::run(const Cdb& cdb, ByteView out) {
  ScsiReply reply;
  for (int notice = 0; notice < kPowerOnNotices; ++notice) {
    reply = out.empty() ? scsi_.command(cdb, kPieCommandTimeout)
                        : scsi_.send(cdb, out, kPieCommandTimeout);
    if (reply.good) return;
    if (!is_notice(reply.sense)) break;
  }
  throw pie_error(reply.sense, describe(cdb));
}

Inquiry Unit::read_inquiry() {
  constexpr std::size_t kHeadBytes = 5;
  const std::size_t length = inquiry_length(ask(Op::kInquiry, kHeadBytes));
  return parse_inquiry(ask(Op::kInquiry, std::max(length, kHeadBytes)));
}

void Unit::set_model(const Model& model, bool confirms_frame) {
  model_ = model;
  confirms_frame_ = confirms_frame;
}

State Unit::read_state() {
  return parse_state(ask(Op::kReadState, static_cast<std::size_t>(model_.dialect.state_bytes)),
                     model_.dialect.reports_film);
}

bool Unit::wait_warm(Duration limit, const std::stop_token& stop) {
  const TimePoint until = clock_.now() + limit;
  while (read_state().warming_up) {
    if (stop.stop_requested()) return false;
    if (clock_.now() >= until) {
      throw DeviceError(DeviceError::Kind::kTimeout,
                        "The scanner's lamp does not get warm. Switch the scanner off, wait ten "
                        "seconds and switch it on again.",
                        "READ STATE");
    }
    clock_.sleep_for(kStatePoll);
  }
  return true;
}

bool Unit::wait_idle(Duration limit, const std::stop_token& stop) {
  const TimePoint until = clock_.now() + limit;
  const Cdb cdb = command_of(Op::kTestUnitReady);
  while (true) {
    const ScsiReply reply = scsi_.command(cdb, kPieCommandTimeout);
    if (reply.good) return true;
    const bool wait = reply.sense.is(SenseKey::kNotReady) || is_notice(reply.sense);
    if (!wait) throw pie_error(reply.sense, describe(cdb));
    if (stop.stop_requested()) return false;
    if (clock_.now() >= until) {
      throw DeviceError(DeviceError::Kind::kTimeout,
                        "The scanner does not become ready. Switch it off, wait ten seconds and "
                        "switch it on again.",
                        describe(cdb) + ": " + pie_sentence(reply.sense));
    }
    clock_.sleep_for(kReadyPoll);
  }
}

GainReference Unit::read_gain() {
  return parse_gain(ask(Op::kReadGain, static_cast<std::size_t>(model_.dialect.gain_bytes)));
}

CalibrationInfo Unit::read_calibration_info() {
  const Bytes question = prepare_calibration_info_data();
  run(command_of(Op::kWrite, static_cast<int>(question.size())), question);
  return parse_calibration_info(ask(Op::kRead, kCalibrationInfoBytes));
}

std::vector<int> Unit::read_mask(int n_pixels) {
  return parse_mask(ask(Op::kCopy, static_cast<std::size_t>(n_pixels)));
}

ScanParameters Unit::read_parameters() {
  return parse_parameters(ask(Op::kGetParameters, kParameterBytes));
}

void Unit::set_up(const PassSetup& setup) {
  const auto write = [this](const Bytes& data) {
    run(command_of(Op::kWrite, static_cast<int>(data.size())), data);
  };
  if (model_.dialect.sends_percentages) {
    for (const int sub_command : {0x13, 0x14}) {
      for (const int filter : {2, 4, 8}) write(filter_percentage_data(sub_command, filter));
    }
  }
  const Bytes gain = gain_data(setup.gain);
  run(command_of(Op::kWriteGain, static_cast<int>(gain.size())), gain);
  write(scan_frame_data(setup.frame));
  if (confirms_frame_) write(confirm_frame_data());
  wait_idle(kReadyLimit);
  const Bytes mode = mode_data(setup.mode);
  run(command_of(Op::kModeSelect, static_cast<int>(mode.size())), mode);
  infrared_ = setup.mode.infrared;
  calibration_ = image_ = {};
}

Unit::Started Unit::start_scan(const std::stop_token& stop) {
  if (model_.transport != Transport::kNone) slide(SlideAction::kInitialise);
  const Cdb cdb = command_of(Op::kScan, 1);
  const TimePoint until = clock_.now() + kWarmUpLimit;
  while (true) {
    pass_open_ = true;  // until the unit says otherwise
    const ScsiReply reply = scsi_.command(cdb, kPieCommandTimeout);
    const bool lost = !reply.good && reply.sense == kUnknownSense;
    // A pass that is open although SCAN was not good begins with its calibration.
    const bool calibrates = must_calibrate(reply.sense) || (lost && pass_is_open());
    if (calibrates && !model_.dialect.calibrates_in_own_pass) calibration_ = shape_;
    if (reply.good || calibrates) {
      // What a unit that calibrates in a pass of its own says here is a refusal.
      pass_open_ = reply.good || !model_.dialect.calibrates_in_own_pass;
      if (pass_open_) wait_idle(kReadyLimit);
      return reply.good ? Started::kImage : Started::kCalibrationFirst;
    }
    pass_open_ = false;
    const bool wait = warming_up(reply.sense) || power_on(reply.sense);
    if (!wait || clock_.now() >= until) throw pie_error(reply.sense, describe(cdb));
    if (stop.stop_requested()) return Started::kStopped;
    clock_.sleep_for(kScanAgain);
  }
}

bool Unit::pass_is_open() {
  try {
    (void)read_parameters();
    return true;
  } catch (const DeviceError& error) {
    if (error.kind() != DeviceError::Kind::kRefused) throw;
    return false;
  }
}

void Unit::set_calibration_shape(int n_lines, std::size_t line_bytes) {
  shape_ = {n_lines, line_bytes};
}

void Unit::expect_calibration_pass(int most_lines) {
  calibration_ = {most_lines, shape_.line_bytes};
}

void Unit::expect_image(int n_lines, std::size_t line_bytes) { image_ = {n_lines, line_bytes}; }

ByteView Unit::read_calibration_lines(int most) {
  return read_lines(calibration_, std::min(most, lines_for_read(calibration_.lines_left,
                                                                calibration_.line_bytes)));
}

ByteView Unit::read_image_lines() {
  return read_lines(image_, lines_for_read(image_.lines_left, image_.line_bytes));
}

ByteView Unit::read_lines(Pending& pending, int n) {
  if (n <= 0) return {};
  const Cdb cdb = command_of(Op::kRead, n);
  const std::size_t n_bytes = static_cast<std::size_t>(n) * pending.line_bytes;
  if (buffer_.size() < n_bytes) buffer_.resize(n_bytes);
  const auto in = std::span(buffer_).first(n_bytes);
  const TimePoint until = clock_.now() + kPieReadTimeout;
  ScsiReply reply;
  while (true) {
    reply = scsi_.receive(cdb, in, kPieReadTimeout);
    if (reply.good) break;
    if (no_more_lines(reply.sense)) {
      pending.lines_left = 0;
      if (&pending == &image_ || model_.dialect.calibrates_in_own_pass) pass_open_ = false;
      return {};
    }
    if (!reply.sense.is(SenseKey::kNotReady) || clock_.now() >= until) {
      throw pie_error(reply.sense, describe(cdb));
    }
    clock_.sleep_for(kReadyPoll);
  }
  pending.lines_left -= n;
  if (image_.lines_left == 0 && image_.line_bytes > 0) pass_open_ = false;
  if (reply.received < in.size()) throw lost_data(cdb);
  return in;
}

void Unit::finish_pass() {
  if (!pass_open_) return;
  while (calibration_.lines_left > 0) {
    if (read_calibration_lines(kMaxReadLines).empty()) break;
  }
  if (!pass_open_) return;
  if (image_.line_bytes == 0) {
    // The pass broke off before its size was known, or never began.
    if (!pass_is_open()) {
      pass_open_ = false;
      return;
    }
    const ScanParameters parameters = read_parameters();
    expect_image(parameters.n_lines * (infrared_ ? 4 : 3),
                 static_cast<std::size_t>(parameters.line_bytes) + 2);
  }
  while (pass_open_ && image_.lines_left > 0) {
    if (read_image_lines().empty()) break;
  }
  pass_open_ = false;
}

void Unit::slide(SlideAction action) {
  CHECK(model_.transport != Transport::kNone);
  run(command_of(Op::kSlide, 4), slide_data(action));
}

bool Unit::move_to_frame(int frame, const std::stop_token& stop) {
  if (model_.transport != Transport::kFilmStrip) return true;
  int now = read_state().frame;
  while (now != frame) {
    if (stop.stop_requested()) return false;
    slide(frame > now ? SlideAction::kNext : SlideAction::kPrevious);
    const int expected = now + (frame > now ? 1 : -1);
    const TimePoint until = clock_.now() + kFrameLimit;
    while ((now = read_state().frame) != expected) {
      if (clock_.now() >= until) {
        throw DeviceError(DeviceError::Kind::kHardware,
                          "The film does not move. Take it out with the scanner's own key, put it "
                          "in again and start again.",
                          "frame counter " + std::to_string(now));
      }
      clock_.sleep_for(kStatePoll);
    }
  }
  return true;
}

}  // namespace reseau::pieusb
