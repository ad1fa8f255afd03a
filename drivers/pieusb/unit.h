#pragma once

#include <optional>
#include <stop_token>
#include <string_view>
#include <vector>

#include "core/base/clock.h"
#include "drivers/pieusb/commands.h"
#include "drivers/pieusb/models.h"
#include "drivers/pieusb/replies.h"
#include "drivers/scsi/scsi_device.h"

namespace reseau::pieusb {

// Lines for the next READ when so many of line_bytes each are left: as many as the vendor's program
// asks for, never the number that has made a unit fall silent. Pure.
[[nodiscard]] int lines_for_read(int lines_left, std::size_t line_bytes);

// What one pass shall be set to.
struct PassSetup {
  ScanFrame frame;
  Mode mode;
  GainOffset gain;
};

// The sequences of commands that one unit understands: waiting, settings, SCAN, lines, film. Knows
// what of a pass is still in the unit, so that finish_pass() can take it out: a pass that is
// abandoned hangs the unit until it is switched off. Thread-bound; borrows both arguments.
class Unit {
 public:
  Unit(ScsiDevice& scsi, Clock& clock) : scsi_(scsi), clock_(clock) {}

  [[nodiscard]] Inquiry read_inquiry();
  void set_model(const Model& model, bool confirms_frame);

  // Polls until the lamp is warm. False when stopped. Throws DeviceError when the time is over.
  bool wait_warm(Duration limit, const std::stop_token& stop = {});
  // Polls until the unit takes commands again. False when stopped.
  bool wait_idle(Duration limit, const std::stop_token& stop = {});
  [[nodiscard]] State read_state();
  [[nodiscard]] GainReference read_gain();
  [[nodiscard]] CalibrationInfo read_calibration_info();
  [[nodiscard]] std::vector<int> read_mask(int n_pixels);
  [[nodiscard]] ScanParameters read_parameters();

  // Everything that stands before SCAN.
  void set_up(const PassSetup& setup);
  enum class Started { kImage, kCalibrationFirst, kStopped };
  // SCAN, again while the lamp warms up; then waits until lines can be read.
  Started start_scan(const std::stop_token& stop);

  // Calibration lines that a pass may begin with.
  void set_calibration_shape(int n_lines, std::size_t line_bytes);
  // The pass that start_scan() will start has calibration lines only, at most so many.
  void expect_calibration_pass(int most_lines);
  // What the image of the pass that was started holds.
  void expect_image(int n_lines, std::size_t line_bytes);
  // The next lines, whole. Empty when the unit has no more. Throws DeviceError.
  [[nodiscard]] ByteView read_calibration_lines(int most);
  [[nodiscard]] ByteView read_image_lines();
  [[nodiscard]] int image_lines_left() const { return image_.lines_left; }

  [[nodiscard]] bool pass_open() const { return pass_open_; }
  // Reads and drops what the unit still holds of the pass. Throws DeviceError when it cannot.
  void finish_pass();

  // Moves a film strip to a frame, counted from 0. False when stopped.
  bool move_to_frame(int frame, const std::stop_token& stop);

  void annotate(std::string_view phase) { scsi_.annotate(phase); }

 private:
  // Lines of one kind that are still in the unit. line_bytes 0: not known yet.
  struct Pending {
    int lines_left = 0;
    std::size_t line_bytes = 0;
  };
  // Runs a command to its good end; a power-on notice in between is passed over.
  void run(const Cdb& cdb, ByteView out = {});
  [[nodiscard]] Bytes ask(Op op, std::size_t n_bytes);
  ScsiReply receive(const Cdb& cdb, std::span<std::byte> in);
  [[nodiscard]] ByteView read_lines(Pending& pending, int n);
  void slide(SlideAction action);
  // Whether the unit has lines to give.
  [[nodiscard]] bool pass_is_open();

  ScsiDevice& scsi_;
  Clock& clock_;
  Model model_;
  bool confirms_frame_ = false;
  bool pass_open_ = false;
  bool infrared_ = false;  // of the pass
  Pending calibration_, image_, shape_;
  Bytes buffer_;
};

}  // namespace reseau::pieusb
