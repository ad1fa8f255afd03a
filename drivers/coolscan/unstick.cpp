#include "drivers/coolscan/unstick.h"

#include <exception>

#include "core/base/error.h"
#include "drivers/coolscan/commands.h"
#include "drivers/coolscan/unit.h"

namespace reseau::coolscan {
namespace {

using namespace std::chrono_literals;

constexpr Duration kQuick = 10s;
constexpr Duration kMotion = 180s;

class Ladder {
 public:
  Ladder(ScsiDevice& scsi, Clock& clock, const UnstickLog& log)
      : scsi_(scsi), clock_(clock), log_(log), unit_(scsi, clock) {}

  Unstuck climb() {
    // The first command also drains what an earlier program left in the pipe.
    if (!attempt("ask who it is", [&] { (void)unit_.read_inquiry(); })) return power_switch();
    if (ready("ask whether it is idle")) {
      return open_scan_ ? Unstuck::kMended : Unstuck::kWasFine;
    }
    if (attempt("end an open scan", [&] { end_scan(); }) && ready("ask again")) {
      return Unstuck::kMended;
    }
    if (operate("send the stage to its origin", Operation::kReturnToOrigin) && ready("ask again")) {
      return Unstuck::kMended;
    }
    if (operate("start it anew", Operation::kInitialise) && ready("ask again")) {
      return Unstuck::kMended;
    }
    return power_switch();
  }

 private:
  template <typename Do>
  bool attempt(const std::string& what, Do act) {
    try {
      act();
      log_(what, "done");
      return true;
    } catch (const std::exception& error) {
      log_(what, error.what());
      return false;
    }
  }

  // Idle, with or without film. A motion that runs is waited for: to abort it has wedged units.
  bool ready(const std::string& what) {
    const TimePoint until = clock_.now() + kMotion;
    try {
      for (;;) {
        const ScsiReply reply = scsi_.command(test_unit_ready(), kQuick);
        const bool idle = reply.good || reply.sense.no_medium();
        if (idle && !probe_open_scan()) {
          log_(what, reply.good ? "ready" : sentence_of(reply.sense));
          return true;
        }
        const bool busy = reply.sense.is(2, 4, 1) || reply.sense.is(2, 4, 0) ||
                          reply.sense.is(2, 5, 0) || reply.sense.is(0xB, 0x3E, 0) ||
                          reply.sense.is(SenseKey::kUnitAttention);
        if (!busy || clock_.now() >= until) {
          log_(what, idle ? "a scan is open" : sentence_of(reply.sense));
          return false;
        }
        clock_.sleep_for(100ms);
      }
    } catch (const std::exception& error) {
      log_(what, error.what());
      return false;
    }
  }

  // A scan that was left open lets TEST UNIT READY through and refuses whatever moves something.
  bool probe_open_scan() {
    Bytes reply(kParameterBytes);
    const ScsiReply answer = scsi_.receive(get_parameter(Operation::kMoveFocus), reply, kQuick);
    if (answer.good || !answer.sense.is(5, 0x2C, 0)) return false;
    open_scan_ = true;
    return true;
  }

  void end_scan() {
    open_scan_ = true;
    const ScsiReply reply = scsi_.command(abort_scan(), kQuick);
    if (!reply.good) throw sense_error(reply.sense, abort_scan().describe());
  }

  bool operate(const std::string& what, Operation operation) {
    return attempt(what, [&] { (void)unit_.perform(operation, {}, kMotion); });
  }

  Unstuck power_switch() {
    log_("nothing more can be sent", "switch the scanner off, wait ten seconds, switch it on");
    return Unstuck::kNeedsPowerSwitch;
  }

  ScsiDevice& scsi_;
  Clock& clock_;
  const UnstickLog& log_;
  Unit unit_;
  bool open_scan_ = false;
};

}  // namespace

Unstuck unstick(ScsiDevice& scsi, Clock& clock, const UnstickLog& log) {
  return Ladder(scsi, clock, log).climb();
}

}  // namespace reseau::coolscan
