#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/clock.h"
#include "drivers/coolscan/commands.h"
#include "drivers/coolscan/models.h"
#include "drivers/coolscan/records.h"
#include "drivers/coolscan/window.h"
#include "drivers/scsi/scsi_device.h"

namespace reseau::coolscan {

// What the stage and the film may be told [optical px]: no window and no operation outside it is
// ever sent. Beyond it the stage of some units meets its stop, and only the power switch helps.
struct StageBounds {
  int max_width_px = 0, x_end_px = 0;
  int y_min_px = 0, y_end_px = 0;  // first address, and the one after the last; 0: not known yet
  int focus_min = 0, focus_max = 0;
};

// The sequences of commands that one Coolscan unit understands: waiting, pages, windows, the SCAN
// handshake, image data. Repeats commands that a unit attention displaced. Keeps no picture of the
// scan but whether one is open. Thread-bound; borrows both arguments for its life.
class Unit {
 public:
  Unit(ScsiDevice& scsi, Clock& clock) : scsi_(scsi), clock_(clock) {}

  void apply(const Errata& errata) { errata_ = errata; }
  void bound(const StageBounds& bounds) { bounds_ = bounds; }

  enum class Ready { kGood, kNoMedium, kOutOfFocus, kStopped };
  // Polls until the unit is idle. A stop request ends the wait where waiting can be left; give none
  // while the unit moves. Throws DeviceError when the time is over or the unit failed.
  Ready wait_ready(Duration limit, const std::stop_token& stop = {});
  // Polls until film is in the unit or out of it, for operations that are accepted before they
  // begin. False when the time was over without a motion having failed.
  [[nodiscard]] bool wait_for_film(bool present, Duration limit);
  // Sense of the last kNoMedium, which says why.
  [[nodiscard]] const Sense& last_sense() const { return last_sense_; }

  // True once after the unit reported that film, adapter or settings changed.
  [[nodiscard]] bool take_attention() { return std::exchange(attention_, false); }

  [[nodiscard]] Bytes read_inquiry();
  // A whole INQUIRY page with its 4-byte head. Absent when the unit refuses it.
  [[nodiscard]] std::optional<Bytes> read_page(std::uint8_t page);
  // Tolerates units without reservation; closes a scan that another program left open.
  void reserve();
  void release();
  void set_units_per_inch(int dpi);

  // Data type 80 and up with its 6-byte head. Absent when the unit refuses it.
  [[nodiscard]] std::optional<Bytes> read_data(DataType type, Colour colour);
  void send_table(Colour colour, ByteView table);
  // Other data, without head.
  void send_data(DataType type, Colour colour, ByteView data);
  // Throws DeviceError before anything is sent when the window leaves the bounds.
  void set_window(const Window& window);
  [[nodiscard]] std::optional<Window> get_window(Colour colour);

  // Starts an operation; false when the unit says at once that it found no focus.
  bool begin(Operation operation, const Parameters& parameters);
  // Runs an operation to its end.
  Ready perform(Operation operation, const Parameters& parameters, Duration limit);
  [[nodiscard]] Parameters get_parameters(Operation operation);

  // SCAN with the handshake: acknowledges each job that the unit hands to the host until SCAN is
  // good, then waits until the unit has data.
  [[nodiscard]] std::vector<CooperationRecord> start_scan(const std::vector<Colour>& colours);
  // Returns how many bytes came: all, or fewer when the unit says that the film ended before, and
  // then the scan is over.
  [[nodiscard]] std::size_t read_image(std::span<std::byte> out, int bytes_per_sample,
                                       Duration timeout);

  [[nodiscard]] bool scan_open() const { return scan_open_; }
  // Every line was read: the unit has closed the scan by itself.
  void scan_drained() { scan_open_ = false; }
  // Stops an open scan and waits until the unit is idle.
  void abort_open_scan();

  void annotate(std::string_view phase) { scsi_.annotate(phase); }

 private:
  ScsiReply run(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout);
  // Throws unless the command was done, perhaps with a remark.
  ScsiReply require(const Cdb& cdb, ByteView out, std::span<std::byte> in, Duration timeout);
  void require_command(const Cdb& cdb) { require(cdb, {}, {}, kCommandTimeout); }
  // As require; when a scan of another program is in the way, aborts it once.
  void require_idle(const Cdb& cdb, ByteView out);

  [[nodiscard]] std::optional<Window> find_window(Colour colour);

  static constexpr Duration kCommandTimeout = std::chrono::seconds(30);

  ScsiDevice& scsi_;
  Clock& clock_;
  Errata errata_;
  std::optional<StageBounds> bounds_;
  Sense last_sense_;
  bool attention_ = false;
  bool scan_open_ = false;
};

}  // namespace reseau::coolscan
